#include "tools/mission/route.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "builder/error.h"

namespace landfix::mission {
namespace {

// Ten times the longest surveys; what a flight is scored along must stay small.
constexpr size_t kMaxWaypoints = 100000;
constexpr int kMaxRepeats = 65535;

std::optional<Action> action_of(int command) {
  switch (command) {
    case kWaypointCommand:
    case kSplineCommand:
    case kPayloadPlaceCommand:
      return Action::kPass;
    case kLoiterCommand:
    case kLoiterTurnsCommand:
    case kLoiterTimeCommand:
    case kLoiterToAltitudeCommand:
      return Action::kLoiter;
    case kTakeoffCommand:
    case kVtolTakeoffCommand:
      return Action::kTakeoff;
    case kLandCommand:
    case kVtolLandCommand:
      return Action::kLand;
    case kReturnCommand:
      return Action::kReturn;
    default:
      return std::nullopt;
  }
}

/// Global frames only: the others have their origin where the vehicle starts, or none.
AltitudeReference reference_of(int frame) {
  switch (frame) {
    case 0:
    case 5:
      return AltitudeReference::kSeaLevel;
    case 3:
    case 6:
      return AltitudeReference::kHome;
    case 10:
    case 11:
      return AltitudeReference::kTerrain;
    default:
      return AltitudeReference::kNone;
  }
}

double positive_or_zero(double value) { return value > 0 ? value : 0; }

/// Hold time, turns and radius, by the parameters that each command has for them.
void set_circles(Waypoint& waypoint, const MissionItem& item) {
  const auto& p = item.params;
  switch (item.command) {
    case kWaypointCommand:
    case kSplineCommand:
      waypoint.hold_s = positive_or_zero(p[0]);
      break;
    case kLoiterCommand:
      waypoint.hold_s = std::numeric_limits<double>::infinity();
      waypoint.radius_m = p[2];
      break;
    case kLoiterTurnsCommand:
      waypoint.turns = positive_or_zero(p[0]);
      waypoint.radius_m = p[2];
      break;
    case kLoiterTimeCommand:
      waypoint.hold_s = positive_or_zero(p[0]);
      waypoint.radius_m = p[2];
      break;
    case kLoiterToAltitudeCommand:
      waypoint.radius_m = p[1];
      break;
    default:
      break;
  }
  if (std::isnan(waypoint.radius_m)) waypoint.radius_m = 0;
}

/// Without both, or at 0, 0: how ground stations say that an item has no place of its own.
bool has_no_position(const MissionItem& item) {
  const double latitude = item.params[4], longitude = item.params[5];
  return (std::isnan(latitude) && std::isnan(longitude)) || (latitude == 0 && longitude == 0);
}

}  // namespace

Position checked_position(const std::string& file, const std::string& where, double latitude_deg,
                          double longitude_deg) {
  const bool on_earth = std::abs(latitude_deg) <= 90 && std::abs(longitude_deg) <= 180;
  if (on_earth && (latitude_deg != 0 || longitude_deg != 0)) return {latitude_deg, longitude_deg};
  throw Error(
      ExitCode::kBadInput,
      fmt::format("{}: {}: expected a latitude and longitude in degrees, found {}, {}; give the item a position "
                  "or take it out",
                  file, where, latitude_deg, longitude_deg));
}

void Route::refuse(const std::string& where, const std::string& text) const {
  throw Error(ExitCode::kBadInput, fmt::format("{}: {}: {}", mission_.file, where, text));
}

void Route::mark(long id) { ids_.try_emplace(id, Mark{mission_.waypoints.size(), mission_.jumps.size()}); }

void Route::append(Waypoint waypoint, const std::string& where) {
  if (mission_.waypoints.size() >= kMaxWaypoints) {
    refuse(where, fmt::format("expected at most {} waypoints, found more; split the mission", kMaxWaypoints));
  }
  waypoint.speed = speed_;
  speed_.reset();
  mission_.waypoints.push_back(waypoint);
}

void Route::add(const Place& place, size_t item, size_t part) {
  Waypoint waypoint;
  waypoint.place = place;
  waypoint.item = item;
  waypoint.part = part;
  append(waypoint, fmt::format("point {}", item));
}

void Route::add(const MissionItem& item) {
  if (const auto action = action_of(item.command)) return add_flown(item, *action);
  switch (item.command) {
    case kJumpCommand:
    case kJumpToTagCommand:
      return add_jump(item);
    case kJumpTagCommand:
      if (!std::isnan(item.params[0])) {
        tags_.try_emplace(std::lround(item.params[0]), Mark{mission_.waypoints.size(), mission_.jumps.size()});
      }
      return;
    case kChangeSpeedCommand:
      return add_speed(item);
    case kDelayCommand:
      if (!mission_.waypoints.empty()) mission_.waypoints.back().hold_s += positive_or_zero(item.params[0]);
      return;
    default:
      if (item.command > 0 && item.command <= kLastNavCommand) {
        mission_.notes.push_back({item.item, fmt::format("{}: command {} moves the vehicle in a way that the route "
                                                         "does not show",
                                                         item.where, item.command)});
      }
  }
}

bool Route::imply_position(Waypoint& waypoint) {
  waypoint.implied = true;
  const bool from_home = waypoint.action == Action::kReturn || mission_.waypoints.empty();
  if (from_home && !mission_.home) return false;
  waypoint.place.position = from_home ? mission_.home->position : mission_.waypoints.back().place.position;
  return true;
}

void Route::add_flown(const MissionItem& item, Action action) {
  Waypoint waypoint;
  waypoint.action = action;
  waypoint.item = item.item;
  waypoint.part = item.part;
  set_circles(waypoint, item);
  const AltitudeReference reference = reference_of(item.frame);
  const bool placeless = action == Action::kReturn || (action != Action::kPass && has_no_position(item));
  if (!placeless && reference == AltitudeReference::kNone) {
    refuse(item.where, fmt::format("expected a position in a global frame (0, 3, 5, 6, 10 or 11), found command {} in "
                                   "frame {}; places must not depend on where the vehicle starts",
                                   item.command, item.frame));
  }
  // A return climbs to an altitude that is set in the vehicle.
  if (action != Action::kReturn && reference != AltitudeReference::kNone) {
    if (!std::isnan(item.params[6])) {
      waypoint.place.altitude = {item.params[6], reference};
    } else if (item.altitude) {
      waypoint.place.altitude = *item.altitude;
    }
  }
  if (!placeless) {
    waypoint.place.position = checked_position(mission_.file, item.where, item.params[4], item.params[5]);
  } else if (!imply_position(waypoint)) {
    mission_.notes.push_back({item.item, fmt::format("{}: command {} has no position, and the file names no home",
                                                     item.where, item.command)});
    return;
  }
  append(waypoint, item.where);
}

void Route::add_jump(const MissionItem& item) {
  const double target = item.params[0], repeats = item.params[1];
  const bool whole = target == std::floor(target) && repeats == std::floor(repeats);
  if (!whole || target < 0 || target > std::numeric_limits<int>::max() || repeats < -1 || repeats > kMaxRepeats) {
    refuse(item.where,
           fmt::format("expected a jump to the number of an item, -1 to {} times, found {}, {} times; correct "
                       "the jump",
                       kMaxRepeats, target, repeats));
  }
  mission_.jumps.push_back({mission_.waypoints.size(), 0, 0, static_cast<int>(repeats), item.item});
  pending_.push_back({static_cast<long>(target), item.command == kJumpToTagCommand, item.where});
}

void Route::add_speed(const MissionItem& item) {
  constexpr double kAir = 0, kGround = 1;  // 2 and 3: climb and descent
  const double type = item.params[0], mps = item.params[1];
  if ((type == kAir || type == kGround) && mps > 0) speed_ = Speed{mps, type == kAir};
}

void Route::finish() {
  for (size_t i = 0; i < pending_.size(); ++i) {
    const auto& marks = pending_[i].tag ? tags_ : ids_;
    const auto found = marks.find(pending_[i].target);
    if (found == marks.end()) {
      refuse(pending_[i].where, fmt::format("expected a jump to an item of this mission, found {} {}; correct the jump",
                                            pending_[i].tag ? "tag" : "item", pending_[i].target));
    }
    mission_.jumps[i].to = found->second.waypoints;
    mission_.jumps[i].to_jump = found->second.jumps;
  }
  refuse_circles();
}

void Route::refuse_circles() const {
  const auto& jumps = mission_.jumps;
  // From each jump along jumps alone: more steps than there are jumps means a circle. Marks tell what is known to end,
  // so that each is walked once.
  std::vector<bool> ends(jumps.size(), false);
  for (size_t start = 0; start < jumps.size(); ++start) {
    std::vector<size_t> walked;
    size_t at = start;
    while (at < jumps.size() && !ends[at]) {
      walked.push_back(at);
      if (walked.size() > jumps.size()) {
        refuse(pending_[start].where,
               "expected jumps that lead to a waypoint, found jumps in a circle; correct the jump");
      }
      const Jump& jump = jumps[at];
      const bool on_jump = jump.to_jump < jumps.size() && jumps[jump.to_jump].at == jump.to;
      at = on_jump ? jump.to_jump : jumps.size();
    }
    for (const size_t jump : walked) ends[jump] = true;
  }
}

}  // namespace landfix::mission
