#include "tools/synth/ground.h"

#include <algorithm>

#include "tools/synth/random.h"

namespace landfix::synth {
namespace {

constexpr uint64_t kReliefSalt = 11, kBendEastSalt = 12, kBendNorthSalt = 13;
// The octaves halve, so their slopes are alike: hills kilometres apart, smooth over the length of a building.
constexpr double kLongestRelief_m = 2600, kShortestRelief_m = 160;
constexpr double kLongestBend_m = 1100, kShortestBend_m = 270;
constexpr float kBend_m = 48;
/// Five halving octaves of ±0.7 rarely line up; this makes `relief_m` about the height of hills above and below the
/// mean.
constexpr double kReliefScale = 1.3;

}  // namespace

Ground::Ground(uint64_t seed, double base_height_m, double relief_m)
    : base_height_m_(static_cast<float>(base_height_m)),
      relief_(key(seed, kReliefSalt), kLongestRelief_m, kShortestRelief_m, static_cast<float>(kReliefScale * relief_m),
              0.46f),
      bend_east_(key(seed, kBendEastSalt), kLongestBend_m, kShortestBend_m, kBend_m, 0.4f),
      bend_north_(key(seed, kBendNorthSalt), kLongestBend_m, kShortestBend_m, kBend_m, 0.4f) {}

void Ground::relief(const SampleRow& row, std::span<float> height_m) const {
  std::ranges::fill(height_m, base_height_m_);
  relief_.add_to(row, height_m);
}

double Ground::relief_at(Point grid) const {
  return static_cast<double>(base_height_m_) + static_cast<double>(relief_.at(grid.x, grid.y));
}

void Ground::bend(const SampleRow& row, std::span<float> east_m, std::span<float> north_m) const {
  std::ranges::fill(east_m, 0.0f);
  std::ranges::fill(north_m, 0.0f);
  bend_east_.add_to(row, east_m);
  bend_north_.add_to(row, north_m);
}

Point Ground::plan_from_grid(Point grid) const {
  return grid +
         Point(static_cast<double>(bend_east_.at(grid.x, grid.y)), static_cast<double>(bend_north_.at(grid.x, grid.y)));
}

Point Ground::grid_from_plan(Point plan) const {
  // The bend has slopes of at most 0.2 or so: each step of the fixed-point iteration gains a digit.
  Point grid = plan;
  for (int i = 0; i < 9; ++i) grid += plan - plan_from_grid(grid);
  return grid;
}

}  // namespace landfix::synth
