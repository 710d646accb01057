// A rectangle on a zone's grid, in metres.
#pragma once

#include <algorithm>
#include <limits>

#include "tiles/grid.h"

namespace landfix::ingest {

/// Axis-aligned rectangle, metres of easting and northing. A default one is empty; `extend` makes it grow.
struct GridBounds {
  double west_m = std::numeric_limits<double>::infinity();
  double south_m = std::numeric_limits<double>::infinity();
  double east_m = -std::numeric_limits<double>::infinity();
  double north_m = -std::numeric_limits<double>::infinity();

  bool empty() const { return !(west_m < east_m && south_m < north_m); }
  /// South and west edges belong to it.
  bool contains(double east, double north) const {
    return east >= west_m && east < east_m && north >= south_m && north < north_m;
  }
  bool intersects(const GridBounds& b) const {
    return west_m < b.east_m && b.west_m < east_m && south_m < b.north_m && b.south_m < north_m;
  }
  void extend(const GridBounds& b) {
    west_m = std::min(west_m, b.west_m);
    south_m = std::min(south_m, b.south_m);
    east_m = std::max(east_m, b.east_m);
    north_m = std::max(north_m, b.north_m);
  }
  friend bool operator==(const GridBounds&, const GridBounds&) = default;
};

/// What a rectangle of pixels covers.
inline GridBounds bounds_of(const tiles::PixelRect& r) {
  const double gsd = tiles::gsd_of(r.level);
  return {r.west_m(), r.north_m() - double(r.height) * gsd, r.west_m() + double(r.width) * gsd, r.north_m()};
}

/// What a tile covers.
inline GridBounds bounds_of(const tiles::TileIndex& t) {
  const double side = tiles::tile_side(t.level);
  return {t.x * side, t.y * side, (t.x + 1.0) * side, (t.y + 1.0) * side};
}

/// The smallest rectangle of whole pixels of a level that covers `b`. Throws Error (kBadInput) for empty or absurd
/// bounds: more than 2^31 pixels a side.
tiles::PixelRect pixels_covering(const GridBounds& b, int level);

}  // namespace landfix::ingest
