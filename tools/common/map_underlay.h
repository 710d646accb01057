// The map in gray below what is drawn over it, seen as light and shade of its colours.
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "landfix/landfix.hpp"

namespace landfix::tools {

/// A part of the grid as pixels.
struct MapFrame {
  double west_m = 0, north_m = 0, px_per_m = 1;
  cv::Size size;

  /// Where a place lies, in coordinates whose integers are the centres of pixels.
  cv::Point2d at(double east_m, double north) const {
    return {(east_m - west_m) * px_per_m - 0.5, (north_m - north) * px_per_m - 0.5};
  }
};

/// Colour of what the map does not show, and the ground of legends.
inline constexpr uint8_t kNothingShown = 40;

/// The overview in gray, or the gray layer where the overview is much coarser than the picture; kNothingShown where the
/// map has nothing. Returns CV_8UC1 of the frame's size; empty where the pack has neither layer.
cv::Mat map_in_gray(const Pack& pack, const MapFrame& frame, const std::string& pack_path);

/// Colours (CV_8UC3) where `where` (CV_8UC1) is not 0, with the light and shade of the map below (CV_8UC1) so that
/// their hue stays that of the legend, and the map itself elsewhere. Without a map the colours as they are. Returns
/// CV_8UC3.
cv::Mat coloured_map(const cv::Mat& map, const cv::Mat& colours, const cv::Mat& where);

/// Of kChanceClasses, in OpenCV's order (blue, green, red).
cv::Scalar colour_of_class(size_t chance_class);

}  // namespace landfix::tools
