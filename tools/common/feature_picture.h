// Landmarks and roads drawn over a picture of the map.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "landfix/landfix.hpp"
#include "tools/common/map_features.h"

namespace landfix::tools {

/// What is drawn; absent: not asked for.
struct DrawnFeatures {
  std::optional<std::vector<Landmark>> landmarks;
  std::optional<RoadSet> roads;
  std::vector<Intersection> intersections;  ///< with the roads
};

/// Draws over `picture` (CV_8UC4: blue, green, red, alpha) of a region: landmarks as the outlines of their rectangles
/// or, without an orientation, circles, the less sure the fainter; roads as lines, intersections as rings with a tick
/// for each arm. The picture is enlarged where it is small, and a legend with counts stands below it.
cv::Mat draw_features(const cv::Mat& picture, const Region& region, const DrawnFeatures& features);

}  // namespace landfix::tools
