// What an uncertainty ellipse touches, against brute force.
#include "tiles/ellipse.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "tests/tiles/random.h"

namespace landfix::tiles {
namespace {

using tests::Random;

Covariance covariance_of(double sigma_a_m, double sigma_b_m, double angle_rad) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad), a = sigma_a_m * sigma_a_m, b = sigma_b_m * sigma_b_m;
  return {a * c * c + b * s * s, (a - b) * s * c, a * s * s + b * c * c};
}

// Least Mahalanobis distance from the mean to a tile: inside it is 0, else the least over many points of its edges.
double least_distance(const Ellipse& e, const TileIndex& t) {
  const double side = tile_side(t.level), x0 = t.x * side - e.east_m, y0 = t.y * side - e.north_m;
  if (x0 <= 0 && x0 + side >= 0 && y0 <= 0 && y0 + side >= 0) return 0;
  const double ee = e.covariance.ee, en = e.covariance.en, nn = e.covariance.nn;
  const double determinant = ee * nn - en * en;
  double least = std::numeric_limits<double>::infinity();
  const auto visit = [&](double x, double y) {
    least = std::min(least, (nn * x * x - 2 * en * x * y + ee * y * y) / determinant);
  };
  const int steps = 2000;
  for (int i = 0; i <= steps; ++i) {
    const double at = side * i / steps;
    visit(x0 + at, y0), visit(x0 + at, y0 + side), visit(x0, y0 + at), visit(x0 + side, y0 + at);
  }
  return std::sqrt(least);
}

TEST(Touches, AgreesWithBruteForce) {
  Random random(1);
  int hits = 0, misses = 0;
  for (int i = 0; i < 300; ++i) {
    Ellipse e{random.uniform(3e5, 7e5), random.uniform(1e6, 9e6), {}, random.uniform(0.5, 5)};
    const double sigma = std::exp(random.uniform(std::log(5.0), std::log(500.0)));
    e.covariance = covariance_of(sigma, sigma * random.uniform(0.05, 1), random.uniform(0, std::numbers::pi));
    const auto rect = bounding_pixels(e, 0);
    ASSERT_TRUE(rect);
    TileRange range = tiles_of(*rect);
    if (range.x_max - range.x_min > 12 || range.y_max - range.y_min > 12) continue;
    for (int32_t y = range.y_min - 1; y <= range.y_max + 1; ++y)
      for (int32_t x = range.x_min - 1; x <= range.x_max + 1; ++x) {
        const double distance = least_distance(e, {0, x, y});
        if (std::abs(distance - e.k) < 1e-3 * e.k) continue;  // too close for the sampled edges to tell
        const bool expected = distance < e.k;
        ASSERT_EQ(touches(e, {0, x, y}), expected)
            << "ellipse " << i << ", tile " << x << " " << y << ": " << distance << " of " << e.k;
        ++(expected ? hits : misses);
      }
  }
  EXPECT_GT(hits, 1000);
  EXPECT_GT(misses, 1000);
}

TEST(Touches, BoundingBoxCornersOfADiagonalEllipseAreFree) {
  // 1000 m along the diagonal, 10 m across: of the box's tiles, those of the other diagonal are not touched.
  const Ellipse e{500000, 5000000, covariance_of(1000, 10, std::numbers::pi / 4), 2};
  const TileRange range = tiles_of(*bounding_pixels(e, 0));
  EXPECT_TRUE(touches(e, {0, range.x_max, range.y_max}));
  EXPECT_TRUE(touches(e, {0, range.x_min, range.y_min}));
  EXPECT_FALSE(touches(e, {0, range.x_min, range.y_max}));
  EXPECT_FALSE(touches(e, {0, range.x_max, range.y_min}));
}

TEST(Touches, APointTouchesItsTileOnly) {
  const Ellipse point{100, 100, {0, 0, 0}, 3};
  EXPECT_TRUE(touches(point, {0, 0, 0}));
  for (const TileIndex t : {TileIndex{0, 1, 0}, TileIndex{0, -1, 0}, TileIndex{0, 0, 1}, TileIndex{0, 1, 1}})
    EXPECT_FALSE(touches(point, t));
  // On a corner it touches the four closed tiles around.
  const Ellipse corner{256, 256, {0, 0, 0}, 3};
  for (const TileIndex t : {TileIndex{0, 0, 0}, TileIndex{0, 1, 0}, TileIndex{0, 0, 1}, TileIndex{0, 1, 1}})
    EXPECT_TRUE(touches(corner, t));
}

TEST(Touches, ALineTouchesWhatItCrosses) {
  // sigma 1000 m along north-east with correlation 1: the segment from (128, 128) - 1000 (1, 1) to (128, 128) + 1000
  // (1, 1).
  const Ellipse diagonal{128, 128, {1e6, 1e6, 1e6}, 1};
  for (int32_t i = -4; i <= 4; ++i) EXPECT_TRUE(touches(diagonal, {0, i, i})) << i;
  EXPECT_FALSE(touches(diagonal, {0, 5, 5}));  // begins at 1280 m; the segment ends at 1128 m
  EXPECT_FALSE(touches(diagonal, {0, 2, 0}));
  // Half a metre beside the corner of (0, 1) it does not touch that tile; through the corner it does.
  EXPECT_TRUE(touches(diagonal, {0, 0, 1}));
  EXPECT_FALSE(touches({128.7, 128, {1e6, 1e6, 1e6}, 1}, {0, 0, 1}));
  const Ellipse east{128, 128, {1e6, 0, 0}, 1};
  for (int32_t i = -4; i <= 4; ++i) EXPECT_TRUE(touches(east, {0, i, 0})) << i;
  EXPECT_FALSE(touches(east, {0, 0, 1}));
  EXPECT_FALSE(touches(east, {0, 5, 0}));
}

