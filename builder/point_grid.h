// Points in the plane, found again by place.
#pragma once

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <unordered_map>
#include <vector>

namespace landfix::landmarks {

/// Visits points in an order that depends on nothing but how they were added.
class PointGrid {
  struct Entry {
    cv::Point2d at;
    int id;
  };

 public:
  explicit PointGrid(double cell) : cell_(cell) {}

  void add(const cv::Point2d& p, int id) { cells_[key(cell_of(p.x), cell_of(p.y))].push_back({p, id}); }

  /// Calls visit(point, id) for every point within `radius` of `p`.
  template <typename Visit>
  void within(const cv::Point2d& p, double radius, Visit visit) const {
    for (int y = cell_of(p.y - radius); y <= cell_of(p.y + radius); ++y) {
      for (int x = cell_of(p.x - radius); x <= cell_of(p.x + radius); ++x) {
        const auto found = cells_.find(key(x, y));
        if (found == cells_.end()) continue;
        for (const Entry& e : found->second)
          if (std::hypot(e.at.x - p.x, e.at.y - p.y) <= radius) visit(e.at, e.id);
      }
    }
  }

  /// Calls visit(point, id) for every point, in the order of ids.
  template <typename Visit>
  void for_each(Visit visit) const {
    std::vector<Entry> all;
    for (const auto& [key, entries] : cells_) all.insert(all.end(), entries.begin(), entries.end());
    std::sort(all.begin(), all.end(), [](const Entry& a, const Entry& b) { return a.id < b.id; });
    for (const Entry& e : all) visit(e.at, e.id);
  }

  /// The id of the nearest within `radius`, the first that was found of equals; -1: none.
  int nearest(const cv::Point2d& p, double radius) const {
    int best = -1;
    double least = radius;
    within(p, radius, [&](const cv::Point2d& at, int id) {
      const double d = std::hypot(at.x - p.x, at.y - p.y);
      if (d < least || (best < 0 && d <= least)) {
        least = d;
        best = id;
      }
    });
    return best;
  }

 private:
  int cell_of(double v) const { return int(std::floor(v / cell_)); }
  static uint64_t key(int x, int y) { return uint64_t(uint32_t(x)) << 32 | uint32_t(y); }

  double cell_;
  std::unordered_map<uint64_t, std::vector<Entry>> cells_;
};

}  // namespace landfix::landmarks
