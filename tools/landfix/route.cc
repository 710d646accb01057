// `landfix route`: how well the position will be known along a route without GNSS, which way and how high to fly.
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "builder/error.h"
#include "tools/common/files.h"
#include "tools/landfix/commands.h"
#include "tools/landfix/route_setup.h"
#include "tools/mission/read.h"
#include "tools/mission/write.h"
#include "tools/route/altitude.h"
#include "tools/route/polygon_file.h"
#include "tools/route/report.h"
#include "tools/route/suggest.h"

namespace landfix::tools {
namespace {

constexpr double kRadians = M_PI / 180;

constexpr char kExamples[] = R"(
Missions: QGroundControl .plan, QGC WPL 110, GPX, GeoJSON, KML. The map is a pack built with navigability layers.

Examples:
  landfix route score survey.plan --map area.lfpack --require 10m@95% --html survey.html
      expected position error along the mission, leg by leg with reasons, and a report with map and profile
  landfix route suggest --from 8.10,47.10 --to 8.25,47.14 --map area.lfpack --require 10m@95% -o way.plan
      the way between two places that keeps the requirement, compared with the straight one
  landfix route suggest delivery.plan --map area.lfpack --no-fly towns.geojson -o delivery_safe.plan
      the same mission with detours between its waypoints; everything else of the file is kept
  landfix route altitude survey.plan --map area.lfpack --heights 80,120,200,300
      from which height the mission is flown best)";

/// The command line as given, degrees where it says so.
struct Arguments : RouteArguments {
  std::string mission, output, html, no_fly;
  std::vector<double> from, to, heights, band;
  std::optional<double> agl_m, altitude_m, speed_mps;
  bool json = false;
};

void print(const Arguments& a, const nlohmann::ordered_json& json, const std::string& text) {
  fmt::print("{}", a.json ? json.dump(2) + "\n" : text);
}

/// What of a mission the route does not show goes to standard error.
mission::Mission read_noted(const std::string& path) {
  mission::Mission mission = mission::read_mission(path);
  for (const mission::Note& note : mission.notes) fmt::print(stderr, "{}: {}\n", path, note.text);
  return mission;
}

route::PathOptions path_options(const Arguments& a) {
  route::PathOptions options;
  options.agl_m = a.agl_m;
  options.speed_mps = a.speed_mps;
  return options;
}

void run_score(const Arguments& a) {
  const RouteSetup setup(a);
  const mission::Mission mission = read_noted(a.mission);
  const route::Path path = route::path_of(mission, setup.zone, setup.heights, path_options(a));
  const route::RouteScore score = route::score(path, *setup.navigability, setup.vehicle, setup.score);
  print(a, route::to_json(score, setup.zone), route::to_text(score));
  if (a.html.empty()) return;
  const route::Fences fences = route::fences_of(mission, setup.zone);
  const route::ReportScene scene = route::scene_of(setup.pack, a.map, fences, &mission, setup.zone);
  write_text(a.html, route::html_report(score, *setup.navigability, setup.vehicle, scene));
}

void run_altitude(const Arguments& a) {
  const RouteSetup setup(a);
  const mission::Mission mission = read_noted(a.mission);
  const auto path_at = [&](double agl_m) {
    route::PathOptions options = path_options(a);
    options.instead_agl_m = agl_m;
    return route::path_of(mission, setup.zone, setup.heights, options);
  };
  const route::AltitudeComparison comparison =
      route::compare_altitudes(path_at, a.heights, *setup.navigability, setup.vehicle, setup.score);
  print(a, route::to_json(comparison), route::to_text(comparison));
}

Eigen::Vector2d place_of(const std::vector<double>& degrees, const tiles::Zone& zone, const char* option) {
  const auto place = tiles::grid_from_geodetic(zone, {degrees[1] * kRadians, degrees[0] * kRadians});
  if (!place)
    throw Error(ExitCode::kUsage, fmt::format("{}: expected LON,LAT in degrees, in reach of the map's zone", option));
  return {place->east_m, place->north_m};
}

/// Without a given height the mission's own mean height above ground; 120 m between two places.
void set_level(const Arguments& a, const RouteSetup& setup, const std::optional<mission::Mission>& mission,
               route::RouteProblem& problem) {
  problem.level_m = a.agl_m.value_or(120);
  if (a.altitude_m) {
    problem.above_ground = false;
    problem.level_m = *a.altitude_m;
  } else if (mission && !a.agl_m) {
    const route::Path path = route::path_of(*mission, setup.zone, setup.heights, path_options(a));
    double sum = 0;
    constexpr int kSamples = 200;
    for (int i = 0; i <= kSamples; ++i) sum += path.at(path.length_m() * i / kSamples).agl_m;
    problem.level_m = sum / (kSamples + 1);
  }
  if (!a.band.empty()) {
    if (!(a.band[0] >= 0 && a.band[0] < a.band[1]))
      throw Error(ExitCode::kUsage,
                  fmt::format("--band: expected the lower height above ground and then the higher one, "
                              "found {:g},{:g}",
                              a.band[0], a.band[1]));
    problem.least_agl_m = a.band[0];
    problem.most_agl_m = a.band[1];
  }
  if (a.speed_mps)
    problem.speed_mps = *a.speed_mps;
  else if (mission && mission->cruise_speed_mps)
    problem.speed_mps = *mission->cruise_speed_mps;
}

/// A changed copy of the mission where it is a plan or WPL of the same kind as the output, else a new file.
std::string suggested_file(const Arguments& a, const RouteSetup& setup, const std::optional<mission::Mission>& mission,
                           const route::MissionStops& stops, const route::RouteProblem& problem,
                           const route::Suggestion& suggestion) {
  const mission::Format format = mission::format_for(a.output);
  const bool keeps = format == mission::Format::kPlan || format == mission::Format::kWaypoints;
  if (mission && keeps && mission->format == format)
    return route::with_detours(*mission, stops, problem, suggestion, setup.zone);
  const std::vector<mission::Place> places =
      route::places_of(suggestion.suggested().points, problem, setup.zone, format == mission::Format::kGpx);
  mission::NewFile about;
  about.name = std::filesystem::path(a.output).stem().string();
  about.speed_mps = problem.speed_mps;
  const Eigen::Vector2d start = suggestion.suggested().points.front();
  const auto ground = setup.heights.ground_m(start.x(), start.y()), geoid = setup.heights.geoid_m(start.x(), start.y());
  if (mission && mission->home) {
    about.home = mission->home;
  } else if (ground && geoid) {
    about.home = mission::Place{places.front().position, {*ground - *geoid, mission::AltitudeReference::kSeaLevel}};
  } else if (keeps) {
    throw Error(ExitCode::kNoData,
                fmt::format("{}: expected the height of the ground above sea level for home, found no "
                            "geoid in {}; write .gpx or .geojson, or build the map with --dem",
                            a.output, a.map));
  }
  return mission::new_mission(format, places, about);
}

/// A level below the ground at a stop leaves no way, and the search could not say why.
void require_above_ground(const route::RouteProblem& problem) {
  if (problem.above_ground) return;
  for (const route::Stop& stop : problem.stops) {
    const auto ground_m = problem.heights.ground_m(stop.place.x(), stop.place.y());
    if (!ground_m || problem.level_m > *ground_m) continue;
    throw Error(
        ExitCode::kBadInput,
        fmt::format("--altitude {:g}: expected a height above the ground, which lies {:.0f} m above the ellipsoid "
                    "at a place of the route; fly higher",
                    problem.level_m, *ground_m));
  }
}

void run_suggest(const Arguments& a) {
  const bool places = !a.from.empty() && !a.to.empty();
  if (places == !a.mission.empty())
    throw Error(ExitCode::kUsage, "route suggest: expected either a mission, or --from and --to");
  if (!a.output.empty()) mission::format_for(a.output);  // refused before the search, not after it
  const RouteSetup setup(a);
  route::RouteProblem problem;
  problem.map = setup.navigability.get();
  problem.vehicle = setup.vehicle;
  problem.heights = setup.heights;
  std::vector<route::Polygon> no_fly;
  if (!a.no_fly.empty()) no_fly = route::read_polygons(a.no_fly, setup.zone);
  std::optional<mission::Mission> mission;
  route::MissionStops stops;
  if (places) {
    problem.stops = {{place_of(a.from, setup.zone, "--from")}, {place_of(a.to, setup.zone, "--to")}};
    problem.fences = route::Fences(no_fly);
  } else {
    mission = read_noted(a.mission);
    stops = route::stops_of(*mission, setup.zone);
    problem.stops = stops.stops;
    problem.fences = route::fences_of(*mission, setup.zone, no_fly);
  }
  set_level(a, setup, mission, problem);
  require_above_ground(problem);
  const route::Suggestion suggestion = route::suggest(problem, {setup.score});
  print(a, route::to_json(suggestion, setup.zone), route::to_text(suggestion));
  if (!a.html.empty()) {
    const route::ReportScene scene =
        route::scene_of(setup.pack, a.map, problem.fences, mission ? &*mission : nullptr, setup.zone);
    write_text(a.html, route::html_report(suggestion, *setup.navigability, setup.vehicle, scene));
  }
  if (!a.output.empty()) write_text(a.output, suggested_file(a, setup, mission, stops, problem, suggestion));
}

void add_common_options(CLI::App& command, Arguments& a) {
  add_route_options(command, a);
  command.add_option("--agl", a.agl_m, "Height above ground, m, where the mission gives none")
      ->check(CLI::PositiveNumber);
  command.add_option("--speed", a.speed_mps, "Ground speed of the whole route, m/s [as the mission says]")
      ->check(CLI::PositiveNumber);
  command.add_flag("--json", a.json, "Print JSON");
}

void add_score(CLI::App& parent) {
  CLI::App* command = parent.add_subcommand("score", "Expected position error along a mission, and where it is poor");
  auto a = std::make_shared<Arguments>();
  command->add_option("MISSION", a->mission, "The mission")->required();
  add_common_options(*command, *a);
  command->add_option("--html", a->html, "Write a report with map and profile")->type_name("FILE");
  command->callback([a] { run_score(*a); });
}

void add_suggest(CLI::App& parent) {
  CLI::App* command = parent.add_subcommand("suggest", "The way that keeps the position known well enough");
  auto a = std::make_shared<Arguments>();
  command->add_option("MISSION", a->mission, "Keep the waypoints of this mission, in their order, with its fences");
  const auto place = [&](const char* name, std::vector<double>& degrees) {
    command->add_option(name, degrees, "Place, degrees")->delimiter(',')->expected(2)->type_name("LON,LAT");
  };
  place("--from", a->from);
  place("--to", a->to);
  add_common_options(*command, *a);
  command->add_option("--altitude", a->altitude_m, "Constant height above the ellipsoid instead of --agl, m");
  command->add_option("--band", a->band, "Heights above ground that are allowed, m")
      ->delimiter(',')
      ->expected(2)
      ->type_name("LEAST,MOST");
  command->add_option("--no-fly", a->no_fly, "GeoJSON polygons to stay out of")->type_name("FILE");
  command->add_option("-o,--output", a->output, "Write the route as .plan, .waypoints, .gpx or .geojson")
      ->type_name("FILE");
  command->add_option("--html", a->html, "Write a report with map and profiles")->type_name("FILE");
  command->callback([a] { run_suggest(*a); });
}

void add_altitude(CLI::App& parent) {
  CLI::App* command = parent.add_subcommand("altitude", "From which height a mission is flown best");
  auto a = std::make_shared<Arguments>();
  command->add_option("MISSION", a->mission, "The mission")->required();
  add_common_options(*command, *a);
  command->add_option("--heights", a->heights, "Heights above ground to compare, m")
      ->delimiter(',')
      ->required()
      ->type_name("METRES,...");
  command->callback([a] { run_altitude(*a); });
}

}  // namespace

void add_route(CLI::App& app) {
  CLI::App* command = app.add_subcommand("route", "Plan routes that can be flown without GNSS");
  command->require_subcommand(1);
  command->footer(kExamples);
  add_score(*command);
  add_suggest(*command);
  add_altitude(*command);
}

}  // namespace landfix::tools
