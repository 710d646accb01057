// The gray value that map and camera share.
#pragma once

#include <opencv2/core.hpp>

namespace landfix::features {

/// Luma of an 8-bit image, ITU-R BT.601 in integers: (299 R + 587 G + 114 B + 500) / 1000, the same bytes on every
/// machine. `rgb`: H×W, 3 or more channels ordered red, green, blue (further ones are ignored), or 1 channel, which is
/// copied. Returns H×W, CV_8UC1. Throws cv::Exception for another depth or for 0 or 2 channels.
cv::Mat gray_from_rgb(const cv::Mat& rgb);

}  // namespace landfix::features
