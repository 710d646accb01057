// What the commands about routes share: the map with its navigability, the aircraft, and the options for both.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "landfix/landfix.hpp"
#include "runtime/nav/pack_map.h"
#include "tools/landfix/aircraft.h"
#include "tools/route/pack_navigability.h"
#include "tools/route/score.h"

namespace landfix::tools {

/// The command line as given, degrees where it says so.
struct RouteArguments : AircraftArguments {
  std::string map, date, require = "10m@95%";
  std::vector<std::string> key_files;
  route::ScoreOptions score;
};

void add_route_options(CLI::App& command, RouteArguments& arguments);

/// The map opened and the aircraft put together. Not to be moved, as the heights refer to the map. Throws Error:
/// kNoData for a pack without navigability, kUsage for what the options say wrongly.
struct RouteSetup {
  explicit RouteSetup(const RouteArguments& arguments);
  RouteSetup(const RouteSetup&) = delete;

  Pack pack;
  lf_info info;
  tiles::Zone zone;
  nav::PackMap ground;
  std::unique_ptr<route::NavigabilityMap> navigability;
  route::Heights heights;
  fly::FlightOptions flight;  ///< of the same aircraft, to be simulated
  route::Vehicle vehicle;
  route::ScoreOptions score;
};

}  // namespace landfix::tools
