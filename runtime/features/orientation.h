// Doubled-angle gradient orientation: what survives a change of season, sun and sensor. The same from map and camera.
#pragma once

#include <opencv2/core.hpp>
#include <span>

namespace landfix::features {

struct OrientationOptions {
  float half_weight = 15;  ///< gradient (Sobel of gray levels, per band) at which the weight is one half
};

/// A pixel depends on the square of this many pixels around it: 3 of its gradient, 2 of the sums.
inline constexpr int kOrientationHaloPx = 5;

/// Orientation of an image of 1 to 4 bands, from the structure tensor summed over the bands, so that edges which cancel
/// in gray are kept. Each band is smoothed by the binomial [1 4 6 4 1] / 16 in x and y (sigma 1 pixel), differentiated
/// by Sobel's operator; the sums over the bands of gx² - gy², 2 gx gy and gx² + gy² = m² are smoothed by the same
/// binomial. Then a = sum(gx² - gy²) w and b = sum(2 gx gy) w with w = 1 / ((m + 1) (m + half_weight sqrt(bands))):
/// (a, b) is the gradient's direction, doubled, with a length below 1 that falls with the gradient. x runs to the right
/// and y down (south): a = 1 for an edge that runs north-south, -1 for east-west; b = 1 for a gradient towards
/// south-east or north-west, so for an edge that runs south-west to north-east, -1 for north-west to south-east.
///
/// `bands`: H×W CV_8UC(1-4); `valid`: H×W CV_8UC1, 0 where there is no data (empty: all valid). A gradient counts where
/// the 7x7 pixels that it is made of are all valid, beyond the border excluded; elsewhere it adds nothing to the sums,
/// and the pixel is not valid. `ab`: H×W CV_32FC2, 0 where not valid; `ab_valid`: H×W CV_8UC1, 255 or 0. Throws
/// cv::Exception for other types or sizes.
void orientation(const cv::Mat& bands, const cv::Mat& valid, const OrientationOptions& options, cv::Mat& ab,
                 cv::Mat& ab_valid);

/// Orientation of one capture date.
struct DatedOrientation {
  cv::Mat ab;     ///< CV_32FC2
  cv::Mat valid;  ///< CV_8UC1
};

/// One map of several dates, of one size: at every pixel the mean over the dates that are valid there. What stays is
/// kept, what changes cancels. Throws cv::Exception for no date or different sizes.
DatedOrientation fuse(std::span<const DatedOrientation> dates);

/// How much dates agree, over blocks of `block` x `block` pixels: sum |sum over dates v| / sum (sum over dates |v|)
/// with v = (a, b), both over the pixels of the block where two dates or more are valid. `agreement`: CV_8UC2 of size /
/// block: 1 (they contradict each other, or nothing is to be seen) to 255 (they say the same), and the largest number
/// of dates at a pixel; 0, 0 where fewer than half of the pixels have two dates. Throws cv::Exception for different
/// sizes or ones that `block` does not divide.
void agreement(std::span<const DatedOrientation> dates, int block, cv::Mat& agreement);

}  // namespace landfix::features
