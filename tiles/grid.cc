#include "tiles/grid.h"

namespace landfix::tiles {
namespace {

// Number of bits of a tile coordinate: the domain's side in tiles is 2^order.
int order_of(int level) { return kDomainLog2 - 8 - level; }

// Turns a quadrant so that the curve inside it joins its neighbours.
void rotate(uint32_t side, uint32_t& x, uint32_t& y, uint32_t rx, uint32_t ry) {
  if (ry != 0) return;
  if (rx == 1) {
    x = side - 1 - x;
    y = side - 1 - y;
  }
  const uint32_t t = x;
  x = y;
  y = t;
}

}  // namespace

std::optional<int> nearest_level(double gsd_m) {
  if (!(gsd_m > 0) || !std::isfinite(gsd_m)) return std::nullopt;
  const double level = std::round(std::log2(gsd_m));
  if (level < kMinLevel || level > kMaxLevel) return std::nullopt;
  return int(level);
}

std::optional<int> level_not_coarser(double gsd_m) {
  if (!(gsd_m > 0) || !std::isfinite(gsd_m)) return std::nullopt;
  const int level = std::ilogb(gsd_m);
  if (level < kMinLevel) return std::nullopt;
  return level > kMaxLevel ? kMaxLevel : level;
}

bool in_domain(const TileIndex& t) {
  if (t.level < kMinLevel || t.level > kMaxLevel) return false;
  const int64_t half = int64_t(1) << (order_of(t.level) - 1);
  return t.x >= -half && t.x < half && t.y >= -half && t.y < half;
}

uint64_t hilbert_key(const TileIndex& t) {
  // Built from the coarsest quadrant down, with the same first orientation at every level: so a parent's key is a
  // prefix.
  const int order = order_of(t.level);
  const uint32_t half = uint32_t(1) << (order - 1);
  uint32_t x = uint32_t(t.x) + half, y = uint32_t(t.y) + half;
  uint64_t key = 0;
  for (int bit = order - 1; bit >= 0; --bit) {
    const uint32_t side = uint32_t(1) << bit;
    const uint32_t rx = (x >> bit) & 1, ry = (y >> bit) & 1;
    key = key << 2 | ((3 * rx) ^ ry);
    x &= side - 1;
    y &= side - 1;
    rotate(side, x, y, rx, ry);
  }
  return key;
}

TileIndex tile_of_key(int level, uint64_t key) {
  const int order = order_of(level);
  uint32_t x = 0, y = 0;
  for (int bit = 0; bit < order; ++bit) {
    const uint32_t side = uint32_t(1) << bit;
    const uint32_t digit = uint32_t(key >> (2 * bit)) & 3;
    const uint32_t rx = digit >> 1, ry = (digit ^ rx) & 1;
    rotate(side, x, y, rx, ry);
    x += side * rx;
    y += side * ry;
  }
  const uint32_t half = uint32_t(1) << (order - 1);
  return {level, int32_t(x - half), int32_t(y - half)};
}

TileRange tiles_of(const PixelRect& r) {
  if (r.width <= 0 || r.height <= 0) return {r.level, 0, -1, 0, -1};
  const TileIndex nw = tile_of_pixel(r.level, r.column, r.row);
  const TileIndex se = tile_of_pixel(r.level, r.column + r.width - 1, r.row + r.height - 1);
  return {r.level, nw.x, se.x, se.y, nw.y};
}

}  // namespace landfix::tiles
