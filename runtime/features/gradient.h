// Smoothing and derivatives that the operators of this folder share, in integers: no byte depends on the machine or on
// where an image begins.
#pragma once

#include <opencv2/core.hpp>

namespace landfix::features {

inline constexpr int kGradientRadiusPx = 3;  ///< a gradient is made of 7x7 pixels
inline constexpr int kGradientScale = 8;     ///< gradients are in eighths of a gray level

/// Checks an image against its mask, throws cv::Exception where type or size differ; returns the mask, made where it is
/// empty.
cv::Mat checked_mask(const cv::Mat& image, const cv::Mat& valid);

/// 255 where all pixels of the square of `radius` around one are valid, beyond the border excluded; else 0.
cv::Mat eroded(const cv::Mat& valid, int radius);

/// Sobel of a band smoothed by the binomial [1 4 6 4 1] in x and y. `band`: CV_8UC1; `gx` (towards the right) and `gy`
/// (down): CV_16SC1 of the same size, `kGradientScale` to a gray level. The outermost `kGradientRadiusPx` pixels are 0.
void gradient(const cv::Mat& band, cv::Mat& gx, cv::Mat& gy);

}  // namespace landfix::features
