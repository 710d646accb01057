// What textbooks judge a place of a map by: how much there is to be seen in its gray values.
#pragma once

#include <array>
#include <opencv2/core.hpp>

namespace landfix::eval {

inline constexpr size_t kTextures = 4;
inline constexpr std::array<const char*, kTextures> kTextureNames = {"entropy", "standard_deviation", "edge_density",
                                                                     "fisher_information"};

/// By kTextureNames, all the higher the more there is: entropy of the histogram of 32 bins in bits; standard deviation
/// of the gray values; share of pixels whose gradient by Sobel's operator is longer than 60 (7.5 gray levels per
/// pixel); the lesser eigenvalue of the mean of the gradients' outer products, in (gray levels per pixel)²: the
/// information about the worse known direction, of noise of one gray level per pixel. `gray`: CV_8UC1, not empty.
std::array<double, kTextures> textures_of(const cv::Mat& gray);

}  // namespace landfix::eval
