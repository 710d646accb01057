// Gradient magnitude for correlation of edge images, the same from map and camera.
#pragma once

#include <opencv2/core.hpp>

namespace landfix::features {

inline constexpr int kEdgeHaloPx = 2;  ///< a pixel depends on the square of this many pixels around it

/// Median of 3x3 pixels, then the Sobel magnitude [Conte 2009, section 7.3.1], in integers. `gray`: H×W CV_8UC1;
/// `valid`: H×W CV_8UC1, 0 where there is no data (empty: all valid). `magnitude`: H×W CV_8UC1, 1 + min(254, half the
/// Sobel magnitude, rounded); 0 where the 5x5 pixels around one are not all valid, beyond the border included: the end
/// of the data is no edge. Throws cv::Exception for other types or sizes.
void edge(const cv::Mat& gray, const cv::Mat& valid, cv::Mat& magnitude);

}  // namespace landfix::features
