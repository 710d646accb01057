#include "tools/landfix/aircraft.h"

#include <numbers>

namespace landfix::tools {

void add_aircraft_options(CLI::App& command, AircraftArguments& a) {
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
  command
      .add_option("--drift-correlation", a.flight.drift_correlation_m,
                  "Distance over which the filter lets the drift add up to its share, m [0.7 times the height above "
                  "ground, at least 100]")
      ->check(CLI::NonNegativeNumber);
  number("--gnss-sigma", a.flight.sensors.gnss_sigma_m, "Error of GNSS per axis while there is some, m");
  command
      .add_option("--map-error", a.map_error_m,
                  "Constant error of the map that the filter expects, m per axis [as the pack says]")
      ->check(CLI::NonNegativeNumber);
}

fly::FlightOptions flight_of(const AircraftArguments& a, const lf_info& map) {
  constexpr double kRadians = std::numbers::pi / 180;
  fly::FlightOptions flight = a.flight;
  flight.camera = nav::camera_from_field_of_view(a.image_size[0], a.image_size[1], a.field_of_view_deg * kRadians);
  flight.sensors.attitude_noise_rad = a.attitude_noise_deg * kRadians;
  flight.sensors.attitude_bias_rad = a.attitude_bias_deg * kRadians;
  flight.sensors.heading_noise_rad = a.heading_noise_deg * kRadians;
  flight.sensors.heading_bias_rad = a.heading_bias_deg * kRadians;
  const double map_error_m = a.map_error_m >= 0 ? a.map_error_m : map.georegistration_error_m;
  if (map_error_m >= 0) flight.localizer.map_bias_sigma_m = map_error_m;
  return fly::with_known_errors(flight);
}

}  // namespace landfix::tools
