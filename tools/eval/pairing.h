// Which of two sets of places are the same.
#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

namespace landfix::eval {

struct Pair {
  double distance_m = 0;
  size_t a = 0, b = 0;  ///< indices
};

/// Pairs within reach, the nearest first; each place in one of them at most.
std::vector<Pair> nearest_pairs(std::span<const cv::Point2d> a, std::span<const cv::Point2d> b, double reach_m);

}  // namespace landfix::eval
