// QGroundControl's .plan (docs.qgroundcontrol.com, developer guide, "Plan file format").
#include <fmt/format.h>

#include <cmath>

#include "builder/error.h"
#include "tools/mission/formats.h"
#include "tools/mission/json.h"
#include "tools/mission/route.h"

namespace landfix::mission {
namespace {

constexpr const char* kSaveAgain = "open it in a current QGroundControl and save it again";

/// What "AltitudeMode" and CameraCalc's "DistanceMode" say (QGroundControl's AltMode).
AltitudeReference reference_of_mode(long mode) {
  constexpr AltitudeReference kModes[] = {AltitudeReference::kNone, AltitudeReference::kHome,
                                          AltitudeReference::kSeaLevel, AltitudeReference::kTerrain,
                                          AltitudeReference::kTerrain};
  return mode >= 0 && mode < 5 ? kModes[mode] : AltitudeReference::kNone;
}

void expect_version(const JsonNode& node, long first, long last) {
  const long version = node.at("version").integer();
  if (version >= first && version <= last) return;
  node.refuse(fmt::format("version {}", last), std::to_string(version),
              version < first ? kSaveAgain : "it is newer than this program: save it with an older QGroundControl");
}

Position position_of(const JsonNode& pair) {
  return checked_position(pair.file(), pair.path(), pair.at(0).number_or_nan(), pair.at(1).number_or_nan());
}

/// [latitude, longitude, altitude]; the altitude may be null.
Place place_of(const JsonNode& triple, AltitudeReference reference) {
  Place place{position_of(triple), {}};
  const double altitude_m = triple.at(2).number_or_nan();
  if (!std::isnan(altitude_m)) place.altitude = {altitude_m, reference};
  return place;
}

/// Seven parameters, or four and a "coordinate" in plans before 2017.
void read_params(const JsonNode& node, MissionItem& item) {
  const JsonNode params = node.at("params");
  const auto coordinate = node.find("coordinate");
  const bool split = coordinate && params.size() == 4;
  if (!split && params.size() != item.params.size()) {
    params.refuse("7 parameters", std::to_string(params.size()), kSaveAgain);
  }
  for (size_t i = 0; i < item.params.size(); ++i) {
    item.params[i] = (split && i >= 4 ? coordinate->at(i - 4) : params.at(i)).number_or_nan();
  }
}

MissionItem simple_item(const JsonNode& node, size_t index, size_t part) {
  MissionItem item;
  item.command = static_cast<int>(node.at("command").integer());
  item.frame = static_cast<int>(node.at("frame").integer());
  item.item = index;
  item.part = part;
  item.where = node.path();
  read_params(node, item);
  // Above terrain and not yet computed: the parameter is null, the wish is here.
  if (const auto mode = node.find("AltitudeMode")) {
    const auto altitude = node.find("Altitude");
    if (altitude) item.altitude = Altitude{altitude->number(), reference_of_mode(mode->integer())};
  }
  return item;
}

/// The distance to the surface that a survey or corridor was laid out for.
Altitude survey_altitude(const JsonNode& transects) {
  const auto camera = transects.find("CameraCalc");
  const auto distance = camera ? camera->find("DistanceToSurface") : std::nullopt;
  if (!distance) return {};
  const auto follow = transects.find("FollowTerrain");  // version 1
  if (follow && follow->flag()) return {distance->number(), AltitudeReference::kTerrain};
  if (const auto relative = camera->find("DistanceToSurfaceRelative")) {  // version 1
    return {distance->number(), relative->flag() ? AltitudeReference::kHome : AltitudeReference::kSeaLevel};
  }
  const auto mode = camera->find("DistanceMode");
  const AltitudeReference reference = reference_of_mode(mode ? mode->integer() : 0);
  return reference == AltitudeReference::kNone ? Altitude{} : Altitude{distance->number(), reference};
}

/// Survey and corridor scan. "Items" is what QGroundControl sends to the vehicle; the polyline of the map has the same
/// corners without altitudes, and serves where a program has left the items out.
void add_transects(const JsonNode& node, size_t index, Route& route, Mission& mission) {
  const auto transects = node.find("TransectStyleComplexItem");
  if (!transects) node.refuse("\"TransectStyleComplexItem\"", "none", kSaveAgain);
  if (transects->find("version")) expect_version(*transects, 0, 2);  // the first had none
  const Altitude altitude = survey_altitude(*transects);
  const size_t before = mission.waypoints.size();
  size_t count = 0;
  if (const auto items = transects->find("Items")) {
    count = items->size();
    for (size_t part = 0; part < count; ++part) {
      MissionItem item = simple_item(items->at(part), index, part);
      if (!item.altitude) item.altitude = altitude;
      route.add(item);
    }
  }
  if (mission.waypoints.size() > before) return;
  const auto line = transects->find("VisualTransectPoints");
  count = line ? line->size() : 0;
  if (count == 0) node.refuse("transects (Items or VisualTransectPoints)", "none", kSaveAgain);
  for (size_t part = 0; part < count; ++part) route.add({position_of(line->at(part)), altitude}, index, part);
}

/// Landing patterns: the approach, circled down where the plan says so, then the landing.
void add_landing(const JsonNode& node, size_t index, bool vtol, Route& route) {
  const auto relative = node.find("altitudesAreRelative");
  const auto relative_v1 = node.find("landingAltitudeRelative");
  const bool from_home = relative ? relative->flag() : relative_v1 ? relative_v1->flag() : true;
  const auto approach = node.find("landingApproachCoordinate");
  const auto circled = node.find("useLoiterToAlt");
  const auto clockwise = node.find("loiterClockwise");
  const double radius_m = node.at("loiterRadius").number();
  const auto item = [&](const JsonNode& place, int command, size_t part) {
    MissionItem step;
    step.command = command;
    step.frame = from_home ? kHomeFrame : kGlobalFrame;
    for (size_t i = 0; i < 3; ++i) step.params[4 + i] = place.at(i).number_or_nan();
    step.item = index;
    step.part = part;
    step.where = place.path();
    return step;
  };
  MissionItem down = item(approach ? *approach : node.at("loiterCoordinate"),
                          circled && !circled->flag() ? kWaypointCommand : kLoiterToAltitudeCommand, 0);
  if (down.command == kLoiterToAltitudeCommand) down.params[1] = clockwise && !clockwise->flag() ? -radius_m : radius_m;
  route.add(down);
  route.add(item(node.at("landCoordinate"), vtol ? kVtolLandCommand : kLandCommand, 1));
}

void add_complex(const JsonNode& node, size_t index, Route& route, Mission& mission) {
  const std::string& type = node.at("complexItemType").text();
  if (type == "survey" || type == "CorridorScan") {
    expect_version(node, type == "survey" ? 4 : 2, type == "survey" ? 5 : 2);
    return add_transects(node, index, route, mission);
  }
  if (type == "fwLandingPattern" || type == "vtolLandingPattern") {
    const bool vtol = type == "vtolLandingPattern";
    expect_version(node, 1, vtol ? 1 : 2);
    return add_landing(node, index, vtol, route);
  }
  mission.notes.push_back(
      {index, fmt::format("{}: a plan does not hold the path of a complex item of type \"{}\": it is "
                          "kept, but not part of the route",
                          node.path(), type.substr(0, 40))});
}

void read_items(const JsonNode& items, Mission& mission) {
  Route route(mission);
  for (size_t index = 0; index < items.size(); ++index) {
    const JsonNode node = items.at(index);
    const std::string& type = node.at("type").text();
    if (type == "SimpleItem") {
      if (const auto id = node.find("doJumpId")) route.mark(id->integer());
      route.add(simple_item(node, index, 0));
    } else if (type == "ComplexItem") {
      add_complex(node, index, route, mission);
    } else {
      node.refuse("an item of type SimpleItem or ComplexItem", "\"" + type.substr(0, 40) + "\"", kSaveAgain);
    }
  }
  route.finish();
}

/// Versions before 2, which QGroundControl skips without a word.
bool too_old(const JsonNode& node, const char* what, Mission& mission) {
  const auto version = node.find("version");
  if (version && version->integer() >= 2) return false;
  mission.notes.push_back(
      {0, fmt::format("{} of a version before 2, which QGroundControl does not read: left out", what)});
  return true;
}

void read_fences(const JsonNode& node, Mission& mission) {
  if (too_old(node, "geoFence", mission)) return;
  expect_version(node, 2, 2);
  const JsonNode polygons = node.at("polygons"), circles = node.at("circles");
  for (size_t i = 0; i < polygons.size(); ++i) {
    Fence fence;
    fence.inclusion = polygons.at(i).at("inclusion").flag();
    const JsonNode corners = polygons.at(i).at("polygon");
    if (corners.size() < 3)
      corners.refuse("at least 3 corners", std::to_string(corners.size()), "draw the fence again");
    for (size_t corner = 0; corner < corners.size(); ++corner) fence.polygon.push_back(position_of(corners.at(corner)));
    mission.fences.push_back(fence);
  }
  for (size_t i = 0; i < circles.size(); ++i) {
    const JsonNode circle = circles.at(i).at("circle");
    Fence fence;
    fence.inclusion = circles.at(i).at("inclusion").flag();
    fence.centre = position_of(circle.at("center"));
    fence.radius_m = circle.at("radius").number();
    if (!(fence.radius_m > 0)) circle.at("radius").refuse("a radius above 0");
    mission.fences.push_back(fence);
  }
}

void read_rally_points(const JsonNode& node, Mission& mission) {
  if (too_old(node, "rallyPoints", mission)) return;
  expect_version(node, 2, 2);
  const JsonNode points = node.at("points");
  for (size_t i = 0; i < points.size(); ++i) {
    mission.rally_points.push_back(place_of(points.at(i), AltitudeReference::kHome));
  }
}

void read_home(const JsonNode& triple, Mission& mission) {
  // Plans drawn without a map at hand have 0, 0 or nulls here.
  const double latitude = triple.at(0).number_or_nan(), longitude = triple.at(1).number_or_nan();
  if (std::isnan(latitude) || std::isnan(longitude) || (latitude == 0 && longitude == 0)) {
    mission.notes.push_back({0, "the plan's home has no position"});
    return;
  }
  mission.home = place_of(triple, AltitudeReference::kSeaLevel);
}

}  // namespace

void read_plan(const JsonNode& root, Mission& mission) {
  expect_version(root, 1, 1);
  const JsonNode node = root.at("mission");
  expect_version(node, 2, 2);
  read_home(node.at("plannedHomePosition"), mission);
  if (const auto speed = node.find("cruiseSpeed")) mission.cruise_speed_mps = speed->number();
  if (const auto speed = node.find("hoverSpeed")) mission.hover_speed_mps = speed->number();
  read_items(node.at("items"), mission);
  if (const auto fence = root.find("geoFence")) read_fences(*fence, mission);
  if (const auto rally = root.find("rallyPoints")) read_rally_points(*rally, mission);
}

}  // namespace landfix::mission
