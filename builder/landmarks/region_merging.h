// Ground of one colour: pixels joined to ever larger regions, the least different first.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace landfix::landmarks {

/// How the pixels of a mask were joined. Nodes are numbered in the order in which they came to be: pixels first.
struct MergeTree {
  struct Node {
    int32_t parent = -1;  ///< -1: a root
    int32_t first = 0;    ///< of its pixels in `pixels`
    int32_t count = 0;    ///< of them
    float strength = 0;   ///< the greatest cost of a merge inside of it
    cv::Rect box;         ///< of its pixels
  };
  std::vector<Node> nodes;
  std::vector<int32_t> pixels;  ///< row * columns + column, those of a node side by side
};

/// Logarithms of the values of an image (CV_8UC1 to 4), 100 for a factor of e, as colours to merge by: what light and
/// shade multiply they shift. The fewer bands the more each counts, as much together as three.
cv::Mat log_colours(const cv::Mat& image);

/// Joins 4-neighbours of `mask` (CV_8UC1, not 0) while a merge costs no more than `most`: a b / (a + b) times the
/// squared distance of the mean colours over the length of the common boundary, a and b the areas in pixels; what it
/// adds to the piecewise constant Mumford-Shah functional (full lambda schedule: Koepfler, Lopez and Morel 1994;
/// Redding et al. 1999). `colours`: CV_16SC(n), n <= 4, of the same size. No region gets more than `most_px` pixels.
MergeTree merge_regions(const cv::Mat& colours, const cv::Mat& mask, double most, int most_px);

}  // namespace landfix::landmarks
