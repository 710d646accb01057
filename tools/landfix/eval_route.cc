// `landfix eval route`: what is predicted of routes and of suggestions, against simulated flights.
#include <fmt/format.h>

#include <array>
#include <opencv2/core.hpp>

#include "builder/error.h"
#include "builder/ingest/image_set.h"
#include "tools/common/files.h"
#include "tools/common/open_pack.h"
#include "tools/eval/routes.h"
#include "tools/landfix/commands.h"
#include "tools/landfix/route_setup.h"

namespace landfix::tools {
namespace {

struct Arguments : RouteArguments {
  std::vector<std::string> scenes;
  std::string scene_dem, scene_dem_datum, json_file;
  bool gray = false;
  eval::RoutesOptions routes;
};

/// What the map and all scenes cover.
route::Extent area_of(const Arguments& a, const RouteSetup& setup) {
  const lf_info& map = setup.info;
  route::Extent area{map.west_m, map.south_m, map.east_m, map.north_m};
  for (const std::string& path : a.scenes) {
    const ingest::GridBounds seen =
        ingest::ImageSet(std::array{ingest::SourceOptions{.path = path}}, setup.zone).bounds();
    area = {std::max(seen.west_m, area.west_m), std::max(seen.south_m, area.south_m),
            std::min(seen.east_m, area.east_m), std::min(seen.north_m, area.north_m)};
  }
  return area;
}

std::vector<fly::SceneSource> sources_of(const Arguments& a, const lf_info& map) {
  if (a.scene_dem.empty() && map.has_heights)
    throw Error(ExitCode::kUsage, "the map has heights, the scene has none: give --scene-dem");
  std::vector<fly::SceneSource> sources;
  for (const std::string& path : a.scenes) {
    fly::SceneSource source;
    source.ortho.path = path;
    source.plane_height_m = map.plane_height_m;
    if (!a.scene_dem.empty()) {
      source.elevation.emplace();
      source.elevation->path = a.scene_dem;
      source.elevation->datum = a.scene_dem_datum;
    }
    sources.push_back(std::move(source));
  }
  return sources;
}

void run(const Arguments& a) {
  cv::setNumThreads(1);
  const RouteSetup setup(a);
  prepare_layers(setup.pack, a.map);
  eval::RoutesScene scene;
  scene.problem.map = setup.navigability.get();
  scene.problem.vehicle = setup.vehicle;
  scene.problem.heights = setup.heights;
  scene.problem.level_m = setup.flight.agl_m;
  scene.problem.speed_mps = setup.flight.speed_mps;
  scene.score = setup.score;
  scene.score.flights = 0;
  scene.flight = setup.flight;
  scene.flight.sensors.colour = !a.gray;
  scene.sources = sources_of(a, setup.info);
  scene.zone = setup.zone;
  scene.open_map = [&] { return std::make_unique<nav::PackMap>(setup.pack); };
  const std::vector<eval::RouteTrial> trials = eval::fly_routes(
      scene, area_of(a, setup), a.routes, [](const std::string& line) { fmt::print(stderr, "{}", line); });
  const nlohmann::ordered_json json = eval::to_json(trials);
  if (a.json_file == "-") {
    fmt::print("{}\n", json.dump(2));
    return;
  }
  fmt::print("{}", eval::to_text(trials));
  if (!a.json_file.empty()) write_text(a.json_file, json.dump(2) + "\n");
}

}  // namespace

void add_eval_route(CLI::App& parent) {
  CLI::App* command = parent.add_subcommand("route", "Compare predicted errors along routes with simulated flights");
  auto a = std::make_shared<Arguments>();
  add_route_options(*command, *a);
  command
      ->add_option("--scene", a->scenes,
                   "Orthophoto that the camera sees, none that the map was made of; of several the flights take turns")
      ->allow_extra_args(false)
      ->required()
      ->type_name("FILE");
  command->add_option("--scene-dem", a->scene_dem, "Heights of the scene [the map's plane, where it has no heights]")
      ->type_name("FILE");
  command->add_option("--scene-dem-datum", a->scene_dem_datum, "Their vertical datum where the file does not say");
  command->add_flag("--gray", a->gray, "A camera that sees no colours: navigability is stated for one that does");
  command->add_option("--agl", a->flight.agl_m, "Height above ground, m")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--speed", a->flight.speed_mps, "Ground speed, m/s")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--routes", a->routes.routes, "Pairs of places")
      ->check(CLI::Range(1, 10'000))
      ->capture_default_str();
  command->add_option("--runs", a->routes.runs, "Flights of each way")
      ->check(CLI::Range(1, 10'000))
      ->capture_default_str();
  command->add_option("--length-m", a->routes.length_m, "Distance of the places")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--seed", a->routes.seed, "Seed of places and noise")->capture_default_str();
  command->add_option("--threads", a->routes.threads, "Threads; 0 for all cores")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command
      ->add_flag("--json{-}", a->json_file,
                 "All figures as JSON instead of the table; with a file they go there, besides the table")
      ->type_name("FILE");
  command->footer(R"(
Pairs of places are drawn at random. The straight way and the suggested one are scored, and flown again and again by the
simulator of 'landfix fly' over the scene. Compared are the root mean square of the error and the share of the time in which it is
within the required radius; and the length of the suggested way with the shortest that meets the requirement by its score.

Example:
  landfix eval route --map area.lfpack --scene 2018.tif --agl 160 --speed 20 --image-interval 1.5 --require 10m@95%
      ten pairs of places 3 km apart, fifty flights of each way
)");
  command->callback([a] { run(*a); });
}

}  // namespace landfix::tools
