// Vocabularies of visual words.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

namespace landfix::landmarks {

/// Centres (words x columns, CV_32FC1) of the rows of `points` (CV_32FC1, at least `words` of them): k-means++ (Arthur,
/// Vassilvitskii 2007), then Lloyd's steps whose assignment is FLANN's. Its exact index: an approximate one would save
/// nothing at a hundred centres, and its random trees would make the bytes depend on the library's generator. The same
/// centres for a seed. Throws cv::Exception for other arguments.
cv::Mat k_means(const cv::Mat& points, int words, uint64_t seed);

}  // namespace landfix::landmarks
