#include "tools/fly/sensors.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "runtime/features/gray.h"

namespace landfix::fly {
namespace {

// Shares of the stated drift, see Sensors::displacement.
constexpr double kGridShare = 0.9, kBodyShare = 0.3;
constexpr double kOdometryNoisePerRootMetre = 0.02;

}  // namespace

Sensors::Sensors(const SensorOptions& options, uint64_t seed)
    : options_(options),
      constant_(seed, Stream::kConstant),
      attitude_(seed, Stream::kAttitude),
      heading_(seed, Stream::kHeading),
      barometer_(seed, Stream::kBarometer),
      gnss_(seed, Stream::kGnss),
      odometry_(seed, Stream::kOdometry),
      pixels_(seed, Stream::kPixels) {
  attitude_bias_.roll = options.attitude_bias_rad * constant_.sign();
  attitude_bias_.pitch = options.attitude_bias_rad * constant_.sign();
  attitude_bias_.heading = options.heading_bias_rad * constant_.sign();
  barometer_bias_m_ = options.barometer_bias_m * constant_.sign();
  odometry_scale_ = 1 + kBodyShare * options.odometry_drift * constant_.gaussian();
  odometry_crab_rad_ = kBodyShare * options.odometry_drift * constant_.gaussian();
  const double direction = 2 * M_PI * constant_.uniform();
  grid_drift_ = kGridShare * options.odometry_drift * Eigen::Vector2d(std::sin(direction), std::cos(direction));
}

nav::Attitude Sensors::attitude(const nav::Attitude& truth) {
  nav::Attitude measured;
  measured.roll = truth.roll + attitude_bias_.roll + options_.attitude_noise_rad * attitude_.gaussian();
  measured.pitch = truth.pitch + attitude_bias_.pitch + options_.attitude_noise_rad * attitude_.gaussian();
  measured.heading = truth.heading + attitude_bias_.heading + options_.heading_noise_rad * heading_.gaussian();
  return measured;
}

double Sensors::height(double truth_m) {
  return truth_m + barometer_bias_m_ + options_.barometer_noise_m * barometer_.gaussian();
}

Eigen::Vector2d Sensors::gnss_position(double east_m, double north_m) {
  const double east = east_m + options_.gnss_sigma_m * gnss_.gaussian();
  return {east, north_m + options_.gnss_sigma_m * gnss_.gaussian()};
}

Eigen::Vector2d Sensors::displacement(const terrain::Pose& from, const terrain::Pose& to) {
  const Eigen::Vector2d truth(to.east_m - from.east_m, to.north_m - from.north_m);
  const double heading_error =
      attitude_bias_.heading + options_.heading_noise_rad * odometry_.gaussian() + odometry_crab_rad_;
  // Headings turn clockwise, so an angle of rotation on (east, north) is negative.
  const Eigen::Vector2d turned = Eigen::Rotation2Dd(-heading_error) * (odometry_scale_ * truth);
  const double sigma_m = kOdometryNoisePerRootMetre * std::sqrt(truth.norm());
  const double noise_east = sigma_m * odometry_.gaussian();
  return turned + truth.norm() * grid_drift_ + Eigen::Vector2d(noise_east, sigma_m * odometry_.gaussian());
}

cv::Mat Sensors::picture(const cv::Mat& image) {
  cv::Mat light;
  (options_.colour ? image : features::gray_from_rgb(image)).convertTo(light, CV_32F);
  if (options_.blur_px > 0) cv::GaussianBlur(light, light, {}, options_.blur_px);
  const double cx = 0.5 * (light.cols - 1), cy = 0.5 * (light.rows - 1), corner2 = cx * cx + cy * cy;
  const int channels = light.channels();
  cv::Mat seen(light.size(), CV_8UC(channels));
  for (int y = 0; y < seen.rows; ++y) {
    for (int x = 0; x < seen.cols; ++x) {
      const double fall_off = 1 - options_.vignetting * ((x - cx) * (x - cx) + (y - cy) * (y - cy)) / corner2;
      for (int i = x * channels; i < (x + 1) * channels; ++i) {
        const double value = options_.gain * fall_off * light.ptr<float>(y)[i] + options_.offset +
                             options_.pixel_noise * pixels_.coarse_gaussian();
        seen.ptr(y)[i] = cv::saturate_cast<uchar>(value);
      }
    }
  }
  return seen;
}

}  // namespace landfix::fly
