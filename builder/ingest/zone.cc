#include "builder/ingest/zone.h"

#include <fmt/format.h>

#include <regex>

#include "builder/error.h"

namespace landfix::ingest {

tiles::Zone parse_zone(const std::string& text) {
  static const std::regex kPattern("([0-9]{1,2})([NnSs])");
  std::smatch match;
  if (std::regex_match(text, match, kPattern)) {
    const tiles::Zone zone{std::stoi(match[1]), match[2] == "N" || match[2] == "n"};
    if (tiles::is_valid(zone)) return zone;
  }
  throw Error(
      ExitCode::kUsage,
      fmt::format("zone \"{}\": expected a UTM zone with its hemisphere, 1N to 60N or 1S to 60S, or 0N or 0S for UPS",
                  text));
}

std::string zone_text(const tiles::Zone& zone) { return fmt::format("{}{}", zone.number, zone.north ? 'N' : 'S'); }

}  // namespace landfix::ingest
