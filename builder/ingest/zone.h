// The zone of a build as people write it.
#pragma once

#include <string>

#include "tiles/geodesy.h"

namespace landfix::ingest {

/// "36N", "36S"; "0N" and "0S" are UPS. Throws Error (kUsage) for anything else.
tiles::Zone parse_zone(const std::string& text);

/// Inverse of parse_zone.
std::string zone_text(const tiles::Zone& zone);

}  // namespace landfix::ingest
