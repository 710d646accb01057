// The simulated sensors: what the aircraft knows of the truth, with the errors of real instruments.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>

#include "builder/terrain/scene.h"
#include "tools/fly/noise.h"

namespace landfix::fly {

/// Errors of the sensors. "Bias" is constant during a flight, "noise" is white with this standard deviation.
struct SensorOptions {
  double attitude_noise_rad = 0.5 * M_PI / 180;  ///< roll and pitch
  double attitude_bias_rad = 0.3 * M_PI / 180;   ///< roll and pitch: this size, sign drawn for each
  double heading_noise_rad = 0.5 * M_PI / 180;
  double heading_bias_rad = 0.3 * M_PI / 180;  ///< this size, sign drawn
  double barometer_noise_m = 0.3;
  double barometer_bias_m = 0.5;  ///< this size, sign drawn
  double gnss_sigma_m = 1.5;      ///< per axis
  double odometry_drift = 0.025;  ///< typical error of dead reckoning as a share of the distance flown

  bool colour = false;   ///< the camera's, where the scene has colours
  double blur_px = 0.8;  ///< standard deviation of a Gaussian
  double gain = 0.85, offset = 12;
  double vignetting = 0.15;  ///< loss of light in the corners
  double pixel_noise = 4;    ///< gray values
};

/// Draws the constant errors when made, the others at each reading; the same seed gives the same readings.
class Sensors {
 public:
  Sensors(const SensorOptions& options, uint64_t seed);

  nav::Attitude attitude(const nav::Attitude& truth);
  double height(double truth_m);
  Eigen::Vector2d gnss_position(double east_m, double north_m);

  /// Odometry turned onto the grid by the measured heading: displacement (east, north) between two poses. Three errors
  /// make the drift: one constant per distance on the grid in a drawn direction, of 0.9 times the stated share, which
  /// a closed loop does not cancel; and errors of scale and of direction in the body frame, drawn with 0.3 times the
  /// share each. Along a straight line the dead-reckoned end is then off by about the share of the distance (root mean
  /// square). Noise of 2 cm per square root of a metre comes on top.
  Eigen::Vector2d displacement(const terrain::Pose& from, const terrain::Pose& to);

  /// Gray (or colour) picture with blur, vignetting, gain, offset and noise. `image`: CV_8UC1 or CV_8UC3 (red, green, blue).
  cv::Mat picture(const cv::Mat& image);

 private:
  SensorOptions options_;
  NoiseStream constant_, attitude_, heading_, barometer_, gnss_, odometry_, pixels_;
  nav::Attitude attitude_bias_;
  double barometer_bias_m_, odometry_scale_, odometry_crab_rad_;
  Eigen::Vector2d grid_drift_;
};

}  // namespace landfix::fly
