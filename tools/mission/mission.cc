#include "tools/mission/mission.h"

#include <fmt/format.h>

#include <cmath>

#include "builder/error.h"

namespace landfix::mission {
namespace {

constexpr size_t kMaxFlown = 100000;

}  // namespace

const char* to_string(AltitudeReference reference) {
  switch (reference) {
    case AltitudeReference::kNone:
      return "none";
    case AltitudeReference::kEllipsoid:
      return "ellipsoid";
    case AltitudeReference::kSeaLevel:
      return "sea_level";
    case AltitudeReference::kHome:
      return "home";
    case AltitudeReference::kTerrain:
      return "terrain";
  }
  return "none";
}

Flight flown(const Mission& mission) {
  Flight flight;
  std::vector<int> taken(mission.jumps.size(), 0);
  size_t waypoint = 0, jump = 0;
  // Every jump that is taken counts, so that jumps over no waypoint at all cannot go on for ever either.
  for (size_t steps = 0;; ++steps) {
    if (steps > kMaxFlown) {
      throw Error(
          ExitCode::kBadInput,
          fmt::format("{}: expected a flight of at most {} waypoints, found more by the jumps of item {}; lower "
                      "their repeat counts",
                      mission.file, kMaxFlown, mission.jumps.empty() ? 0 : mission.jumps.front().item));
    }
    if (jump < mission.jumps.size() && mission.jumps[jump].at == waypoint) {
      const Jump& next = mission.jumps[jump];
      const bool forever = next.repeats == Jump::kForever;
      if (forever && taken[jump] > 0) {
        flight.endless = true;
        return flight;
      }
      if (forever || taken[jump] < next.repeats) {
        ++taken[jump];
        waypoint = next.to;
        jump = next.to_jump;
      } else {
        ++jump;
      }
      continue;
    }
    if (waypoint >= mission.waypoints.size()) return flight;
    const Waypoint& here = mission.waypoints[waypoint];
    flight.waypoints.push_back(waypoint++);
    if (here.action == Action::kReturn || std::isinf(here.hold_s)) return flight;
  }
}

}  // namespace landfix::mission
