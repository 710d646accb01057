// Ground with relief to look at obliquely in tests: height and gray value as functions, a camera that marches its rays.
#pragma once

#include <functional>
#include <opencv2/core.hpp>

#include "runtime/nav/camera.h"
#include "runtime/nav/terrain.h"

namespace landfix::nav::testing {

/// A value over (east, north).
using Surface = std::function<double(double, double)>;

struct ReliefScene {
  Surface height_m;
  Surface gray;
  double highest_m = 0;  ///< of `height_m`, where marching begins

  /// What the camera sees, ray by ray through the lens; 0 where a ray meets nothing within 2 km.
  cv::Mat take_picture(const Camera& camera, const Attitude& attitude, const Position& position) const;

  /// Whether no ground between the camera and this point of it rises into the line of sight by more than `slack_m`.
  bool visible(double east_m, double north_m, const Position& camera, double slack_m = 1e-9) const;

  /// `height_m` sampled at the pixel centres of a square grid around a place.
  features::GridImage heights(double east_m, double north_m, double half_side_m, double gsd_m) const;
};

}  // namespace landfix::nav::testing
