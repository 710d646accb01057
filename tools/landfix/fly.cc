// `landfix fly`: a simulated flight over a scene, navigating by a map pack after GNSS is lost.
#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "builder/error.h"
#include "builder/ingest/image_set.h"
#include "runtime/nav/pack_map.h"
#include "tools/common/drawing.h"
#include "tools/common/files.h"
#include "tools/common/open_pack.h"
#include "tools/fly/flight.h"
#include "tools/fly/report.h"
#include "tools/fly/route_file.h"
#include "tools/fly/scene_source.h"
#include "tools/fly/shift.h"
#include "tools/fly/summary.h"
#include "tools/landfix/aircraft.h"
#include "tools/landfix/commands.h"

namespace landfix::tools {
namespace {

constexpr double kRadians = M_PI / 180;

constexpr char kExamples[] = R"(
The scene is any orthophoto, with a height model or over a flat plane; best another one than the map was made of. A ray-traced
camera looks at it with blur, gain and noise; attitude, heading, barometer and odometry have noise and constant errors. The
filter knows the map and the size of these errors, not the scene. The same seed gives the same flight.

Examples:
  landfix fly --map area.lfpack --scene ortho2.tif --scene-dem dsm.tif --scene-dem-datum egm96 --loop 1000 -o flight
      a kilometre in a loop, 60 m above ground
  landfix fly --map area.lfpack --scene ortho2.tif --scene-plane 420 --route route.geojson --agl 305 \
              --attitude-noise-deg 1 --runs 10 -o flights
      ten flights along a given route, 305 m above flat ground at 420 m, attitude known to one degree
  landfix fly --map area.lfpack --scene other.tif --measure-shift --loop 1000 --frames 8 -o flight
      scene and map are known to lie a constant shift apart: measure it and take it out; keep eight camera pictures

Output folder: track.csv (a line per image; with --runs track_1.csv and so on), summary.json, frames/, and tracks.png: truth
green, estimate red with yellow 3-sigma ellipses, dead reckoning blue.)";

/// The command line as given, degrees where it says so.
struct Arguments : AircraftArguments {
  std::string map, output, route_file;
  fly::SceneSource scene;
  std::string scene_dem, scene_dem_datum;
  std::optional<double> scene_plane_m;
  std::vector<std::string> key_files;
  std::vector<double> scene_shift, center;
  double loop_m = 1000, racetrack_m = 0, turn_radius_m = 40;
  double sway_deg = 1.5;
  std::string matcher = "auto";
  uint64_t seed = 1;
  int runs = 1, frames = 0;
  bool measure_shift = false, json = false;
};

/// What every run of one command shares.
struct Mission {
  Pack pack;
  lf_info info;
  tiles::Zone zone;
};

Mission open_map(const Arguments& a) {
  Pack pack = open_pack(a.map, a.key_files);
  const lf_info info = pack.info();
  return {std::move(pack), info, {info.zone, info.north != 0}};
}

fly::FlightOptions flight_options(const Arguments& a, const lf_info& map) {
  fly::FlightOptions o = flight_of(a, map);
  o.sway_rad = a.sway_deg * kRadians;
  o.localizer.method = nav::method_of(a.matcher);
  return o;
}

fly::SceneSource scene_source(const Arguments& a, const lf_info& map) {
  fly::SceneSource source = a.scene;
  if (!a.scene_shift.empty()) source.shift = {a.scene_shift[0], a.scene_shift[1]};
  if (!a.scene_dem.empty()) {
    source.elevation.emplace();
    source.elevation->path = a.scene_dem;
    source.elevation->datum = a.scene_dem_datum;
  } else if (a.scene_plane_m) {
    source.plane_height_m = *a.scene_plane_m;
  } else if (!map.has_heights) {
    source.plane_height_m = map.plane_height_m;
  } else {
    throw Error(
        ExitCode::kUsage,
        "the scene has no heights, but the map has: give --scene-dem FILE, or --scene-plane METRES for flat ground");
  }
  return source;
}

/// The middle of what map and scene both cover, or the place asked for.
Eigen::Vector2d center_of(const Arguments& a, const Mission& m) {
  if (!a.center.empty()) {
    const auto place = tiles::grid_from_geodetic(m.zone, {a.center[1] * kRadians, a.center[0] * kRadians});
    if (!place)
      throw Error(ExitCode::kUsage, "--center: expected LONGITUDE,LATITUDE in degrees, in reach of the map's zone");
    return {place->east_m, place->north_m};
  }
  const ingest::GridBounds scene = ingest::ImageSet(std::array{a.scene.ortho}, m.zone).bounds();
  const double west = std::max(scene.west_m, m.info.west_m), east = std::min(scene.east_m, m.info.east_m);
  const double south = std::max(scene.south_m, m.info.south_m), north = std::min(scene.north_m, m.info.north_m);
  if (!(west < east && south < north)) {
    throw Error(ExitCode::kNoData,
                fmt::format("{} and {} do not overlap: choose a scene of the map's area", a.map, a.scene.ortho.path));
  }
  return {(west + east) / 2, (south + north) / 2};
}

fly::Route make_route(const Arguments& a, const Mission& m) {
  if (!a.route_file.empty()) return fly::Route::through(fly::read_route(a.route_file, m.zone), a.turn_radius_m);
  const Eigen::Vector2d center = center_of(a, m);
  if (a.racetrack_m > 0) return fly::Route::racetrack(center.x(), center.y(), a.racetrack_m, a.turn_radius_m);
  return fly::Route::loop(center.x(), center.y(), a.loop_m, a.turn_radius_m);
}

/// Why images gave no fix; empty where all did.
std::string failures_of(const std::vector<fly::Record>& flight) {
  std::map<nav::Status, int> counts;
  for (const fly::Record& r : flight)
    if (!r.gnss && r.fix.status != nav::Status::kOk) ++counts[r.fix.status];
  std::string text;
  for (const auto& [status, count] : counts) text += fmt::format("; {} without: {}", count, nav::to_text(status));
  return text;
}

/// Saves every n-th picture so that about `count` are kept.
fly::FrameSink frame_sink(const std::filesystem::path& folder, int count, double images) {
  if (count <= 0) return {};
  std::filesystem::create_directories(folder);
  const size_t every = std::max<size_t>(1, size_t(images / count));
  return [folder, every](size_t index, const fly::Record&, const cv::Mat& picture) {
    if (index % every == 0) write_picture(folder / fmt::format("frame_{:04}.png", index), picture);
  };
}

std::vector<std::vector<fly::Record>> fly_all(const Arguments& a, const Mission& m, const terrain::Scene& scene,
                                              const fly::Route& route, const fly::FlightOptions& options) {
  const std::filesystem::path folder = a.output;
  const nav::PackMap map(m.pack);
  const double images =
      route.length_m() * (route.closed() ? options.laps : 1) / options.speed_mps / options.image_interval_s;
  std::vector<std::vector<fly::Record>> flights;
  for (int run = 0; run < a.runs; ++run) {
    const auto frames = run == 0 ? frame_sink(folder / "frames", a.frames, images) : fly::FrameSink();
    flights.push_back(fly::fly(scene, map, route, options, a.seed + uint64_t(run), frames));
    const std::string name = a.runs == 1 ? "track.csv" : fmt::format("track_{}.csv", run + 1);
    fly::write_track_csv(folder / name, flights.back(), m.zone);
    const fly::Summary s = fly::summarize({flights.back()});
    fmt::print(stderr, "flight {} of {}: RMS {:.2f} m, largest {:.2f} m, {} fixes from {} images{}\n", run + 1, a.runs,
               s.rms_m, s.max_m, s.fixes, s.images, failures_of(flights.back()));
  }
  write_picture(folder / "tracks.png", fly::draw_tracks(flights.front(), map));
  return flights;
}

nlohmann::json options_json(const Arguments& a, const fly::FlightOptions& o, const fly::Route& route) {
  nlohmann::json j = {{"route_length_m", route.length_m()},
                      {"laps", o.laps},
                      {"speed_mps", o.speed_mps},
                      {"agl_m", o.agl_m},
                      {"image_interval_s", o.image_interval_s},
                      {"gnss_until_s", o.gnss_until_s},
                      {"gnss_sigma_m", o.sensors.gnss_sigma_m},
                      {"image_size", a.image_size},
                      {"field_of_view_deg", a.field_of_view_deg},
                      {"attitude_noise_deg", a.attitude_noise_deg},
                      {"attitude_bias_deg", a.attitude_bias_deg},
                      {"heading_noise_deg", a.heading_noise_deg},
                      {"heading_bias_deg", a.heading_bias_deg},
                      {"barometer_noise_m", o.sensors.barometer_noise_m},
                      {"barometer_bias_m", o.sensors.barometer_bias_m},
                      {"odometry_drift", o.sensors.odometry_drift},
                      {"colour", o.sensors.colour},
                      {"blur_px", o.sensors.blur_px},
                      {"gain", o.sensors.gain},
                      {"offset", o.sensors.offset},
                      {"vignetting", o.sensors.vignetting},
                      {"pixel_noise", o.sensors.pixel_noise},
                      {"map_error_m", o.localizer.map_bias_sigma_m},
                      {"matcher", a.matcher},
                      {"bank", o.bank},
                      {"sway_deg", a.sway_deg}};
  if (o.altitude_m) j["altitude_m"] = *o.altitude_m;
  if (o.drift_correlation_m) j["drift_correlation_m"] = *o.drift_correlation_m;
  return j;
}

void print_text(const fly::Summary& s, const std::string& folder) {
  fmt::print("Without GNSS for {:.0f} m ({} images, {} fixes{}):\n", s.distance_m, s.images, s.fixes,
             s.flights > 1 ? fmt::format(", {} flights", s.flights) : "");
  fmt::print("  error            RMS {:.2f} m, 95 % {:.2f} m, largest {:.2f} m, at the end {:.2f} m\n", s.rms_m,
             s.percentile95_m, s.max_m, s.final_m);
  fmt::print("  dead reckoning   {:.1f} m at the end, {:.1f} m at most\n", s.dead_reckoning_final_m,
             s.dead_reckoning_max_m);
  fmt::print("  consistency      truth inside the 3-sigma ellipse {:.1f} % of the time\n", 100 * s.inside_3_sigma);
  fmt::print("  update           {:.1f} ms (median)\n", 1000 * s.median_update_s);
  fmt::print("Results in {}: tracks.png, track CSV, summary.json\n", folder);
}

void run(const Arguments& a) {
  const Mission mission = open_map(a);
  prepare_layers(mission.pack, a.map);
  const fly::FlightOptions options = flight_options(a, mission.info);
  fly::SceneSource source = scene_source(a, mission.info);
  const fly::Route route = make_route(a, mission);
  std::error_code failed;
  std::filesystem::create_directories(a.output, failed);
  if (failed) throw Error(ExitCode::kIo, a.output + ": cannot be made: " + failed.message());

  nlohmann::json summary = {{"map", std::filesystem::path(a.map).filename().string()},
                            {"scene", std::filesystem::path(a.scene.ortho.path).filename().string()},
                            {"seed", a.seed},
                            {"options", options_json(a, options, route)}};
  if (source.elevation)
    summary["scene_dem"] = std::filesystem::path(source.elevation->path).filename().string();
  else
    summary["scene_plane_m"] = source.plane_height_m;

  std::optional<terrain::Scene> scene(fly::load_scene(source, mission.zone, route, options));
  if (a.measure_shift) {
    const fly::Shift shift = fly::measure_shift(scene->texture(), nav::PackMap(mission.pack));
    summary["measured_shift"] = {{"east_m", shift.map_from_scene.x()},
                                 {"north_m", shift.map_from_scene.y()},
                                 {"spread_m", {shift.spread.x(), shift.spread.y()}},
                                 {"places", shift.places}};
    fmt::print(stderr, "the map lies {:.2f} m east and {:.2f} m north of the scene (median of {} places): taken out\n",
               shift.map_from_scene.x(), shift.map_from_scene.y(), shift.places);
    source.shift += shift.map_from_scene;
    scene.emplace(fly::load_scene(source, mission.zone, route, options));
  }
  summary["scene_shift_m"] = {source.shift.x(), source.shift.y()};

  const auto flights = fly_all(a, mission, *scene, route, options);
  const fly::Summary result = fly::summarize(flights);
  summary["result"] = fly::to_json(result);
  if (flights.size() > 1) {
    for (const auto& flight : flights) summary["each"].push_back(fly::to_json(fly::summarize({flight})));
  }
  write_text((std::filesystem::path(a.output) / "summary.json").string(), summary.dump(2) + "\n");
  if (a.json)
    fmt::print("{}\n", summary.dump(2));
  else
    print_text(result, a.output);
}

void add_scene_options(CLI::App& command, Arguments& a) {
  command.add_option("--map", a.map, "The map pack that the aircraft carries")->required()->type_name("PACK");
  command.add_option("--scene", a.scene.ortho.path, "Orthophoto that the camera sees")->required()->type_name("FILE");
  command.add_option("--scene-nodata", a.scene.ortho.nodata,
                     "Value that all bands have where the orthophoto shows nothing, if the file does not say");
  command.add_option("--scene-dem", a.scene_dem, "Heights of the scene (surface model best)")->type_name("FILE");
  command.add_option("--scene-dem-datum", a.scene_dem_datum,
                     "Their vertical datum where the file does not say: ellipsoid, egm96, EPSG:n");
  command.add_option("--scene-plane", a.scene_plane_m,
                     "Flat ground at this ellipsoidal height, m, instead of --scene-dem [the map's plane, where the "
                     "map has no heights]");
  command.add_option("--scene-shift", a.scene_shift, "Move the scene by E,N metres")
      ->delimiter(',')
      ->expected(2)
      ->type_name("E,N");
  command.add_flag("--measure-shift", a.measure_shift,
                   "Measure the constant shift between scene and map and take it out");
  command.add_option("--key", a.key_files, "Trusted public key file of the map (may be repeated)")
      ->allow_extra_args(false);
  command.add_option("-o,--output", a.output, "Folder for the results")->required()->type_name("DIR");
}

void add_route_options(CLI::App& command, Arguments& a) {
  auto* loop = command.add_option("--loop", a.loop_m, "Closed square loop with round corners of this length, m")
                   ->capture_default_str();
  auto* racetrack = command.add_option("--racetrack", a.racetrack_m, "Racetrack of this length, m")->excludes(loop);
  auto* file =
      command
          .add_option("--route", a.route_file, "Route from a file: GeoJSON LineString or lines of longitude,latitude")
          ->type_name("FILE");
  file->excludes(loop)->excludes(racetrack);
  command.add_option("--center", a.center, "Middle of a generated route, degrees [middle of what map and scene share]")
      ->delimiter(',')
      ->expected(2)
      ->type_name("LON,LAT")
      ->excludes(file);
  command.add_option("--turn-radius", a.turn_radius_m, "Radius of turns, m")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  fly::FlightOptions& o = a.flight;
  auto* agl = command.add_option("--agl", o.agl_m, "Height above the smoothed terrain, m")->capture_default_str();
  command.add_option("--altitude", o.altitude_m, "Constant height above the ellipsoid instead, m")->excludes(agl);
  command.add_option("--speed", o.speed_mps, "Ground speed, m/s")->capture_default_str();
  command.add_option("--laps", o.laps, "Rounds of a closed route")->capture_default_str();
  command.add_flag("--bank", o.bank, "Roll into turns, camera fixed to the body");
  command.add_option("--sway-deg", a.sway_deg, "Amplitude of the aircraft's smooth roll and pitch")
      ->capture_default_str();
}

void add_sensor_options(CLI::App& command, Arguments& a) {
  fly::SensorOptions& s = a.flight.sensors;
  const auto number = [&](const char* name, double& value, const char* text) {
    command.add_option(name, value, text)->capture_default_str()->check(CLI::NonNegativeNumber);
  };
  add_aircraft_options(command, a);
  number("--gnss-until", a.flight.gnss_until_s, "Time at which GNSS is cut, s");
  number("--heading-noise-deg", a.heading_noise_deg, "White error of the heading");
  number("--barometer-noise", s.barometer_noise_m, "White error of the height, m");
  number("--barometer-bias", s.barometer_bias_m, "Constant error of the height, m");
  command.add_flag("--colour", s.colour, "A camera that sees colours, where the scene has them");
  number("--blur", s.blur_px, "Blur of the camera, px (standard deviation)");
  number("--gain", s.gain, "Gain of the camera");
  command.add_option("--offset", s.offset, "Offset of the camera, gray values")->capture_default_str();
  number("--vignetting", s.vignetting, "Share of the light lost in the corners");
  number("--pixel-noise", s.pixel_noise, "Noise of the camera, gray values");
  command.add_option("--matcher", a.matcher, "How images are compared with the map: auto takes what the map offers")
      ->check(CLI::IsMember({"auto", "gray", "edge", "contour", "orientation"}))
      ->capture_default_str();
}

}  // namespace

void add_fly(CLI::App& app) {
  CLI::App* command = app.add_subcommand("fly", "Fly a simulated aircraft without GNSS by a map pack");
  auto a = std::make_shared<Arguments>();
  add_scene_options(*command, *a);
  add_route_options(*command, *a);
  add_sensor_options(*command, *a);
  command->add_option("--seed", a->seed, "Seed of all noise")->capture_default_str();
  command->add_option("--runs", a->runs, "Flights, with seeds counted up from --seed; reports pooled numbers")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  command->add_option("--frames", a->frames, "Save about this many camera pictures of the first flight")
      ->capture_default_str();
  command->add_flag("--json", a->json, "Print the summary as JSON");
  command->footer(kExamples);
  command->callback([a] { run(*a); });
}

}  // namespace landfix::tools
