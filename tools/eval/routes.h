// Whether what is said of routes is true: scores and suggestions against simulated flights over an image that the map
// has never seen, by the localizer that flies.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/eval/register.h"
#include "tools/fly/flight.h"
#include "tools/fly/scene_source.h"
#include "tools/route/suggest.h"

namespace landfix::eval {

struct RoutesOptions {
  int routes = 10, runs = 50;  ///< between places drawn at random; flights of each way
  double length_m = 3000;      ///< from place to place
  uint64_t seed = 1;
  int threads = 0;  ///< 0: all cores
};

/// What is flown and where: a problem of routes without stops, and the same aircraft to be simulated.
struct RoutesScene {
  route::RouteProblem problem;
  route::ScoreOptions score;
  fly::FlightOptions flight;              ///< of the problem's height and speed
  std::vector<fly::SceneSource> sources;  ///< what the camera sees: the first flight the first, and so on in turn
  tiles::Zone zone;
  OpenMap open_map;
};

/// One way between two places: what was said of it, and what came of it.
struct FlownRoute {
  std::vector<Eigen::Vector2d> points;  ///< east, north
  route::RouteScore said;
  double rms_m = 0;   ///< of the position's error over all flights
  double within = 0;  ///< share of all flights' time in which the error was below the required radius
};

struct RouteTrial {
  FlownRoute straight, suggested;
  bool can_be_met = false;  ///< the suggested way meets the requirement by its score
  double shortest_m = 0;    ///< length of the shortest way that does, by the same search; NaN where there is none
};

/// Draws places in the part of `area` (east, north) where the camera sees the scene; each pair lies `length_m` apart.
/// The same for any number of threads. `progress` gets a line of text after each route. Throws Error: kNoData where the
/// area has no room for such a pair, and as `suggest` and `fly` do.
std::vector<RouteTrial> fly_routes(const RoutesScene& scene, const route::Extent& area, const RoutesOptions& options,
                                   const std::function<void(const std::string&)>& progress);

std::string to_text(const std::vector<RouteTrial>& trials);
nlohmann::ordered_json to_json(const std::vector<RouteTrial>& trials);

}  // namespace landfix::eval
