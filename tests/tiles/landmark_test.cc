// Landmarks as a tile keeps them: rounding, the bytes per landmark, order, and hostile bytes.
#include "tiles/landmark.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/tiles/random.h"

namespace landfix::tiles {
namespace {

using std::numbers::pi;
using tests::Random;

constexpr TileIndex kTile{kVectorLevel, 244, -3};
constexpr double kWest = 244 * 2048.0, kSouth = -3 * 2048.0;

double bell(Random& random) {
  double sum = -6;
  for (int i = 0; i < 12; ++i) sum += random.uniform();
  return sum;
}

// Half trees, a third buildings along a street, and the rest fields, water and paved ground; a tenth known from a
// source.
Landmark drawn(Random& random, double street_rad) {
  Landmark m;
  const double draw = random.uniform();
  if (draw < 0.5) {
    m.cls = LandmarkClass::kTree;
    m.width_m = 6 * std::exp(0.4 * bell(random)), m.length_m = m.width_m * (1 + 0.1 * std::abs(bell(random)));
    m.confidence = 0.9 - 0.15 * std::abs(bell(random));
  } else if (draw < 0.85) {
    m.width_m = 9 * std::exp(0.3 * bell(random)), m.length_m = m.width_m * (1 + 0.4 * std::abs(bell(random)));
    m.orientation_rad = street_rad + (random.uniform() < 0.5 ? pi / 2 : 0) + 0.03 * bell(random);
    m.confidence = 1 - 0.15 * std::abs(bell(random));
  } else {
    m.cls = draw < 0.95 ? LandmarkClass::kField : draw < 0.97 ? LandmarkClass::kWater : LandmarkClass::kPaved;
    m.width_m = 60 * std::exp(0.5 * bell(random)), m.length_m = m.width_m * (1 + 0.8 * std::abs(bell(random)));
    m.orientation_rad = pi * random.uniform();
    m.confidence = 0.9 - 0.15 * std::abs(bell(random));
  }
  m.epochs_seen = uint16_t(random.integer(1, 3));
  m.source = random.uniform() < 0.1;
  return m;
}

enum class Places { kEven, kClustered };

// Clusters are hamlets of forty landmarks around a street, 80 m in sigma.
std::vector<Landmark> landmarks(int count, Places places, uint64_t seed = 1) {
  Random random(seed);
  std::vector<Landmark> out;
  double east = 0, north = 0, street = 0;
  while (int(out.size()) < count) {
    if (places == Places::kEven || out.size() % 40 == 0)
      east = random.uniform(1, 2047), north = random.uniform(1, 2047), street = pi * random.uniform();
    Landmark m = drawn(random, street);
    const double spread = places == Places::kEven ? 0 : 80;
    const double x = east + spread * bell(random), y = north + spread * bell(random);
    if (std::min(x, y) < 0 || std::max(x, y) > 2047) continue;
    m.east_m = kWest + x, m.north_m = kSouth + y;
    out.push_back(m);
  }
  for (Landmark& m : out) {
    m.distinctiveness_m = 512;
    for (const Landmark& other : out)
      if (&other != &m && is_like(m, other))
        m.distinctiveness_m =
            std::min(m.distinctiveness_m, std::hypot(m.east_m - other.east_m, m.north_m - other.north_m));
  }
  return out;
}

void expect_same(const Landmark& a, const Landmark& b) {
  EXPECT_EQ(a.east_m, b.east_m);
  EXPECT_EQ(a.north_m, b.north_m);
  EXPECT_EQ(a.cls, b.cls);
  EXPECT_EQ(a.length_m, b.length_m);
  EXPECT_EQ(a.width_m, b.width_m);
  EXPECT_TRUE(a.orientation_rad == b.orientation_rad ||
              (std::isnan(a.orientation_rad) && std::isnan(b.orientation_rad)));
  EXPECT_EQ(a.confidence, b.confidence);
  EXPECT_EQ(a.distinctiveness_m, b.distinctiveness_m);
  EXPECT_EQ(a.epochs_seen, b.epochs_seen);
  EXPECT_EQ(a.source, b.source);
}

TEST(Landmark, RoundsAsTheFormatSays) {
  Landmark m;
  m.east_m = kWest + 100.13, m.north_m = kSouth + 7.9;
  m.length_m = 20, m.width_m = 10;
  m.orientation_rad = 1;
  m.confidence = 0.72, m.distinctiveness_m = 255.9;
  const Landmark q = *quantised(m);
  EXPECT_EQ(q.east_m, kWest + 100.25);
  EXPECT_EQ(q.north_m, kSouth + 8);
  EXPECT_NEAR(q.length_m, 20.159, 0.001) << "0.5 * 2^(32/6); its neighbours are 18.0 and 22.6";
  EXPECT_NEAR(q.width_m, 10.079, 0.001);
  EXPECT_NEAR(q.orientation_rad, 10 * pi / 32, 1e-12);
  EXPECT_NEAR(q.confidence, 11 / 15.0, 1e-12);
  EXPECT_EQ(q.distinctiveness_m, 128) << "rounded down, so that nothing alike is nearer";
}

TEST(Landmark, EverySizeIsRoundedByLessThanSixPercent) {
  for (double size = 0.5; size < 720; size *= 1.013) {
    const double kept = size_of_level(size_level(size));
    EXPECT_LT(std::max(kept / size, size / kept), 1.0595) << size;
  }
  EXPECT_EQ(size_level(0.01), 0u);
  EXPECT_EQ(size_level(1e9), 63u);
  EXPECT_EQ(size_level(std::nan("")), 0u);
}

TEST(Landmark, WhoseWidthIsGreaterIsTurned) {
  Landmark m;
  m.length_m = 10, m.width_m = 20, m.orientation_rad = 0.25 * pi;
  const Landmark q = *quantised(m);
  EXPECT_GT(q.length_m, 20);
  EXPECT_LT(q.width_m, 10.1);
  EXPECT_NEAR(q.orientation_rad, 0.75 * pi, 1e-12);
}

TEST(Landmark, BelongsToTheTileOfItsRoundedPlace) {
  Landmark m;
  m.east_m = kWest + 2047.88, m.north_m = kSouth;  // rounds to the next tile's edge
  EXPECT_EQ(*tile_of(m), (TileIndex{kVectorLevel, 245, -3}));
  m.east_m = kWest + 2047.87;
  EXPECT_EQ(*tile_of(m), kTile);
  m.east_m = std::nan("");
  EXPECT_FALSE(tile_of(m));
  m.east_m = 1e9;
  EXPECT_FALSE(tile_of(m));
}

TEST(LandmarkTile, GivesBackWhatQuantisedSays) {
  std::vector<Landmark> in = landmarks(500, Places::kClustered);
  in.push_back(in[7]);  // twice the same
  std::vector<Landmark> out;
  ASSERT_TRUE(decode_landmarks(kTile, encode_landmarks(kTile, in), out));
  ASSERT_EQ(out.size(), in.size());
  const auto by_place = [](const Landmark& a, const Landmark& b) {
    return std::tuple(a.east_m, a.north_m, a.cls, a.length_m, a.width_m) <
           std::tuple(b.east_m, b.north_m, b.cls, b.length_m, b.width_m);
  };
  for (Landmark& m : in) m = *quantised(m);
  std::sort(in.begin(), in.end(), by_place);
  std::sort(out.begin(), out.end(), by_place);
  for (size_t i = 0; i < in.size(); ++i) expect_same(in[i], out[i]);
}

TEST(LandmarkTile, HasTheSameBytesInAnyOrder) {
  std::vector<Landmark> in = landmarks(300, Places::kEven);
  const auto bytes = encode_landmarks(kTile, in);
  std::reverse(in.begin(), in.end());
  EXPECT_EQ(encode_landmarks(kTile, in), bytes);
}

TEST(LandmarkTile, TakesAtMostFiveBytesForEachWithItsRecord) {
  // 64 bytes of tile record, a 256th of a block record, and padding to 8 bytes; from 72 landmarks per km2 to 715.
  for (const Places places : {Places::kEven, Places::kClustered})
    for (const int count : {300, 1000, 3000}) {
      const size_t bytes = encode_landmarks(kTile, landmarks(count, places)).size();
      const double all = double((bytes + 7) / 8 * 8) + 64 + 64.0 / 256;
      EXPECT_LE(all / count, 5) << count;
      EXPECT_GE(all / count, 3) << "less than the positions alone need";
      RecordProperty("bytes_for_" + std::to_string(count) + (places == Places::kEven ? "_even" : "_clustered"),
                     std::to_string(all / count));
    }
}

TEST(LandmarkTile, RefusesWhatDoesNotBelongThere) {
  std::vector<Landmark> in = landmarks(3, Places::kEven);
  EXPECT_TRUE(encode_landmarks({kVectorLevel, 245, -3}, in).empty());
  EXPECT_TRUE(encode_landmarks(kTile, {}).empty());
  in[1].cls = LandmarkClass(16);
  EXPECT_TRUE(encode_landmarks(kTile, in).empty()) << "four bits hold classes up to 15";
  in[1].cls = LandmarkClass(15);
  EXPECT_FALSE(encode_landmarks(kTile, in).empty());
  EXPECT_TRUE(encode_landmarks(kTile, std::vector<Landmark>(kMaxTileFeatures + 1, in[0])).empty());
}

TEST(LandmarkTile, DamagedBytesAreRefusedOrAreAnotherTile) {
  const auto good = encode_landmarks(kTile, landmarks(200, Places::kEven));
  std::vector<Landmark> out;
  for (size_t length = 0; length < good.size(); ++length)
    EXPECT_FALSE(decode_landmarks(kTile, std::span(good).first(length), out)) << length;
  auto longer = good;
  longer.push_back(0);
  EXPECT_FALSE(decode_landmarks(kTile, longer, out));
  size_t taken = 0;
  for (size_t i = 0; i < good.size(); ++i)
    for (int bit = 0; bit < 8; ++bit) {
      auto bytes = good;
      bytes[i] ^= uint8_t(1 << bit);
      if (!decode_landmarks(kTile, bytes, out)) continue;
      ++taken;
      for (const Landmark& m : out) ASSERT_EQ(*tile_of(m), kTile);
    }
  EXPECT_LT(taken, good.size() / 10) << "the end hardly ever fits by chance";
}

TEST(LandmarkTile, NoiseIsAnsweredWithinTheBounds) {
  Random random(3);
  std::vector<Landmark> out;
  for (int round = 0; round < 300; ++round) {
    std::vector<uint8_t> bytes(size_t(random.integer(0, 400)));
    for (uint8_t& b : bytes) b = random.byte();
    if (!decode_landmarks(kTile, bytes, out)) continue;
    EXPECT_LE(out.size(), kMaxTileFeatures);
  }
  EXPECT_FALSE(decode_landmarks(kTile, std::vector<uint8_t>(1 << 20, 0xFF), out));
  EXPECT_FALSE(decode_landmarks(kTile, std::vector<uint8_t>(1 << 20, 0), out));
}

TEST(Landmark, DistinctivenessIsTheDistanceToTheNearestAlike) {
  std::vector<Landmark> measured = landmarks(1000, Places::kClustered, 9);  // by comparing each with each, up to 512 m
  const std::vector<Landmark> expected = measured;
  for (Landmark& m : measured) m.distinctiveness_m = -1;
  measure_distinctiveness(measured, 512);
  double sum = 0;
  for (size_t i = 0; i < measured.size(); ++i) {
    ASSERT_EQ(measured[i].distinctiveness_m, expected[i].distinctiveness_m) << i;
    sum += measured[i].distinctiveness_m;
  }
  EXPECT_GT(sum / 1000, 10) << "not all the same place";
  std::vector<Landmark> alone(1);
  measure_distinctiveness(alone, 300);
  EXPECT_EQ(alone[0].distinctiveness_m, 300);
  alone[0].east_m = std::nan("");
  alone[0].distinctiveness_m = 7;
  measure_distinctiveness(alone, 300);
  EXPECT_EQ(alone[0].distinctiveness_m, 7);
}

TEST(Landmark, IsLikeOneOfItsClassAndSize) {
  Landmark a;
  a.length_m = 12, a.width_m = 10;
  Landmark b = a;
  b.length_m = 17.9;
  EXPECT_TRUE(is_like(a, b));
  b.length_m = 18.1;
  EXPECT_FALSE(is_like(a, b));
  b = a, b.cls = LandmarkClass::kTree;
  EXPECT_FALSE(is_like(a, b));
}

}  // namespace
}  // namespace landfix::tiles