TEST(Contains, AgreesWithTheQuadraticForm) {
  Random random(11);
  const Ellipse e{1000, -500, covariance_of(80, 20, 0.7), 2};
  const auto& [ee, en, nn] = e.covariance;
  int inside = 0;
  for (int i = 0; i < 10000; ++i) {
    const double x = random.uniform(-200, 200), y = random.uniform(-200, 200);
    const double form = (nn * x * x - 2 * en * x * y + ee * y * y) / (ee * nn - en * en);
    ASSERT_EQ(contains(e, 1000 + x, -500 + y), form <= 4) << x << " " << y;
    inside += form <= 4;
  }
  EXPECT_NEAR(inside / 10000.0 * 400 * 400, std::numbers::pi * 160 * 40, 1500) << "its area";
}

TEST(Contains, OfADegenerateEllipseAreItsPoints) {
  const Ellipse point{10, 20, {}, 3}, line{0, 0, {100, 0, 0}, 3};
  EXPECT_TRUE(contains(point, 10, 20));
  EXPECT_FALSE(contains(point, 10.01, 20));
  EXPECT_TRUE(contains(line, 29, 0));
  EXPECT_FALSE(contains(line, 31, 0));
  EXPECT_FALSE(contains(line, 0, 0.1));
}

TEST(TouchesLine, AgreesWithPointsAlongIt) {
  Random random(12);
  const Ellipse e{0, 0, covariance_of(60, 15, 2.1), 2};
  int touched = 0;
  for (int i = 0; i < 3000; ++i) {
    const double x0 = random.uniform(-200, 200), y0 = random.uniform(-200, 200), x1 = random.uniform(-200, 200),
                 y1 = random.uniform(-200, 200);
    bool any = false;
    for (int k = 0; k <= 2000 && !any; ++k) any = contains(e, x0 + (x1 - x0) * k / 2000, y0 + (y1 - y0) * k / 2000);
    // A line that only grazes it may pass between two of the points.
    EXPECT_TRUE(!any || touches_line(e, x0, y0, x1, y1));
    const Ellipse larger{0, 0, e.covariance, 2.02};
    bool nearly = any;
    for (int k = 0; k <= 2000 && !nearly; ++k)
      nearly = contains(larger, x0 + (x1 - x0) * k / 2000, y0 + (y1 - y0) * k / 2000);
    EXPECT_TRUE(nearly || !touches_line(e, x0, y0, x1, y1));
    touched += any;
  }
  EXPECT_GT(touched, 500);
  EXPECT_LT(touched, 2500);
  EXPECT_TRUE(touches_line(e, 0, 0, 0, 0)) << "a line without length";
  EXPECT_FALSE(touches_line(e, 300, 0, 300, 0));
}

TEST(BoundingPixels, HoldsTheEllipseAndNoMore) {
  // Half axes k sigma = 30 and 20 m at GSD 0.5: pixels 2 * (1000 - 30) .. 2 * (1000 + 30), where the last one is
  // touched by its edge.
  const auto rect = bounding_pixels({1000, 2000, {100, 0, 44.44444444444444}, 3}, -1);
  ASSERT_TRUE(rect);
  EXPECT_EQ(rect->column, 1940);
  EXPECT_EQ(rect->width, 121);
  EXPECT_EQ(rect->row, -4040);
  EXPECT_GE(rect->height, 80);
  EXPECT_LE(rect->height, 81);
  const auto point = bounding_pixels({1000.2, 2000.2, {0, 0, 0}, 3}, 0);
  ASSERT_TRUE(point);
  EXPECT_EQ(*point, (PixelRect{0, 1000, -2001, 1, 1}));
}

TEST(Validity, RefusesWhatIsNoEllipse) {
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(is_valid({0, 0, {1, 0, 1}, 3}));
  EXPECT_TRUE(is_valid({0, 0, {4, 2, 1}, 3}));  // correlation 1: a line
  EXPECT_FALSE(is_valid({0, 0, {4, 2.1, 1}, 3}));
  EXPECT_FALSE(is_valid({0, 0, {-1, 0, 1}, 3}));
  EXPECT_FALSE(is_valid({0, 0, {1, 0, 1}, -1}));
  EXPECT_FALSE(is_valid({3.3e7, 0, {1e12, 0, 1}, 3}));  // leaves the grid's domain
  for (const double bad : {nan, infinity, -infinity})
    for (int field = 0; field < 6; ++field) {
      double v[6] = {0, 0, 1, 0, 1, 3};
      v[field] = bad;
      const Ellipse e{v[0], v[1], {v[2], v[3], v[4]}, v[5]};
      EXPECT_FALSE(is_valid(e)) << field;
      EXPECT_EQ(bounding_pixels(e, 0), std::nullopt);
    }
  EXPECT_EQ(bounding_pixels({0, 0, {1, 0, 1}, 3}, kMaxLevel + 1), std::nullopt);
}

}  // namespace
}  // namespace landfix::tiles
