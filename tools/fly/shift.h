// The constant shift between two sources of the same place, measured.
#pragma once

#include <Eigen/Core>

#include "builder/terrain/texture.h"
#include "runtime/nav/map_source.h"

namespace landfix::fly {

struct Shift {
  Eigen::Vector2d map_from_scene = Eigen::Vector2d::Zero();  ///< metres east and north to add to a scene position
  Eigen::Vector2d spread = Eigen::Vector2d::Zero();          ///< median absolute deviation over the places, metres
  int places = 0;                                            ///< that matched clearly
};

/// Correlates (NCC) squares of the scene with the map at places all over the scene, reaching `reach_m` to each side,
/// and takes the median of the clear, unambiguous peaks, refined to a fraction of a pixel. Throws Error (kNoData) where
/// fewer than five places match.
Shift measure_shift(const terrain::Texture& scene, const nav::MapSource& map, double reach_m = 8);

}  // namespace landfix::fly
