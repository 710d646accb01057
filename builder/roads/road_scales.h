// An image at the two scales at which roads are sought, and what a place looks like at both.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "runtime/features/road_filter.h"
#include "runtime/features/road_profile.h"

namespace landfix::landmarks {

inline constexpr size_t kRoadScaleFeatures = 2 * features::kRoadProfileFeatures + 1;
/// The profile at 1 m, that at 2 m, which shows the ground as far as 24 m aside, and the scale that proposed the place.
using RoadScaleProfile = std::array<float, kRoadScaleFeatures>;

class RoadScales {
 public:
  /// `image`: CV_8UC1 or CV_8UC3 (red, green, blue) at 1 m per pixel; `valid`: CV_8UC1 or empty (all valid). A pixel of
  /// 2 m is the rounded mean of 2x2, and valid where all four are.
  RoadScales(const cv::Mat& image, const cv::Mat& valid);

  static constexpr int kLevels = 2;
  /// Pixels of a level, 1 or 2 m; the second may have none.
  cv::Size size(int level) const { return bands_[size_t(level)].size(); }
  /// The candidates of a level, in pixels of that level.
  std::vector<features::RoadCandidate> candidates(int level) const;
  /// The profile at the level that proposed the candidate; returns its width in pixels of that level.
  float describe(const features::RoadCandidate& candidate, int level, features::RoadProfile& profile) const;
  /// The same and the profile at the other level. `own`: what describe() said of it.
  void describe(const features::RoadCandidate& candidate, int level, const features::RoadProfile& own,
                RoadScaleProfile& profile) const;

 private:
  std::array<cv::Mat, kLevels> bands_, valid_;
};

}  // namespace landfix::landmarks
