#include "builder/ingest/pixel_window.h"

#include <fmt/format.h>

#include <cmath>

#include "builder/error.h"

namespace landfix::ingest {
namespace {

constexpr double kMostPixelsPerSide = 2147483648.0;
constexpr int64_t kMostPixelsAtOnce = int64_t(1) << 26;

}  // namespace

PixelWindow window_covering(const GridBounds& b, double gsd_m) {
  if (b.empty() || !(gsd_m > 0)) throw Error(ExitCode::kBadInput, "the area is empty: nothing to read");
  const double west = std::floor(b.west_m / gsd_m), east = std::ceil(b.east_m / gsd_m);
  const double north = std::floor(-b.north_m / gsd_m), south = std::ceil(-b.south_m / gsd_m);
  if (!(east - west <= kMostPixelsPerSide && south - north <= kMostPixelsPerSide)) {
    throw Error(ExitCode::kBadInput, fmt::format("an area of {:.0f} x {:.0f} km at {} m per pixel is more than 2^31 "
                                                 "pixels a side: choose a coarser GSD or a "
                                                 "smaller area",
                                                 (b.east_m - b.west_m) / 1000, (b.north_m - b.south_m) / 1000, gsd_m));
  }
  return {gsd_m, int64_t(west), int64_t(north), int64_t(east - west), int64_t(south - north)};
}

void require_readable(const PixelWindow& w) {
  if (w.width >= 1 && w.height >= 1 && w.width <= kMostPixelsAtOnce && w.height <= kMostPixelsAtOnce / w.width) return;
  throw Error(ExitCode::kInternal,
              fmt::format("a window of {} x {} pixels cannot be read at once; expected 1 to {} pixels", w.width,
                          w.height, kMostPixelsAtOnce));
}

tiles::PixelRect pixels_covering(const GridBounds& b, int level) {
  const PixelWindow w = window_covering(b, tiles::gsd_of(level));
  return {level, w.column, w.row, w.width, w.height};
}

}  // namespace landfix::ingest
