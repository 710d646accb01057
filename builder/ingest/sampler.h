// Resampling of a piece of a raster at given places, in arithmetic that gives the same bytes everywhere.
//
// GDAL's warper does the same to within rounding (a test compares them), but takes about five times as long, chooses
// its kernel by the window and rounds differently where a mask lies in the window.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

namespace landfix::ingest {

/// A piece of a raster. Whatever lies outside has no data.
struct Patch {
  cv::Mat pixels;               ///< H×W CV_8UC(1-4) or CV_32FC1
  cv::Mat valid;                ///< H×W CV_8UC1, 0 where there is no data; empty: all valid
  int64_t column = 0, row = 0;  ///< of its first pixel in the raster
};

/// Source pixels per destination pixel along the source's columns and rows.
struct Reduction {
  double x = 1, y = 1;
};

/// Radius in source pixels of the kernel of a reduction: a triangle of one source pixel, widened to the destination
/// pixel where that is more than 1/0.95 of a source pixel (as GDAL does).
double kernel_radius(double reduction);

/// Fills those pixels of `out` that are not yet valid from the patch, and marks them valid. `x`, `y`: CV_64FC1, raster
/// coordinates of each pixel (0.5 is the centre of the first column or row; NaN: nowhere). `out`: type of the patch;
/// `valid`: CV_8UC1; all of one size. Weights of source pixels without data are left out. A pixel becomes valid where
/// at least 24 % of its kernel's weight has data: a little less than a quarter, so that four images that meet at a
/// corner leave no hole. Returns the number of pixels filled.
int64_t resample(const Patch& patch, const cv::Mat& x, const cv::Mat& y, const Reduction& reduction, cv::Mat out,
                 cv::Mat valid);

}  // namespace landfix::ingest
