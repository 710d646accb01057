// What the tiles of vector layers share: the level they lie at, the lattice of their positions, and how sizes and
// shares are rounded. schemas/FORMAT.md section 3.6 is the specification.
#pragma once

#include <cstdint>
#include <optional>

#include "tiles/grid.h"

namespace landfix::tiles {

inline constexpr int kVectorLevel = 3;               ///< tiles of 2048 m
inline constexpr double kLatticeStep_m = 0.25;       ///< positions are whole multiples of it
inline constexpr int64_t kTileSteps = 8192;          ///< side of a tile in steps
inline constexpr uint32_t kMaxTileFeatures = 65536;  ///< landmarks, nodes or edges of one tile

/// A position on the lattice of the whole grid, in steps from the zone's origin.
struct LatticePoint {
  int64_t east = 0, north = 0;
  double east_m() const { return double(east) * kLatticeStep_m; }
  double north_m() const { return double(north) * kLatticeStep_m; }
  friend bool operator==(const LatticePoint&, const LatticePoint&) = default;
};

/// The nearest point of the lattice; nullopt where the position is not finite or outside the grid's domain.
std::optional<LatticePoint> lattice_point(double east_m, double north_m);

/// The tile that a point lies in, its western and southern edge included.
TileIndex vector_tile_of(const LatticePoint& point);

/// South-western corner of a tile of kVectorLevel.
inline LatticePoint corner_of(const TileIndex& tile) { return {tile.x * kTileSteps, tile.y * kTileSteps}; }

/// Interleaves the lowest 16 bits of both: bit i of x becomes bit 2i, bit i of y bit 2i + 1.
uint32_t morton_code(uint32_t x, uint32_t y);
/// The x of a Morton code; its y is that of `code >> 1`.
uint32_t morton_x(uint32_t code);

/// Sizes are 0.5 m * 2^(q / 6), q from 0 to 63: 0.5 to 724 m in steps of 12 %.
inline constexpr uint32_t kSizeLevels = 64;
uint32_t size_level(double size_m);  ///< the nearest; 0 for what is not greater than 0 or not a number
double size_of_level(uint32_t level);

/// Shares from 0 to 1 are q / 15.
uint32_t share_level(double share);
inline double share_of_level(uint32_t level) { return level / 15.0; }

}  // namespace landfix::tiles
