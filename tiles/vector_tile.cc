#include "tiles/vector_tile.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace landfix::tiles {
namespace {

// 2^(k / 12), correctly rounded: levels by even k, the borders between them by odd k. Written out, so that every
// machine rounds the same sizes to the same levels.
constexpr std::array<double, 12> kTwelfths = {1.0,
                                              1.0594630943592953,
                                              1.122462048309373,
                                              1.189207115002721,
                                              1.2599210498948732,
                                              1.3348398541700344,
                                              1.4142135623730951,
                                              1.4983070768766815,
                                              1.5874010519681994,
                                              1.681792830507429,
                                              1.7817974362806785,
                                              1.8877486253633868};

constexpr double kSmallestSize_m = 0.5;

double size_of_twelfths(uint32_t twelfths) {
  return std::ldexp(kSmallestSize_m * kTwelfths[twelfths % 12], int(twelfths / 12));
}

}  // namespace

std::optional<LatticePoint> lattice_point(double east_m, double north_m) {
  if (!(std::abs(east_m) < kDomainHalf - 1) || !(std::abs(north_m) < kDomainHalf - 1)) return std::nullopt;
  return LatticePoint{std::llround(east_m / kLatticeStep_m), std::llround(north_m / kLatticeStep_m)};
}

TileIndex vector_tile_of(const LatticePoint& p) {
  constexpr int kTileBits = 13;
  static_assert(int64_t(1) << kTileBits == kTileSteps);
  return {kVectorLevel, int32_t(p.east >> kTileBits), int32_t(p.north >> kTileBits)};
}

uint32_t morton_code(uint32_t x, uint32_t y) {
  uint32_t code = 0;
  for (int bit = 0; bit < 16; ++bit) code |= (x >> bit & 1) << (2 * bit) | (y >> bit & 1) << (2 * bit + 1);
  return code;
}

uint32_t morton_x(uint32_t code) {
  uint32_t x = 0;
  for (int bit = 0; bit < 16; ++bit) x |= (code >> (2 * bit) & 1) << bit;
  return x;
}

uint32_t size_level(double size_m) {
  if (!(size_m > 0)) return 0;
  uint32_t level = 0;
  while (level + 1 < kSizeLevels && size_m >= size_of_twelfths(2 * level + 1)) ++level;
  return level;
}

double size_of_level(uint32_t level) { return size_of_twelfths(2 * level); }

uint32_t share_level(double share) {
  if (!(share > 0)) return 0;
  return uint32_t(std::lround(15 * std::min(share, 1.0)));
}

}  // namespace landfix::tiles
