// Thin lines of a mask as paths between their ends and branches.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace landfix::landmarks {

/// A line between two nodes, in pixels; both equal: a ring.
struct Path {
  int from = 0, to = 0;
  std::vector<cv::Point2d> points;
};

double length_of(const std::vector<cv::Point2d>& points);

/// How many ends of paths meet at each node; a ring counts twice.
std::vector<int> degrees_of(const std::vector<Path>& paths);

/// Thins what is not 0 in `mask` (CV_8UC1) to lines of one pixel (Zhang and Suen 1984).
void thin(cv::Mat& mask);

/// The paths of a thinned mask; rings of 20 pixels or less are left out.
std::vector<Path> trace(const cv::Mat& thinned);

/// Joins the two paths of every node where just two meet.
std::vector<Path> join(std::vector<Path> paths);

/// Takes away paths shorter than `spur_px` with one free end, the shortest first, but for those that leave the image.
std::vector<Path> prune(std::vector<Path> paths, double spur_px, const cv::Size& size);

/// Groups of paths that hang together, as indices, ascending.
std::vector<std::vector<size_t>> components_of(const std::vector<Path>& paths);

/// Union of sets of nodes.
class NodeSets {
 public:
  explicit NodeSets(size_t count);
  int root(int node);
  void unite(int a, int b) { parent_[size_t(root(a))] = root(b); }

 private:
  std::vector<int> parent_;
};

/// Greatest node number plus one.
size_t node_count(const std::vector<Path>& paths);

/// Whether a place lies within `margin` pixels of the border.
bool at_border(const cv::Point2d& p, const cv::Size& size, double margin);

}  // namespace landfix::landmarks
