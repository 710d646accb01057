// Levels, tiles, pixels and the Hilbert order, against the text of FORMAT.md section 2.
#include "tiles/grid.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>
#include <set>

#include "tests/tiles/random.h"

namespace landfix::tiles {
namespace {

using tests::Random;

int32_t half_of(int level) { return int32_t(1) << (17 - level); }

TileIndex random_tile(Random& random, int level) {
  const int32_t half = half_of(level);
  return {level, int32_t(random.integer(-half, half - 1)), int32_t(random.integer(-half, half - 1))};
}

// The pseudo-code of FORMAT.md section 2.1, in its own words.
uint64_t key_by_the_book(int level, int64_t x, int64_t y) {
  const int n = 18 - level;
  int64_t u = x + (int64_t(1) << (n - 1)), v = y + (int64_t(1) << (n - 1));
  uint64_t key = 0;
  for (int bit = n - 1; bit >= 0; --bit) {
    const int64_t side = int64_t(1) << bit;
    const int64_t rx = (u >> bit) & 1, ry = (v >> bit) & 1;
    key = 4 * key + uint64_t((3 * rx) ^ ry);
    u %= side;
    v %= side;
    if (ry == 0) {
      if (rx == 1) {
        u = side - 1 - u;
        v = side - 1 - v;
      }
      std::swap(u, v);
    }
  }
  return key;
}

TEST(Levels, GsdIsAPowerOfTwo) {
  EXPECT_EQ(gsd_of(0), 1.0);
  EXPECT_EQ(gsd_of(-1), 0.5);
  EXPECT_EQ(gsd_of(kMinLevel), 1.0 / 1024);
  EXPECT_EQ(gsd_of(kMaxLevel), 8192.0);
  EXPECT_EQ(tile_side(2), 1024.0);
}

TEST(Levels, NearestOnALogarithmicScale) {
  EXPECT_EQ(nearest_level(0.5), -1);
  EXPECT_EQ(nearest_level(0.70), -1);  // sqrt(1/2) = 0.7071 parts the two
  EXPECT_EQ(nearest_level(0.71), 0);
  EXPECT_EQ(nearest_level(1e-3), -10);
  EXPECT_EQ(nearest_level(8192), 13);
  EXPECT_EQ(nearest_level(20000), std::nullopt);
  EXPECT_EQ(nearest_level(1e-4), std::nullopt);
  for (const double bad : {0.0, -1.0, double(NAN), double(INFINITY)})
    EXPECT_EQ(nearest_level(bad), std::nullopt) << bad;
}

TEST(Levels, NotCoarserThanWanted) {
  EXPECT_EQ(level_not_coarser(1.0), 0);
  EXPECT_EQ(level_not_coarser(std::nextafter(1.0, 0.0)), -1);
  EXPECT_EQ(level_not_coarser(1.99), 0);
  EXPECT_EQ(level_not_coarser(1e9), kMaxLevel);
  EXPECT_EQ(level_not_coarser(0.5 / 1024), std::nullopt);
  for (const double bad : {0.0, -1.0, double(NAN), double(INFINITY)})
    EXPECT_EQ(level_not_coarser(bad), std::nullopt) << bad;
}

TEST(Tiles, PixelsLieInTheirTile) {
  // Tile (0, 0) of level 0 covers northing [0, 256): its rows are global rows -256 to -1.
  EXPECT_EQ(tile_of_pixel(0, 0, -256), (TileIndex{0, 0, 0}));
  EXPECT_EQ(tile_of_pixel(0, 255, -1), (TileIndex{0, 0, 0}));
  EXPECT_EQ(tile_of_pixel(0, -1, 0), (TileIndex{0, -1, -1}));
  EXPECT_EQ(tile_of_pixel(0, 256, -257), (TileIndex{0, 1, 1}));
  Random random(1);
  for (int i = 0; i < 20000; ++i) {
    const TileIndex t = random_tile(random, int(random.integer(kMinLevel, kMaxLevel)));
    const int64_t column = first_column(t) + random.integer(0, 255), row = first_row(t) + random.integer(0, 255);
    ASSERT_EQ(tile_of_pixel(t.level, column, row), t);
    // The pixel's centre lies in the metres that FORMAT.md gives the tile.
    const double side = tile_side(t.level), gsd = gsd_of(t.level);
    const double east = (double(column) + 0.5) * gsd, north = -(double(row) + 0.5) * gsd;
    ASSERT_TRUE(east > t.x * side && east < (t.x + 1) * side && north > t.y * side && north < (t.y + 1) * side);
  }
}

TEST(Tiles, ChildrenFillTheirParent) {
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const TileIndex t = random_tile(random, int(random.integer(kMinLevel + 1, kMaxLevel)));
    const double side = tile_side(t.level);
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      const TileIndex c = child(t, quadrant);
      ASSERT_EQ(parent(c), t);
      ASSERT_TRUE(in_domain(c));
      ASSERT_EQ(c.x * tile_side(c.level), t.x * side + (quadrant % 2 ? side / 2 : 0));
      ASSERT_EQ(c.y * tile_side(c.level), t.y * side + (quadrant < 2 ? side / 2 : 0));
    }
  }
}

