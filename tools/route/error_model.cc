#include "tools/route/error_model.h"

#include <algorithm>
#include <cmath>

namespace landfix::route {
namespace {

// As fly::FlightOptions::drift_correlation_m and fly::Sensors state them.
constexpr double kShortestDriftCorrelationM = 100, kDriftCorrelationPerHeight = 0.7;
constexpr double kGridShare = 0.9, kBodyShare = 0.3;
constexpr double kOdometryNoisePerRootMetre = 0.02;

// As the localizer searches: 1e-4 of a Gaussian beyond each side, four sigmas of attitude.
constexpr double kSearchSigmas = 3.72, kAttitudeSearchSigmas = 4;
constexpr double kLeastSearchM = 20, kLargestSearchM = 20 * 1024;

}  // namespace

double ErrorModel::filter_noise_m2_per_m(double agl_m) const {
  const double correlation_m =
      drift_correlation_m.value_or(std::max(kShortestDriftCorrelationM, kDriftCorrelationPerHeight * agl_m));
  return assumed_drift * assumed_drift * correlation_m;
}

ErrorModel error_model(const fly::FlightOptions& options) {
  const fly::SensorOptions& sensors = options.sensors;
  const double d = sensors.odometry_drift, heading = sensors.heading_bias_rad;
  ErrorModel model;
  // Both axes: grid drift, scale, direction, heading.
  model.drift_share =
      std::sqrt((d * d * (kGridShare * kGridShare + 2 * kBodyShare * kBodyShare) + heading * heading) / 2);
  model.noise_m2_per_m = kOdometryNoisePerRootMetre * kOdometryNoisePerRootMetre;
  model.attitude_noise_rad = sensors.attitude_noise_rad;
  model.attitude_bias_rad = sensors.attitude_bias_rad;
  model.map_bias_m = options.localizer.map_bias_sigma_m;
  model.start_sigma_m = sensors.gnss_sigma_m;
  model.assumed_drift = std::hypot(d, heading);
  model.drift_correlation_m = options.drift_correlation_m;
  model.independent_fraction = options.localizer.independent_fraction;
  return model;
}

double Vehicle::footprint_m(double agl_m) const {
  return agl_m * std::sqrt(camera.width / camera.fx * camera.height / camera.fy);
}

double Vehicle::camera_gsd_m(double agl_m) const { return agl_m / std::max(camera.fx, camera.fy); }

View view_at(const NavigabilityMap& map, const Vehicle& vehicle, double east_m, double north_m, double agl_m,
             double search_m) {
  View view;
  view.search_m = search_m;
  if (agl_m < vehicle.least_agl_m) {
    view.reasons = kTooLow;
    return view;
  }
  const std::optional<Navigability> known = map.at(east_m, north_m, vehicle.footprint_m(agl_m), search_m);
  if (!known) {
    view.reasons = map.extent().holds(east_m, north_m) ? kNoImage : kOffMap;
    return view;
  }
  view.fix_probability = std::clamp(known->fix_probability, 0.0, 1.0);
  view.false_probability = std::clamp(known->false_probability, 0.0, 1 - view.fix_probability);
  const double coarser = known->gsd_m > 0 ? std::max(1.0, vehicle.camera_gsd_m(agl_m) / known->gsd_m) : 1;
  view.match_m2 = coarser * coarser * known->covariance_m2;
  view.attitude_m = vehicle.errors.attitude_noise_rad * agl_m;
  view.bias_m = std::hypot(vehicle.errors.attitude_bias_rad * agl_m, vehicle.errors.map_bias_m);
  view.reasons = known->reasons;
  view.repeat = known->repeat;
  return view;
}

double search_m(const Vehicle& vehicle, double filter_sigma_m, double agl_m) {
  const double wanted =
      kSearchSigmas * filter_sigma_m + kAttitudeSearchSigmas * vehicle.errors.attitude_noise_rad * agl_m;
  double search = kLeastSearchM;
  while (search < wanted && search < kLargestSearchM) search *= 2;
  return search;
}

double outcome_correlation(double distance_m, double footprint_m) {
  return footprint_m > 0 ? std::exp(-2 * distance_m / footprint_m) : 0;
}

}  // namespace landfix::route
