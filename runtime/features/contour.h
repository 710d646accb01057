// Thinned contours and the distance to them, for chamfer matching and for the heading from lines.
#pragma once

#include <opencv2/core.hpp>

namespace landfix::features {

struct ContourOptions {
  double contrast = 1.5;      ///< a contour's gradient is at least this many times the mean gradient around it
  int window_radius_px = 16;  ///< of the square of that mean; at most 64
  int floor = 16;          ///< and at least this much, in gray levels of the Sobel operator (8 times the slope per px)
  int min_length_px = 16;  ///< chains of fewer pixels (8-connected) are dropped
  int truncation_px = 8;   ///< longest distance that is told apart; at most 15
};

/// A pixel of `contours` depends on the square of this many pixels around it: Sobel of smoothed pixels, neighbours
/// across the gradient, the mean, and the chain.
inline int contours_halo_px(const ContourOptions& o) {
  return 3 + (o.window_radius_px > 1 ? o.window_radius_px : 1) + o.min_length_px - 1;
}

/// The same for `contour_distance` of `contours`.
inline int contour_halo_px(const ContourOptions& o) { return contours_halo_px(o) + o.truncation_px; }

/// Thinned contours: where the Sobel magnitude of the image, smoothed by the binomial [1 4 6 4 1], is largest across
/// the contour (non-maximum suppression in four directions, Canny 1986) and above a threshold that follows the mean
/// magnitude around, so that neither brightness nor contrast of the image as a whole matters. `gray`: H×W CV_8UC1;
/// `valid`: H×W CV_8UC1, 0 where there is no data (empty: all valid). `mask`: H×W CV_8UC1, 255 on contours. `known`:
/// H×W CV_8UC1, 255 where there could be one: where the 7x7 pixels around are valid, beyond the border excluded. A
/// chain that leaves what is known counts with the part inside. Throws cv::Exception for other types, sizes or options.
void contours(const cv::Mat& gray, const cv::Mat& valid, const ContourOptions& options, cv::Mat& mask, cv::Mat& known);

/// The same with the direction of the gradient: CV_32FC1, atan2(gy, gx) in radians within (-pi, pi], x to the right and
/// y down, from dark to bright across the contour; 0 off the contours.
void contours(const cv::Mat& gray, const cv::Mat& valid, const ContourOptions& options, cv::Mat& mask, cv::Mat& known,
              cv::Mat& direction);

/// Distance in pixels to the nearest contour: H×W CV_8UC1, 1 + min(distance, truncation_px), rounded to whole pixels up
/// to 2 and to even ones beyond: nearby a match needs them, farther off they cost bytes. 0 where not `known`. `mask`,
/// `known`: of `contours`.
void contour_distance(const cv::Mat& mask, const cv::Mat& known, const ContourOptions& options, cv::Mat& distance);

}  // namespace landfix::features
