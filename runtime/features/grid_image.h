// An image that knows where it lies on the grid: the currency between map, scene and matcher.
#pragma once

#include <opencv2/core.hpp>

namespace landfix::features {

/// Pixels on the metric grid, north up. The centre of pixel (column x, row y) lies at easting `west_m + (x + 0.5)
/// gsd_m` and northing `north_m - (y + 0.5) gsd_m`.
struct GridImage {
  cv::Mat pixels;      ///< H×W, any type
  cv::Mat valid;       ///< H×W CV_8UC1, 255 where `pixels` holds data and 0 where not; empty means all valid
  double west_m = 0;   ///< easting of the left edge
  double north_m = 0;  ///< northing of the top edge
  double gsd_m = 1;    ///< ground sample distance

  double column_of(double east_m) const { return (east_m - west_m) / gsd_m - 0.5; }
  double row_of(double north) const { return (north_m - north) / gsd_m - 0.5; }
};

}  // namespace landfix::features
