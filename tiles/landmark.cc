#include "tiles/landmark.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <numbers>

#include "tiles/symbol_models.h"

namespace landfix::tiles {
namespace {

constexpr uint32_t kOrientations = 32, kDistinctLevels = 8;
constexpr uint32_t kPositionEnd = uint32_t(kTileSteps * kTileSteps);  // of Morton codes

// A landmark in the integers that are coded. Ordered by position, so that a tile has one order.
struct Coded {
  uint32_t position = 0;  // Morton code of the steps from the tile's south-western corner
  uint32_t cls = 0, length = 0, narrower = 0, has_orientation = 0, orientation = 0, confidence = 0, distinct = 0,
           epochs_seen = 0, source = 0;
  auto operator<=>(const Coded&) const = default;
};

// 0 below 8 m, else 4 m * 2^q, rounded down: nothing like it is nearer than that.
double distinctiveness_of(uint32_t level) { return level == 0 ? 0 : std::ldexp(4, int(level)); }

uint32_t distinct_level(double distance_m) {
  uint32_t level = 0;
  while (level + 1 < kDistinctLevels && distance_m >= distinctiveness_of(level + 1)) ++level;
  return level;
}

Coded coded_of(const Landmark& landmark, const LatticePoint& at) {
  Coded c;
  c.position = morton_code(uint32_t(at.east & (kTileSteps - 1)), uint32_t(at.north & (kTileSteps - 1)));
  c.cls = uint8_t(landmark.cls);
  const uint32_t length = size_level(landmark.length_m), width = size_level(landmark.width_m);
  c.length = std::max(length, width);
  c.narrower = c.length - std::min(length, width);
  c.has_orientation = std::isfinite(landmark.orientation_rad);
  if (c.has_orientation) {
    const double turns = landmark.orientation_rad / std::numbers::pi;
    const auto level = uint32_t(std::lround((turns - std::floor(turns)) * kOrientations));
    c.orientation = (level + (width > length ? kOrientations / 2 : 0)) % kOrientations;
  }
  c.confidence = share_level(landmark.confidence);
  c.distinct = distinct_level(landmark.distinctiveness_m);
  c.epochs_seen = landmark.epochs_seen;
  c.source = landmark.source;
  return c;
}

Landmark landmark_of(const Coded& c, const LatticePoint& corner) {
  const LatticePoint at{corner.east + morton_x(c.position), corner.north + morton_x(c.position >> 1)};
  Landmark out;
  out.east_m = at.east_m(), out.north_m = at.north_m();
  out.cls = LandmarkClass(c.cls);
  out.length_m = size_of_level(c.length), out.width_m = size_of_level(c.length - c.narrower);
  if (c.has_orientation) out.orientation_rad = c.orientation * (std::numbers::pi / kOrientations);
  out.confidence = share_of_level(c.confidence);
  out.distinctiveness_m = distinctiveness_of(c.distinct);
  out.epochs_seen = uint16_t(c.epochs_seen), out.source = uint16_t(c.source);
  return out;
}

// What is learned of the landmarks of one class.
struct ClassModels {
  SymbolModel<6, 2> length;
  NumberModel narrower;
  BitModel has_orientation;
  SymbolModel<5, 1> turn;
  SymbolModel<4> confidence;
  SymbolModel<3> distinct;
  uint32_t last_orientation = 0;
};

constexpr int kClassBits = 4;

struct LandmarkModels {
  NumberModel count, gap, epochs_seen, source;
  SymbolModel<kClassBits> cls[1 << kClassBits];  // in the context of the landmark before
  ClassModels of_class[1 << kClassBits];
};

template <typename Coder>
void code_attributes(Coder& coder, LandmarkModels& all, Coded& c) {
  ClassModels& m = all.of_class[c.cls];
  c.length = m.length.code(coder, c.length);
  c.narrower = m.narrower.code(coder, c.narrower);
  c.has_orientation = coder.code(m.has_orientation, c.has_orientation != 0);
  if (c.has_orientation) {
    // Neighbours often stand along the same street.
    const uint32_t turn = m.turn.code(coder, (c.orientation - m.last_orientation) % kOrientations);
    c.orientation = m.last_orientation = (m.last_orientation + turn) % kOrientations;
  }
  c.confidence = m.confidence.code(coder, c.confidence);
  c.distinct = m.distinct.code(coder, c.distinct);
  c.epochs_seen = all.epochs_seen.code(coder, c.epochs_seen);
  c.source = all.source.code(coder, c.source);
}

bool is_sound(const Coded& c) {
  return c.narrower <= c.length && c.epochs_seen <= UINT16_MAX && c.source <= UINT16_MAX;
}

// Both ways; false where what was decoded is not what an encoder codes.
template <typename Coder>
bool code_tile(Coder& coder, std::vector<Coded>& landmarks) {
  LandmarkModels models;
  const uint32_t count = models.count.code(coder, uint32_t(landmarks.size()));
  if (count == 0 || count > kMaxTileFeatures) return false;
  landmarks.resize(count);
  Coded before;
  for (Coded& c : landmarks) {
    const uint32_t gap = models.gap.code(coder, c.position - before.position);
    if (gap >= kPositionEnd - before.position) return false;
    c.position = before.position + gap;
    c.cls = models.cls[before.cls].code(coder, c.cls);
    code_attributes(coder, models, c);
    if (!is_sound(c) || coder.failed() || c < before) return false;
    before = c;
  }
  return true;
}

}  // namespace

bool is_like(const Landmark& a, const Landmark& b) {
  constexpr double kMostRatio = 1.5;
  const auto alike = [](double p, double q) { return p <= kMostRatio * q && q <= kMostRatio * p; };
  return a.cls == b.cls && alike(a.length_m, b.length_m) && alike(a.width_m, b.width_m);
}

std::optional<TileIndex> tile_of(const Landmark& landmark) {
  const auto at = lattice_point(landmark.east_m, landmark.north_m);
  if (!at) return std::nullopt;
  return vector_tile_of(*at);
}

std::optional<Landmark> quantised(const Landmark& landmark) {
  const auto at = lattice_point(landmark.east_m, landmark.north_m);
  if (!at) return std::nullopt;
  return landmark_of(coded_of(landmark, *at), corner_of(vector_tile_of(*at)));
}

std::vector<uint8_t> encode_landmarks(const TileIndex& tile, std::span<const Landmark> landmarks) {
  std::vector<Coded> coded;
  for (const Landmark& landmark : landmarks) {
    const auto at = lattice_point(landmark.east_m, landmark.north_m);
    if (!at || vector_tile_of(*at) != tile || uint8_t(landmark.cls) >> kClassBits != 0) return {};
    coded.push_back(coded_of(landmark, *at));
  }
  std::sort(coded.begin(), coded.end());
  ArithmeticEncoder encoder;
  return code_tile(encoder, coded) ? encoder.finish() : std::vector<uint8_t>{};
}

bool decode_landmarks(const TileIndex& tile, std::span<const uint8_t> data, std::vector<Landmark>& landmarks) noexcept
    try {
  landmarks.clear();
  std::vector<Coded> coded;
  ArithmeticDecoder decoder(data);
  if (!code_tile(decoder, coded) || !decoder.at_end()) return false;
  landmarks.reserve(coded.size());
  for (const Coded& c : coded) landmarks.push_back(landmark_of(c, corner_of(tile)));
  return true;
} catch (const std::bad_alloc&) {
  return false;
}

}  // namespace landfix::tiles
