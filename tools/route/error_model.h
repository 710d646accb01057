// What makes a position wrong in flight and what the filter is told about it, as numbers: drift of odometry, errors of
// a fix, how far images are independent of each other. The same model as the simulator flies (tools/fly) and the
// localizer assumes (runtime/nav/localizer.h), reduced to what is linear.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "runtime/nav/localizer.h"
#include "tools/fly/flight.h"
#include "tools/route/navigability_map.h"

namespace landfix::route {

/// Errors per axis of the grid, standard deviations unless said otherwise.
struct ErrorModel {
  // The truth.
  double drift_share = 0.025 / M_SQRT2;  ///< constant drift of odometry per metre flown, drawn once per flight
  double noise_m2_per_m = 4e-4;          ///< variance of odometry's white noise per metre
  double attitude_noise_rad = 0.00873;   ///< roll, pitch: new in every image
  double attitude_bias_rad = 0.0052;     ///< roll, pitch: drawn once per flight
  double map_bias_m = 0.25;              ///< of the map, drawn once per flight
  double start_sigma_m = 1.5;            ///< of the last position with GNSS

  // The filter.
  double assumed_drift = 0.025;               ///< share of the distance (root mean square, both axes)
  std::optional<double> drift_correlation_m;  ///< as FlightOptions has it
  double independent_fraction = 0.25;         ///< as LocalizerOptions has it

  /// Variance per metre and axis that the filter adds at this height above ground (fly::FlightOptions).
  double filter_noise_m2_per_m(double agl_m) const;
};

/// The model of a simulated flight with these options. The constant drift of odometry is taken as one vector on the
/// grid with the variance of all its parts (fly::Sensors::displacement) and of a constant error of the heading; the
/// attitude's constant error as one that keeps its direction on the grid: both exact along a straight line.
ErrorModel error_model(const fly::FlightOptions& options);

/// What flies: camera, rate of images and errors.
struct Vehicle {
  nav::Camera camera = nav::camera_from_field_of_view(640, 480, 60 * M_PI / 180);
  double image_interval_s = 0.5;
  double least_agl_m = 10;  ///< below it no image is taken to give a fix
  ErrorModel errors;

  double footprint_m(double agl_m) const;  ///< side of the square as large as the view from this height
  double camera_gsd_m(double agl_m) const;
  double image_spacing_m(double speed_mps) const { return image_interval_s * speed_mps; }
  /// Distance to be flown until an image counts as wholly new.
  double independent_m(double agl_m) const { return errors.independent_fraction * footprint_m(agl_m); }
};

/// What an image taken at a place offers, whatever came before it.
struct View {
  double fix_probability = 0, false_probability = 0;
  Eigen::Matrix2d match_m2 = Eigen::Matrix2d::Zero();  ///< covariance of the match of a true fix
  double attitude_m = 0;                               ///< white error of this image's attitude on the ground, per axis
  double bias_m = 0;                                   ///< constant errors of attitude and map on the ground, per axis
  double search_m = 0;                                 ///< to every side
  uint32_t reasons = 0;
  std::optional<Repeat> repeat;
};

/// The view from `agl_m` above a place, searched `search_m` to every side. A camera coarser than the level that the
/// map's covariance was stated for makes the match coarser in proportion.
View view_at(const NavigabilityMap& map, const Vehicle& vehicle, double east_m, double north_m, double agl_m,
             double search_m);

/// Half-width of the region that the localizer searches where its filter has this standard deviation, rounded up to a
/// power of two times 20 m: its bounds hold all but 1e-4 to each side, widened by what the attitude shifts.
double search_m(const Vehicle& vehicle, double filter_sigma_m, double agl_m);

/// Correlation of the outcomes (fix or none) of images this far apart: of views that overlap like squares of this side
/// it has the same integral.
double outcome_correlation(double distance_m, double footprint_m);

}  // namespace landfix::route
