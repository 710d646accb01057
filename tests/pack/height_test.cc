// Heights, undulation and geodesy through the runtime.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/pack/small_map.h"

namespace landfix::tests {
namespace {

constexpr int kNodata = -32768;
constexpr double kStep = 0.0625;

// An inclined plane in metres; bilinear interpolation must give it back, whatever the level.
double inclined(double east_m, double north_m) { return 400 + (east_m - kWestM) * 0.125 + (north_m - kSouthM) * 0.25; }

// Level 1 holds "ab" over "c." (tiles of 512 m); level 3 one tile of 2048 m around; 'b' has a lake without data.
DrawnLayer heights() {
  DrawnLayer layer;
  layer.name = "height";
  layer.format = {tiles::PixelType::kI16, 1, kNodata};
  layer.value_offset = 500;
  layer.value_step = float(kStep);
  layer.levels = {{1, kWestX >> 1, kSouthY >> 1, "ab\nc."}, {3, kWestX >> 3, kSouthY >> 3, "t"}};
  layer.pixel = [](const PixelOf& p) {
    const int column = int(p.column & 255), row = int(p.row & 255);
    if (p.letter == 'b' && std::hypot(column - 100, row - 100) < 20) return kNodata;
    const double gsd = tiles::gsd_of(p.level);
    const double h =
        inclined((double(p.column) + 0.5) * gsd, -(double(p.row) + 0.5) * gsd) + (p.letter == 't' ? 10 : 0);
    return int(std::lround((h - 500) / kStep));
  };
  return layer;
}

constexpr double kBaseEast = (kWestX >> 1) * 512.0, kBaseNorth = (kSouthY >> 1) * 512.0;

struct HeightPack : testing::Test {
  static Drawing drawing() {
    Drawing d{.layers = {small_gray(), heights()}};
    d.description.plane_height_m = 123;
    return d;
  }
  OpenPack pack{draw(drawing())};
};

TEST_F(HeightPack, AreBilinearAcrossTiles) {
  // Along a line from tile a into tile b, through their common edge at 512 m: the plane, to half a step of rounding.
  for (double x = 100; x < 620; x += 3.7) {
    const auto h = pack->height(kBaseEast + x, kBaseNorth + 900);
    ASSERT_TRUE(h);
    ASSERT_TRUE(h->from_layer);
    ASSERT_NEAR(h->height_m, inclined(kBaseEast + x, kBaseNorth + 900), kStep / 2 + 1e-9) << x;
  }
  // Across the corner of a, b, c and the hole, where up to one of the four pixels is missing.
  for (double y = 500; y < 530; y += 0.7)
    ASSERT_NEAR(pack->height(kBaseEast + 300, kBaseNorth + y)->height_m, inclined(kBaseEast + 300, kBaseNorth + y),
                kStep / 2 + 1e-9);
}

TEST_F(HeightPack, FallBackToTheCoarserLevel) {
  const double in_hole[] = {kBaseEast + 800, kBaseNorth + 200},
               in_lake[] = {kBaseEast + 512 + 201, kBaseNorth + 1024 - 201};
  for (const auto& at : {in_hole, in_lake}) {
    const auto h = pack->height(at[0], at[1]);
    ASSERT_TRUE(h);
    EXPECT_TRUE(h->from_layer);
    EXPECT_NEAR(h->height_m, inclined(at[0], at[1]) + 10, kStep / 2 + 1e-9);  // the coarse tile is drawn 10 m higher
  }
}

TEST_F(HeightPack, NearALakeUseWhatHasData) {
  // Where less than half the weight is missing the level still serves; the inclined plane's error is then below half a
  // pixel's rise.
  for (double x = 50; x < 240; x += 0.5) {
    const double east = kBaseEast + 512 + x, north = kBaseNorth + 1024 - 201;
    const auto h = pack->height(east, north);
    ASSERT_TRUE(h);
    const double error = h->height_m - inclined(east, north);
    EXPECT_TRUE(std::abs(error) < 0.5 || std::abs(error - 10) < 0.1) << x << ": " << error;
  }
}

TEST_F(HeightPack, HalfTheWeightDecides) {
  // On the edge of b and the hole, pixel centres lie 1 m north (with data) and 1 m south (without): at +0.4 m those
  // with data weigh 0.7 and their height, of 0.6 m farther north, serves; at -0.4 m they weigh 0.3 and the coarser
  // level serves.
  const double east = kBaseEast + 812, edge = kBaseNorth + 512;
  EXPECT_NEAR(pack->height(east, edge + 0.4)->height_m, inclined(east, edge + 1), kStep / 2 + 1e-9);
  EXPECT_NEAR(pack->height(east, edge - 0.4)->height_m, inclined(east, edge - 0.4) + 10, kStep / 2 + 1e-9);
}

TEST_F(HeightPack, WithoutAnyTileThePlaneIsAssumed) {
  Drawing d = drawing();
  d.layers[1].levels.pop_back();
  const OpenPack flat(draw(d));
  const auto h = flat->height(kBaseEast + 800, kBaseNorth + 200);
  ASSERT_TRUE(h);
  EXPECT_FALSE(h->from_layer);
  EXPECT_EQ(h->height_m, 123);
  EXPECT_EQ(flat->height(0, 0).status(), LF_OUTSIDE_MAP);
  EXPECT_TRUE(flat->info().has_heights);
  // A pack without heights at all says so.
  const OpenPack none(small_pack());
  EXPECT_FALSE(none->info().has_heights);
  EXPECT_FALSE(none->height(kWestM + 1, kSouthM + 1)->from_layer);
}

TEST_F(HeightPack, RefuseWhatIsNoPlace) {
  for (const double bad : {std::nan(""), double(INFINITY), 1e9}) {
    EXPECT_EQ(pack->height(bad, kSouthM).status(), LF_INVALID_ARGUMENT);
    EXPECT_EQ(pack->height(kWestM, bad).status(), LF_INVALID_ARGUMENT);
  }
}

TEST_F(HeightPack, AreReadAsFloatsWithNanForHoles) {
  const uint32_t layer = pack.layer("height");
  const auto r = pack->box(layer, kBaseEast, kBaseNorth, kBaseEast + 1024, kBaseNorth + 1024, 2);
  ASSERT_TRUE(r);
  ASSERT_EQ(r->width, 512u);
  std::vector<float> values(512 * 512);
  ASSERT_EQ(pack->read_heights(*r, values, 512 * sizeof(float)), LF_OK);
  size_t nans = 0;
  for (size_t y = 0; y < 512; ++y)
    for (size_t x = 0; x < 512; ++x) {
      const float v = values[y * 512 + x];
      const bool hole = x >= 256 && y >= 256,
                 lake = x >= 256 && y < 256 && std::hypot(double(x) - 356, double(y) - 100) < 20;
      ASSERT_EQ(std::isnan(v), hole || lake) << x << " " << y;
      nans += std::isnan(v);
      if (!std::isnan(v)) {
        ASSERT_NEAR(v, inclined(r->west_m + (double(x) + 0.5) * 2, r->north_m - (double(y) + 0.5) * 2),
                    kStep / 2 + 1e-4);
      }
    }
  EXPECT_GT(nans, 65536u);
  EXPECT_EQ(lf_read_heights(pack.c_pack(), &*r, values.data(), 512 * 4 - 4, values.size() * 4), LF_BUFFER_TOO_SMALL);
  EXPECT_EQ(lf_read_heights(pack.c_pack(), &*r, values.data(), 512 * 4 + 2, values.size() * 4), LF_INVALID_ARGUMENT);
  EXPECT_EQ(lf_read_heights(pack.c_pack(), &*r, values.data(), 512 * 4, values.size() * 4 - 1), LF_BUFFER_TOO_SMALL);
}

TEST_F(HeightPack, AreNotPixelsAndPixelsNotHeights) {
  const Region heights_region = *pack->box(pack.layer("height"), kWestM, kSouthM, kWestM + 4, kSouthM + 4, 2);
  const Region gray_region = *pack->box(pack.layer("gray"), kWestM, kSouthM, kWestM + 4, kSouthM + 4, 1);
  std::vector<uint8_t> pixels(1000);
  std::vector<float> values(1000);
  EXPECT_EQ(pack->read(heights_region, pixels, 100), LF_WRONG_TYPE);
  EXPECT_EQ(pack->read_heights(gray_region, values, 100), LF_WRONG_TYPE);
}

TEST_F(HeightPack, CompressedOnesArePreparedFirst) {
  Drawing d = drawing();
  d.layers[1].codec = [](char) { return tiles::Codec::kZstd; };
  const OpenPack packed(draw(d));
  const double east = kBaseEast + 300, north = kBaseNorth + 900;
  EXPECT_EQ(packed->height(east, north).status(), LF_NOT_PREPARED);
  ASSERT_EQ(packed->prepare(*packed->box(packed.layer("height"), east - 10, north - 10, east + 10, north + 10, 2)),
            LF_OK);
  EXPECT_EQ(packed->height(east, north)->height_m, pack->height(east, north)->height_m);
}

TEST(Undulation, IsBilinearInThePacksGrid) {
  Drawing d{.layers = {small_gray()}};
  ingest::GeoidGrid geoid{"egm96", kWestM - 1000, kSouthM - 1000, 1000, 3, 4, {}};
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 3; ++column)
      geoid.undulation_m.push_back(float(40 + column * 2 + row * 8 + column * row));
  d.description.geoid = geoid;
  const OpenPack pack(draw(d));
  const auto expected = [](double c, double r) { return 40 + c * 2 + r * 8 + c * r; };
  for (double r = 0; r <= 3; r += 0.25)
    for (double c = 0; c <= 2; c += 0.25) {
      const auto n = pack->undulation(geoid.west_m + 1000 * c, geoid.south_m + 1000 * r);
      ASSERT_TRUE(n) << c << " " << r;
      ASSERT_NEAR(*n, expected(c, r), 1e-9);
    }
  const double outside[][2] = {{-0.01, 1}, {2.01, 1}, {1, -0.01}, {1, 3.01}};
  for (const auto& [c, r] : outside)
    EXPECT_EQ(pack->undulation(geoid.west_m + 1000 * c, geoid.south_m + 1000 * r).status(), LF_OUTSIDE_MAP);
  EXPECT_EQ(pack->undulation(std::nan(""), 0).status(), LF_INVALID_ARGUMENT);
  EXPECT_EQ(OpenPack(small_pack())->undulation(kWestM, kSouthM).status(), LF_OUTSIDE_MAP);  // no geoid
}

TEST(Geodesy, OfAPackIsThatOfItsZone) {
  constexpr double kDegree = std::numbers::pi / 180;
  // On the central meridian, where easting, convergence and scale are known by definition.
  const OpenPack north(small_pack());
  const auto g = north->grid_from_geodetic(45 * kDegree, 9 * kDegree);
  ASSERT_TRUE(g);
  EXPECT_NEAR(g->east_m, 500000, 1e-6);
  EXPECT_NEAR(g->north_m, 4982950.400, 1e-3);  // 0.9996 times the meridian arc to 45 degrees, 4984944.378 m
  EXPECT_NEAR(g->convergence_rad, 0, 1e-12);
  EXPECT_NEAR(g->scale, 0.9996, 1e-9);
  const auto back = north->geodetic_from_grid(g->east_m, g->north_m);
  ASSERT_TRUE(back);
  EXPECT_NEAR(back->latitude_rad, 45 * kDegree, 1e-12);
  EXPECT_NEAR(back->longitude_rad, 9 * kDegree, 1e-12);
  Drawing d{.layers = {small_gray()}};
  d.description.zone = {32, false};
  const auto south = OpenPack(draw(d))->grid_from_geodetic(-45 * kDegree, 9 * kDegree);
  EXPECT_NEAR(south->north_m, 10e6 - 4982950.400, 1e-3);
  EXPECT_EQ(north->grid_from_geodetic(2, 0).status(), LF_INVALID_ARGUMENT);
  EXPECT_EQ(north->grid_from_geodetic(std::nan(""), 0).status(), LF_INVALID_ARGUMENT);
  EXPECT_EQ(north->geodetic_from_grid(std::nan(""), 0).status(), LF_INVALID_ARGUMENT);
  double e, n;
  EXPECT_EQ(lf_grid_from_geodetic(north.c_pack(), 0.8, 0.15, &e, &n, nullptr, nullptr), LF_OK);
}

}  // namespace
}  // namespace landfix::tests
