// What an uncertainty ellipse touches on the grid.
#pragma once

#include <optional>

#include "tiles/grid.h"

namespace landfix::tiles {

/// 2x2 covariance of a position on the grid, square metres.
struct Covariance {
  double ee = 0, en = 0, nn = 0;
};

/// The set of points x with (x - mean)' C^-1 (x - mean) <= k^2.
struct Ellipse {
  double east_m = 0, north_m = 0;
  Covariance covariance;
  double k = 1;
};

/// Whether every number is finite, the covariance positive semi-definite (to rounding), k >= 0, and the ellipse in the
/// grid's domain.
bool is_valid(const Ellipse& ellipse);

/// The pixels of `level` that the bounding box of the ellipse touches, at least one. nullopt where the ellipse is not
/// valid.
std::optional<PixelRect> bounding_pixels(const Ellipse& ellipse, int level);

/// Whether the ellipse and the (closed) tile have a point in common. `ellipse` must be valid.
bool touches(const Ellipse& ellipse, const TileIndex& tile);

/// Whether the ellipse, which must be valid, contains a point.
bool contains(const Ellipse& ellipse, double east_m, double north_m);

/// Whether the ellipse, which must be valid, and the straight line between two points have a point in common.
bool touches_line(const Ellipse& ellipse, double east0_m, double north0_m, double east1_m, double north1_m);

}  // namespace landfix::tiles
