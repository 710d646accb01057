// Landmarks: what stands on the ground that a camera can recognise, and how a tile of them is coded.
// schemas/FORMAT.md section 3.6.1 is the specification.
#pragma once

#include <compare>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "tiles/vector_tile.h"

namespace landfix::tiles {

/// Values as in the file; readers skip landmarks of a greater class.
enum class LandmarkClass : uint8_t { kBuilding = 0, kField = 1, kTree = 2, kWater = 3, kPaved = 4 };
inline constexpr uint32_t kLandmarkClasses = 5;

struct Landmark {
  double east_m = 0, north_m = 0;  ///< its centre
  LandmarkClass cls = LandmarkClass::kBuilding;
  double length_m = 0, width_m = 0;  ///< of the rectangle that encloses it; length >= width
  /// Direction of the length, clockwise from grid north, in [0, pi); NaN where it has none.
  double orientation_rad = std::numeric_limits<double>::quiet_NaN();
  double confidence = 0;  ///< probability, 0 to 1, that it is there and of its class
  /// Metres to the nearest landmark that is_like() this one within the radius that the builder searched; that radius
  /// where there is none.
  double distinctiveness_m = 0;
  uint16_t epochs_seen = 1;  ///< how many capture dates show it
  uint16_t source = 0;       ///< 0: seen in the images; k: taken from the k-th source of role vector in the manifest
};

/// Radius within which landmarks are told apart: the greatest distance that a tile keeps.
inline constexpr double kDistinctRadius_m = 512;

/// Whether two landmarks could be taken for each other: the same class, length and width within a factor of 1.5.
bool is_like(const Landmark& a, const Landmark& b);

/// Fills in the distinctiveness of every landmark of a known class: its distance to the nearest that is_like() it, at
/// most `radius_m`. Of landmarks off the grid it stays.
void measure_distinctiveness(std::span<Landmark> landmarks, double radius_m);

/// The landmark as a tile keeps it: position to 0.25 m, sizes to 6 %, orientation to 2.8 degrees, confidence to 1/30,
/// distinctiveness rounded down to 8, 16, ... 512 m (0 below 8 m). Where the width is greater than the
/// length both are exchanged and the orientation is turned. nullopt where the position is not on the grid.
std::optional<Landmark> quantised(const Landmark& landmark);

/// The tile that a landmark belongs to; nullopt where the position is not on the grid.
std::optional<TileIndex> tile_of(const Landmark& landmark);

/// Codes landmarks that all belong to `tile`, in any order: the same bytes for the same set. Empty where there is none,
/// more than kMaxTileFeatures, or one that does not belong there.
std::vector<uint8_t> encode_landmarks(const TileIndex& tile, std::span<const Landmark> landmarks);

/// The inverse, in Morton order of the positions; classes may be unknown ones. Never reads outside of `data`, and
/// `landmarks` has at most kMaxTileFeatures; false where these are not the bytes that the landmarks are coded as, or
/// memory ran out.
bool decode_landmarks(const TileIndex& tile, std::span<const uint8_t> data, std::vector<Landmark>& landmarks) noexcept;

}  // namespace landfix::tiles