TEST(Tiles, DomainEndsAtItsHalf) {
  for (int level = kMinLevel; level <= kMaxLevel; ++level) {
    const int32_t half = half_of(level);
    EXPECT_EQ(half * tile_side(level), kDomainHalf);
    EXPECT_TRUE(in_domain({level, -half, half - 1}));
    EXPECT_FALSE(in_domain({level, half, 0}));
    EXPECT_FALSE(in_domain({level, 0, -half - 1}));
  }
  EXPECT_FALSE(in_domain({kMinLevel - 1, 0, 0}));
  EXPECT_FALSE(in_domain({kMaxLevel + 1, 0, 0}));
}

TEST(Tiles, RangeOfAPixelRectangle) {
  const TileRange r = tiles_of({0, -1, -257, 258, 2});  // columns -1 to 256, rows -257 and -256
  EXPECT_EQ(r.x_min, -1);
  EXPECT_EQ(r.x_max, 1);
  EXPECT_EQ(r.y_min, 0);
  EXPECT_EQ(r.y_max, 1);
  const TileRange none = tiles_of({0, 5, 5, 0, 10});
  EXPECT_LT(none.x_max, none.x_min);
}

TEST(Hilbert, WorkedExampleOfTheFormat) {
  EXPECT_EQ(hilbert_key({0, 0, 0}), 34359738368u);
  EXPECT_EQ(hilbert_key({0, -1, -1}), 11453246122u);
  for (int level = kMinLevel; level <= kMaxLevel; ++level)
    EXPECT_EQ(hilbert_key({level, -half_of(level), -half_of(level)}), 0u);
}

TEST(Hilbert, IsThePseudoCodeOfTheFormat) {
  Random random(3);
  for (int i = 0; i < 100000; ++i) {
    const TileIndex t = random_tile(random, int(random.integer(kMinLevel, kMaxLevel)));
    ASSERT_EQ(hilbert_key(t), key_by_the_book(t.level, t.x, t.y)) << t.level << " " << t.x << " " << t.y;
  }
}

TEST(Hilbert, ParentsKeyIsAPrefixAtEveryLevel) {
  Random random(4);
  for (int level = kMinLevel; level < kMaxLevel; ++level)
    for (int i = 0; i < 2000; ++i) {
      const TileIndex t = random_tile(random, level);
      ASSERT_EQ(hilbert_key(parent(t)), hilbert_key(t) >> 2) << level << " " << t.x << " " << t.y;
    }
}

TEST(Hilbert, KeyAndTileAreInverse) {
  Random random(5);
  for (int level = kMinLevel; level <= kMaxLevel; ++level)
    for (int i = 0; i < 2000; ++i) {
      const TileIndex t = random_tile(random, level);
      const uint64_t key = hilbert_key(t);
      ASSERT_LT(key, uint64_t(1) << (2 * (18 - level)));
      ASSERT_EQ(tile_of_key(level, key), t);
    }
  std::set<uint64_t> keys;  // level 13 has 32 x 32 tiles: each key once
  for (int32_t y = -16; y < 16; ++y)
    for (int32_t x = -16; x < 16; ++x) keys.insert(hilbert_key({13, x, y}));
  EXPECT_EQ(keys.size(), 1024u);
  EXPECT_EQ(*keys.rbegin(), 1023u);
}

TEST(Hilbert, NeighboursOnTheCurveAreNeighboursOnTheGround) {
  const auto check = [](int level, uint64_t begin, uint64_t count) {
    TileIndex last = tile_of_key(level, begin);
    for (uint64_t key = begin + 1; key < begin + count; ++key) {
      const TileIndex t = tile_of_key(level, key);
      ASSERT_EQ(std::abs(t.x - last.x) + std::abs(t.y - last.y), 1) << "level " << level << " key " << key;
      last = t;
    }
  };
  check(10, 0, uint64_t(1) << 16);  // the whole curve
  Random random(6);
  for (int i = 0; i < 50; ++i) check(kMinLevel, uint64_t(random.integer(0, (int64_t(1) << 56) - 1001)), 1000);
}

}  // namespace
}  // namespace landfix::tiles
