// How far every landmark is from the nearest that could be taken for it.
#include <algorithm>
#include <cmath>
#include <compare>
#include <utility>

#include "tiles/landmark.h"

namespace landfix::tiles {
namespace {

constexpr double kCell_m = 32;

struct Cell {
  int64_t x = 0, y = 0;
  auto operator<=>(const Cell&) const = default;
};

Cell cell_of(const Landmark& m) {
  return {int64_t(std::floor(m.east_m / kCell_m)), int64_t(std::floor(m.north_m / kCell_m))};
}

// Landmarks of one class, sorted by cell.
class Cells {
 public:
  Cells(std::span<const Landmark> landmarks, LandmarkClass cls) : landmarks_(landmarks) {
    for (uint32_t i = 0; i < landmarks.size(); ++i)
      if (landmarks[i].cls == cls && tile_of(landmarks[i])) sorted_.push_back({cell_of(landmarks[i]), i});
    std::sort(sorted_.begin(), sorted_.end());
  }

  using Entry = std::pair<Cell, uint32_t>;
  const std::vector<Entry>& sorted() const { return sorted_; }

  // Looks into rings of cells around a landmark until no farther ring can hold a nearer one.
  double nearest_like(uint32_t index, double radius_m) const {
    const Cell middle = cell_of(landmarks_[index]);
    double nearest = radius_m;
    for (int64_t ring = 0; double(ring - 1) * kCell_m < nearest; ++ring)
      for (int64_t dx = -ring; dx <= ring; ++dx) {
        const int64_t step = std::abs(dx) == ring || ring == 0 ? 1 : 2 * ring;
        for (int64_t dy = -ring; dy <= ring; dy += step) look_into({middle.x + dx, middle.y + dy}, index, nearest);
      }
    return nearest;
  }

 private:
  void look_into(const Cell& cell, uint32_t index, double& nearest) const {
    const Landmark& a = landmarks_[index];
    for (auto at = std::lower_bound(sorted_.begin(), sorted_.end(), Entry{cell, 0});
         at != sorted_.end() && at->first == cell; ++at) {
      const Landmark& b = landmarks_[at->second];
      if (at->second != index && is_like(a, b))
        nearest = std::min(nearest, std::hypot(a.east_m - b.east_m, a.north_m - b.north_m));
    }
  }

  std::span<const Landmark> landmarks_;
  std::vector<Entry> sorted_;
};

}  // namespace

void measure_distinctiveness(std::span<Landmark> landmarks, double radius_m) {
  for (uint32_t cls = 0; cls < kLandmarkClasses; ++cls) {
    const Cells cells(landmarks, LandmarkClass(cls));
    for (const auto& [cell, index] : cells.sorted())
      landmarks[index].distinctiveness_m = cells.nearest_like(index, radius_m);
  }
}

}  // namespace landfix::tiles
