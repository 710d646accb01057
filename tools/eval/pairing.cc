#include "tools/eval/pairing.h"

#include <algorithm>
#include <cmath>

#include "builder/point_grid.h"

namespace landfix::eval {

std::vector<Pair> nearest_pairs(std::span<const cv::Point2d> a, std::span<const cv::Point2d> b, double reach_m) {
  landmarks::PointGrid grid(std::max(reach_m, 1.0));
  for (size_t i = 0; i < b.size(); ++i) grid.add(b[i], int(i));
  std::vector<Pair> all, out;
  for (size_t i = 0; i < a.size(); ++i)
    grid.within(a[i], reach_m, [&](const cv::Point2d& at, int id) {
      all.push_back({std::hypot(at.x - a[i].x, at.y - a[i].y), i, size_t(id)});
    });
  std::stable_sort(all.begin(), all.end(), [](const Pair& p, const Pair& q) { return p.distance_m < q.distance_m; });
  std::vector<bool> a_used(a.size(), false), b_used(b.size(), false);
  for (const Pair& p : all) {
    if (a_used[p.a] || b_used[p.b]) continue;
    a_used[p.a] = b_used[p.b] = true;
    out.push_back(p);
  }
  return out;
}

}  // namespace landfix::eval
