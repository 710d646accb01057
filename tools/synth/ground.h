// Relief without its lakes, and the gentle bending of the plan.
//
// The plan of the world (roads, parcels) is drawn with straight lines on *plan coordinates*; the grid is bent against
// them by a few tens of metres, so that roads curve and fields have curved edges while every rule stays a rule about
// lines.
#pragma once

#include <span>

#include "tools/synth/noise.h"
#include "tools/synth/objects.h"

namespace landfix::synth {

class Ground {
 public:
  Ground(uint64_t seed, double base_height_m, double relief_m);

  /// Ellipsoidal heights along a row, replacing what is in `height_m`.
  void relief(const SampleRow& row, std::span<float> height_m) const;
  double relief_at(Point grid) const;

  /// Plan coordinates minus grid coordinates along a row.
  void bend(const SampleRow& row, std::span<float> east_m, std::span<float> north_m) const;
  Point plan_from_grid(Point grid) const;
  Point grid_from_plan(Point plan) const;

 private:
  float base_height_m_;
  Noise relief_, bend_east_, bend_north_;
};

}  // namespace landfix::synth
