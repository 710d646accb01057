// The grid of a pack: levels, tiles and their order. Metres and integers only; degrees live in tiles/geodesy.
//
// A level is a ground sample distance of 2^level metres. Global pixel (column, row) of a level covers easting
// [column, column + 1) * gsd and northing (-(row + 1), -row] * gsd: rows run from north to south, as in an image.
// A tile is 256x256 pixels; tile (x, y) covers easting [x, x + 1) * side and northing [y, y + 1) * side, side = 256 *
// gsd: tile indices run east and north, as the grid does.
#pragma once

#include <cmath>
#include <compare>
#include <cstdint>
#include <optional>

namespace landfix::tiles {

inline constexpr int kTilePixels = 256;
inline constexpr int kMinLevel = -10;   ///< 2^-10 m: about 1 mm
inline constexpr int kMaxLevel = 13;    ///< 2^13 m
inline constexpr int kDomainLog2 = 26;  ///< the grid spans 2^26 m, centred on the zone's origin
inline constexpr double kDomainHalf = 1 << (kDomainLog2 - 1);

/// Metres per pixel of a level; `level` within [kMinLevel, kMaxLevel].
inline double gsd_of(int level) { return std::ldexp(1.0, level); }

/// Side of a tile in metres.
inline double tile_side(int level) { return gsd_of(level) * kTilePixels; }

/// The level whose GSD is nearest to `gsd_m` on a logarithmic scale; nullopt where that is no level of the grid.
std::optional<int> nearest_level(double gsd_m);

/// The coarsest level whose GSD does not exceed `gsd_m`; nullopt where there is none.
std::optional<int> level_not_coarser(double gsd_m);

struct TileIndex {
  int level = 0;
  int32_t x = 0, y = 0;
  friend bool operator==(const TileIndex&, const TileIndex&) = default;
};

/// Column and row of the north-western pixel of a tile, in global pixels of its level.
inline int64_t first_column(const TileIndex& t) { return int64_t(t.x) * kTilePixels; }
inline int64_t first_row(const TileIndex& t) { return -(int64_t(t.y) + 1) * kTilePixels; }

/// The tile of a global pixel.
inline TileIndex tile_of_pixel(int level, int64_t column, int64_t row) {
  return {level, int32_t(column >> 8), int32_t(~(row >> 8))};
}

/// The tile at the next coarser level that contains `t`.
inline TileIndex parent(const TileIndex& t) { return {t.level + 1, t.x >> 1, t.y >> 1}; }

/// The four tiles of the next finer level inside `t`: `quadrant` 0 north-west, 1 north-east, 2 south-west, 3
/// south-east.
inline TileIndex child(const TileIndex& t, int quadrant) {
  return {t.level - 1, t.x * 2 + (quadrant & 1), t.y * 2 + (quadrant < 2 ? 1 : 0)};
}

/// Whether a tile lies inside the grid's domain (and its level exists).
bool in_domain(const TileIndex& t);

/// Position of a tile on the Hilbert curve of its level. The curve covers the domain with 2^(18 - level) tiles a side
/// and starts in the south-west; key(parent) == key(child) >> 2 at every level. `t` must be in the domain.
uint64_t hilbert_key(const TileIndex& t);

/// Inverse of hilbert_key.
TileIndex tile_of_key(int level, uint64_t key);

/// Half-open rectangle of global pixels of one level.
struct PixelRect {
  int level = 0;
  int64_t column = 0, row = 0;    ///< north-western pixel
  int64_t width = 0, height = 0;  ///< pixels
  double west_m() const { return double(column) * gsd_of(level); }
  double north_m() const { return -double(row) * gsd_of(level); }
  friend bool operator==(const PixelRect&, const PixelRect&) = default;
};

/// Range of tiles, both ends included; rows of tiles from `y_min` (south) to `y_max` (north).
struct TileRange {
  int level = 0;
  int32_t x_min = 0, x_max = -1, y_min = 0, y_max = -1;
};

/// The tiles that a pixel rectangle touches; empty for an empty rectangle.
TileRange tiles_of(const PixelRect& rect);

}  // namespace landfix::tiles
