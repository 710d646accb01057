// Suggestions along a mission: what of it must be kept, and the file with the detours in it.
#include <algorithm>
#include <cmath>

#include "builder/error.h"
#include "tools/mission/write.h"
#include "tools/route/suggest.h"

namespace landfix::route {
namespace {

constexpr double kRadians = M_PI / 180;

bool changeable(const mission::Mission& mission) {
  return mission.format == mission::Format::kPlan || mission.format == mission::Format::kWaypoints;
}

}  // namespace

MissionStops stops_of(const mission::Mission& mission, const tiles::Zone& zone) {
  MissionStops found;
  size_t item = 0;
  for (const size_t index : mission::flown(mission).waypoints) {
    const mission::Waypoint& w = mission.waypoints[index];
    const mission::Position& p = w.place.position;
    const auto place = tiles::grid_from_geodetic(zone, {p.latitude_deg * kRadians, p.longitude_deg * kRadians});
    if (!place) throw Error(ExitCode::kNoData, mission.file + ": a waypoint is out of reach of the map's zone");
    const Eigen::Vector2d here(place->east_m, place->north_m);
    const bool again = !found.stops.empty() && (found.stops.back().place - here).norm() < 1;
    if (!again) {
      // Lines of a file that are one item are a route like any other, surveys are not.
      found.stops.push_back({here, changeable(mission) && !found.stops.empty() && w.item == item});
      found.waypoints.push_back(index);
    }
    item = w.item;
  }
  return found;
}

std::vector<mission::Place> places_of(const std::vector<Eigen::Vector2d>& points, const RouteProblem& problem,
                                      const tiles::Zone& zone, bool above_sea) {
  std::vector<mission::Place> places;
  for (const Eigen::Vector2d& p : points) {
    const auto place = tiles::geodetic_from_grid(zone, p.x(), p.y());
    if (!place) throw Error(ExitCode::kNoData, "route: a point is outside of the zone's grid");
    mission::Altitude altitude{problem.level_m, mission::AltitudeReference::kTerrain};
    if (above_sea || !problem.above_ground) {
      const std::optional<double> geoid = problem.heights.geoid_m(p.x(), p.y()),
                                  ground = problem.above_ground ? problem.heights.ground_m(p.x(), p.y()) : 0;
      if (!geoid || !ground) {
        throw Error(ExitCode::kNoData,
                    "route: geoid and ground are not known on all of the route; write .plan or .geojson with heights "
                    "above ground");
      }
      altitude = {*ground + problem.level_m - *geoid, mission::AltitudeReference::kSeaLevel};
    }
    places.push_back({{place->latitude_rad / kRadians, place->longitude_rad / kRadians}, altitude});
  }
  return places;
}

std::string with_detours(const mission::Mission& mission, const MissionStops& stops, const RouteProblem& problem,
                         const Suggestion& suggestion, const tiles::Zone& zone) {
  if (!changeable(mission) || !mission.jumps.empty()) {
    throw Error(ExitCode::kUsage,
                mission.file + ": detours go into plans and WPL files without jumps; write a new file");
  }
  const std::vector<Eigen::Vector2d>& points = suggestion.suggested().points;
  std::vector<mission::Replacement> replacements;
  size_t stop = 0;
  std::vector<Eigen::Vector2d> between;
  for (const Eigen::Vector2d& point : points) {
    if (stop >= stops.stops.size() || point != stops.stops[stop].place) {
      between.push_back(point);
      continue;
    }
    if (!between.empty()) {
      const size_t item = mission.waypoints[stops.waypoints[stop]].item;
      replacements.push_back({item, item, places_of(between, problem, zone)});
    }
    between.clear();
    ++stop;
  }
  return mission::changed_mission(mission, replacements);
}

}  // namespace landfix::route
