// Writes QGroundControl's .plan. Keys are in alphabetical order, as QGroundControl itself writes them.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "builder/error.h"
#include "tools/mission/json.h"
#include "tools/mission/write_formats.h"

namespace landfix::mission {
namespace {

Json item_of(int command, Frame frame, const Json& params, long id) {
  return {{"autoContinue", true}, {"command", command}, {"doJumpId", id},
          {"frame", frame},       {"params", params},   {"type", "SimpleItem"}};
}

int mode_of(Frame frame) { return frame == kHomeFrame ? 1 : frame == kGlobalFrame ? 2 : 4; }

Json waypoint(const Place& place, long id) {
  const Frame frame = frame_for(place.altitude);
  const auto& [position, altitude] = place;
  // What QGroundControl shows, before what it sends.
  Json item = {{"AMSLAltAboveTerrain", nullptr}, {"Altitude", altitude.m}, {"AltitudeMode", mode_of(frame)}};
  item.update(item_of(kWaypointCommand, frame,
                      {0, 0, 0, nullptr, position.latitude_deg, position.longitude_deg, altitude.m}, id));
  return item;
}

/// A member that is a whole number; within complex items of unknown kinds it may be anything.
long integer_in(const Json& item, const char* key, long otherwise) {
  if (!item.is_object()) return otherwise;
  const auto member = item.find(key);
  if (member == item.end() || !member->is_number()) return otherwise;
  const double value = member->get<double>();
  return std::abs(value) <= std::numeric_limits<int>::max() ? std::lround(value) : otherwise;
}

bool is_simple(const Json& item) { return item["type"] == "SimpleItem"; }

/// Of the ids of the items of a plan, those within complex items too.
long largest_id(const Json& items) {
  long largest = 0;
  for (const Json& item : items) {
    largest = std::max(largest, integer_in(item, "doJumpId", 0));
    if (!item.is_object() || !item.contains("TransectStyleComplexItem")) continue;
    const Json& transects = item["TransectStyleComplexItem"];
    if (transects.is_object() && transects.contains("Items"))
      largest = std::max(largest, largest_id(transects["Items"]));
  }
  return largest;
}

std::set<long> jump_targets(const Json& items) {
  std::set<long> targets;
  for (const Json& item : items) {
    if (is_simple(item) && item["command"] == kJumpCommand) targets.insert(item["params"][0].get<long>());
  }
  return targets;
}

std::string why_fixed(const Json& item, const std::set<long>& targets) {
  const bool plain = is_simple(item) && (item["command"] == kWaypointCommand || item["command"] == kSplineCommand);
  if (!plain) return "it is no plain waypoint";
  if (targets.contains(integer_in(item, "doJumpId", -1))) return "a jump leads to it";
  return "";
}

std::string text_of(const Json& plan) { return plan.dump(4) + "\n"; }

}  // namespace

std::string new_plan(const std::vector<Place>& path, const NewFile& about) {
  if (!about.home || about.home->altitude.reference != AltitudeReference::kSeaLevel) {
    throw Error(ExitCode::kUsage, "plan: expected home with its altitude above sea level, found none");
  }
  Json items = Json::array();
  long id = 1;
  if (about.speed_mps) {
    items.push_back(item_of(kChangeSpeedCommand, kMissionFrame, {1, *about.speed_mps, -1, 0, 0, 0, 0}, id++));
  }
  for (const Place& place : path) items.push_back(waypoint(place, id++));
  const auto& [position, altitude] = *about.home;
  constexpr double kUsualCruise = 15, kUsualHover = 5;  // QGroundControl's own
  const Json mission = {{"cruiseSpeed", about.speed_mps.value_or(kUsualCruise)},
                        {"firmwareType", about.firmware_type},
                        {"globalPlanAltitudeMode", 0},  // each item has its own
                        {"hoverSpeed", about.speed_mps.value_or(kUsualHover)},
                        {"items", items},
                        {"plannedHomePosition", {position.latitude_deg, position.longitude_deg, altitude.m}},
                        {"vehicleType", about.vehicle_type},
                        {"version", 2}};
  return text_of({{"fileType", "Plan"},
                  {"geoFence", {{"circles", Json::array()}, {"polygons", Json::array()}, {"version", 2}}},
                  {"groundStation", "landfix"},
                  {"mission", mission},
                  {"rallyPoints", {{"points", Json::array()}, {"version", 2}}},
                  {"version", 1}});
}

std::string changed_plan(const Mission& source, const std::vector<Replacement>& replacements) {
  Json plan = parse_json(source.text, source.file);
  const Json items = plan["mission"]["items"];
  const std::set<long> targets = jump_targets(items);
  const auto sorted =
      checked(replacements, items.size(), source.file, [&](size_t item) { return why_fixed(items[item], targets); });
  Json changed = Json::array();
  // Ids only have to differ; those of other items stay, so jumps need no change.
  long id = largest_id(items);
  size_t gone_until = 0;
  auto next = sorted.begin();
  for (size_t item = 0; item <= items.size(); ++item) {
    for (; next != sorted.end() && next->first == item; ++next) {
      for (const Place& place : next->path) changed.push_back(waypoint(place, ++id));
      gone_until = next->end;
    }
    if (item < items.size() && item >= gone_until) changed.push_back(items[item]);
  }
  plan["mission"]["items"] = changed;
  return text_of(plan);
}

}  // namespace landfix::mission
