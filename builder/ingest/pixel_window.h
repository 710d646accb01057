// A window of pixels of any GSD: what tiles::PixelRect is for the levels of a pack.
#pragma once

#include <cstdint>

#include "builder/ingest/bounds.h"

namespace landfix::ingest {

/// Pixel (column, row) covers easting [column, column + 1) * gsd_m and northing (-(row + 1), -row] * gsd_m.
struct PixelWindow {
  double gsd_m = 1;
  int64_t column = 0, row = 0;    ///< north-western pixel
  int64_t width = 0, height = 0;  ///< pixels

  GridBounds bounds() const {
    return {double(column) * gsd_m, -double(row + height) * gsd_m, double(column + width) * gsd_m,
            -double(row) * gsd_m};
  }
};

/// The smallest window of whole pixels that covers `b`. Throws Error (kBadInput) for empty or absurd bounds: more than
/// 2^31 pixels a side.
PixelWindow window_covering(const GridBounds& b, double gsd_m);

/// Throws Error (kInternal) unless the window has between 1 and 2^26 pixels: what is read at once.
void require_readable(const PixelWindow& window);

inline PixelWindow window_of(const tiles::PixelRect& r) {
  return {tiles::gsd_of(r.level), r.column, r.row, r.width, r.height};
}

}  // namespace landfix::ingest
