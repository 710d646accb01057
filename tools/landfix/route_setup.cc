#include "tools/landfix/route_setup.h"

#include <array>
#include <numbers>

#include "tools/common/manifest_json.h"
#include "tools/common/open_pack.h"

namespace landfix::tools {
namespace {

constexpr double kRadians = std::numbers::pi / 180;

std::optional<int> day_of(const std::string& date) {
  if (date.empty()) return std::nullopt;
  const std::optional<int> day = nav::day_of(date.c_str());
  if (!day) throw Error(ExitCode::kUsage, "--date: expected a day such as 2026-05-31, found \"" + date + '"');
  return day;
}

fly::FlightOptions flight_options(const RouteArguments& a, const lf_info& map) {
  fly::FlightOptions flight = a.flight;
  flight.gnss_until_s = 0;
  flight.camera = nav::camera_from_field_of_view(a.image_size[0], a.image_size[1], a.field_of_view_deg * kRadians);
  flight.sensors.attitude_noise_rad = a.attitude_noise_deg * kRadians;
  flight.sensors.attitude_bias_rad = a.attitude_bias_deg * kRadians;
  flight.sensors.heading_bias_rad = a.heading_bias_deg * kRadians;
  const double map_error_m = a.map_error_m >= 0 ? a.map_error_m : map.georegistration_error_m;
  if (map_error_m >= 0) flight.localizer.map_bias_sigma_m = map_error_m;
  return fly::with_known_errors(flight);
}

void add_vehicle_options(CLI::App& command, RouteArguments& a) {
  const auto number = [&](const char* name, double& value, const char* text) {
    command.add_option(name, value, text)->capture_default_str()->check(CLI::NonNegativeNumber);
  };
  number("--image-interval", a.flight.image_interval_s, "Time between images, s");
  number("--fov-deg", a.field_of_view_deg, "Horizontal field of view of the camera");
  command.add_option("--image-size", a.image_size, "Pixels of the camera")
      ->delimiter(',')
      ->expected(2)
      ->type_name("WIDTH,HEIGHT")
      ->capture_default_str();
  number("--attitude-noise-deg", a.attitude_noise_deg, "White error of roll and pitch");
  number("--attitude-bias-deg", a.attitude_bias_deg, "Constant error of roll and pitch");
  number("--heading-bias-deg", a.heading_bias_deg, "Constant error of the heading");
  number("--odometry-drift", a.flight.sensors.odometry_drift, "Error of dead reckoning as a share of the distance");
  number("--gnss-sigma", a.flight.sensors.gnss_sigma_m, "Error of the last position with GNSS per axis, m");
  command.add_option("--map-error", a.map_error_m, "Constant error of the map, m per axis [as the pack says]")
      ->check(CLI::NonNegativeNumber);
}

}  // namespace

void add_route_options(CLI::App& command, RouteArguments& a) {
  command.add_option("--map", a.map, "The map pack, with navigability")->required()->type_name("PACK");
  command.add_option("--key", a.key_files, "Trusted public key file of the map (may be repeated)")
      ->allow_extra_args(false);
  command.add_option("--require", a.require, "Position error and the share of cases in which it must be kept")
      ->capture_default_str()
      ->type_name("METRESm@PERCENT%");
  command
      .add_option("--date", a.date,
                  "Day of the flight: chances fall with the age of the map [as old as maps usually are]")
      ->type_name("YYYY-MM-DD");
  command.add_option("--corridor", a.score.corridor_m, "Half the width of the corridor to stay in, m")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  add_vehicle_options(command, a);
}

RouteSetup::RouteSetup(const RouteArguments& a)
    : pack(open_pack(a.map, a.key_files)),
      info(pack.info()),
      zone(zone_of(pack)),
      ground(pack),
      navigability(route::open_navigability(pack, a.map, day_of(a.date))),
      flight(flight_options(a, info)),
      score(a.score) {
  prepare_layers(pack, a.map, std::array{"height"});
  heights.ground_m = [this](double east_m, double north_m) -> std::optional<double> {
    const route::Extent e = navigability->extent();
    return e.holds(east_m, north_m) ? ground.ground_height_m(east_m, north_m) : std::nullopt;
  };
  heights.geoid_m = [this](double east_m, double north_m) -> std::optional<double> {
    const Result<double> undulation = pack.undulation(east_m, north_m);
    return undulation ? std::optional(*undulation) : std::nullopt;
  };
  vehicle.camera = flight.camera;
  vehicle.image_interval_s = flight.image_interval_s;
  vehicle.errors = route::error_model(flight);
  score.requirement = route::parse_requirement(a.require);
}

}  // namespace landfix::tools
