// A map in memory for flights in tests, and what their localizer is told.
#pragma once

#include <cmath>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>

#include "builder/terrain/scene.h"
#include "runtime/nav/map_source.h"
#include "tools/fly/flight.h"

namespace landfix::fly {

/// A gray image and heights as the map that the localizer asks.
class MemoryMap : public nav::MapSource {
 public:
  MemoryMap(const features::GridImage& gray, const features::GridImage& heights)
      : texture_(gray), scene_(gray, heights) {}

  std::pair<double, double> gsd_range_m(nav::MapLayer layer) const override {
    if (layer != nav::MapLayer::kGray) return {0, 0};
    const double finest = texture_.base().gsd_m;
    return {finest, 8 * finest};
  }

  nav::Status read(nav::MapLayer layer, double west_m, double south_m, double east_m, double north_m, double gsd_m,
                   features::GridImage& window) const override {
    if (layer != nav::MapLayer::kGray) return nav::Status::kNoLayer;
    window.gsd_m = gsd_m;
    window.west_m = gsd_m * std::floor(west_m / gsd_m);
    window.north_m = gsd_m * std::ceil(north_m / gsd_m);
    const cv::Size size(int(std::ceil((east_m - window.west_m) / gsd_m)),
                        int(std::ceil((window.north_m - south_m) / gsd_m)));
    window.pixels = cv::Mat::zeros(size, CV_8UC1);
    window.valid = cv::Mat::zeros(size, CV_8UC1);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        float value;
        if (!texture_.sample(window.west_m + (x + 0.5) * gsd_m, window.north_m - (y + 0.5) * gsd_m, gsd_m, &value))
          continue;
        window.pixels.at<uchar>(y, x) = uchar(value + 0.5f);
        window.valid.at<uchar>(y, x) = 255;
      }
    }
    return cv::countNonZero(window.valid) > 0 ? nav::Status::kOk : nav::Status::kOutsideMap;
  }

  std::optional<double> ground_height_m(double east_m, double north_m) const override {
    return scene_.height_below(east_m, north_m);
  }

 private:
  terrain::Texture texture_;
  terrain::Scene scene_;
};

/// What the localizer is told of its sensors.
inline FlightOptions with_known_errors(FlightOptions options) {
  options.localizer.attitude_sigma_rad = options.sensors.attitude_noise_rad;
  options.localizer.attitude_bias_sigma_rad = options.sensors.attitude_bias_rad;
  return options;
}

}  // namespace landfix::fly
