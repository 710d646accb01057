// A pack's manifest as JSON, the one form in which the tools show it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "landfix/landfix.hpp"
#include "tiles/geodesy.h"

namespace landfix::tools {

/// Everything the runtime knows of a pack; keys are documented in docs/command-line.md. Unknown values are null.
nlohmann::ordered_json manifest_json(const Pack& pack);

/// The pack's zone, and its name for people: "36N", "UPS north".
tiles::Zone zone_of(const Pack& pack);
std::string zone_name(const tiles::Zone& zone);

}  // namespace landfix::tools
