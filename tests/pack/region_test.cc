// Regions, reads and tile views: the runtime's contract on a small map.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "tests/pack/small_map.h"
#include "tiles/ellipse.h"

namespace landfix::tests {
namespace {

Region whole(const OpenPack& pack, double gsd_m = 1) { return *pack->box(0, kWestM, kSouthM, kEastM, kNorthM, gsd_m); }

TEST(Region, TakesTheCoarsestLevelNotCoarserThanWanted) {
  const OpenPack pack(small_pack());
  const Ellipse e{kWestM + 300, kSouthM + 300, 100, 0, 100, 3};
  const std::pair<double, int> wanted[] = {{1, 0}, {1.99, 0}, {2, 1}, {3, 1}, {0.3, 0}, {1000, 1}, {INFINITY, 1}};
  for (const auto& [gsd_m, level] : wanted) {
    EXPECT_EQ(pack->region(0, e, gsd_m)->level, level) << gsd_m;
    EXPECT_EQ(pack->box(0, kWestM, kSouthM, kEastM, kNorthM, gsd_m)->level, level) << gsd_m;
  }
}

TEST(Region, IsTheBoundingBoxOfTheEllipse) {
  const OpenPack pack(small_pack());
  // Half axes 3 * 10 m east, 3 * 5 m north around (500300.3, 5000100.7): easting 500270.3 to 500330.3, northing
  // 5000085.7 to 5000115.7.
  const auto r = pack->region(0, {500300.3, 5000100.7, 100, 20, 25, 3}, 1);
  ASSERT_TRUE(r);
  EXPECT_EQ(r->first_column, 500270);
  EXPECT_EQ(r->width, 61u);
  EXPECT_EQ(r->first_row, -5000116);
  EXPECT_EQ(r->height, 31u);
  EXPECT_EQ(r->west_m, 500270);
  EXPECT_EQ(r->north_m, 5000116);
  EXPECT_EQ(r->gsd_m, 1);
  // At level 1 the same metres in pixels of 2 m.
  const auto coarse = pack->region(0, {500300.3, 5000100.7, 100, 20, 25, 3}, 2);
  EXPECT_EQ(coarse->first_column, 250135);
  EXPECT_EQ(coarse->width, 31u);
}

TEST(Region, OfABoxIsHalfOpen) {
  const OpenPack pack(small_pack());
  const Region r = whole(pack);
  EXPECT_EQ(r.width, 768u);
  EXPECT_EQ(r.height, 512u);
  EXPECT_EQ(r.west_m, kWestM);
  EXPECT_EQ(r.north_m, kNorthM);
  const auto point = pack->box(0, kWestM, kSouthM + 0.5, kWestM, kSouthM + 0.5, 1);
  ASSERT_TRUE(point);
  EXPECT_EQ(point->width, 1u);
  EXPECT_EQ(point->height, 1u);
}

TEST(Region, OutsideTheMapIsSaid) {
  const OpenPack pack(small_pack());
  const double beyond[][2] = {
      {kWestM - 100, kSouthM}, {kEastM + 100, kSouthM}, {kWestM, kSouthM - 100}, {kWestM, kNorthM + 100}};
  for (const auto& [east, north] : beyond)
    EXPECT_EQ(pack->region(0, {east, north, 100, 0, 100, 3}, 1).status(), LF_OUTSIDE_MAP);
  EXPECT_EQ(pack->box(0, kEastM, kSouthM, kEastM + 10, kNorthM, 1).status(), LF_OUTSIDE_MAP);
  EXPECT_EQ(pack->region(0, {kEastM + 25, kSouthM, 100, 0, 100, 3}, 1).status(), LF_OK);  // reaches 5 m into it
}

TEST(Region, RefusesWhatIsNoEllipse) {
  const OpenPack pack(small_pack());
  const Ellipse good{kWestM + 300, kSouthM + 300, 100, 0, 100, 3};
  for (const double bad : {std::nan(""), double(INFINITY), -double(INFINITY)})
    for (double Ellipse::*field :
         {&Ellipse::east_m, &Ellipse::north_m, &Ellipse::cov_ee, &Ellipse::cov_en, &Ellipse::cov_nn, &Ellipse::k}) {
      Ellipse e = good;
      e.*field = bad;
      EXPECT_EQ(pack->region(0, e, 1).status(), LF_INVALID_ARGUMENT);
      uint64_t cursor = 0;
      const Region r = whole(pack);
      Tile tile;
      EXPECT_EQ(lf_next_tile(pack.c_pack(), &r, &e, &cursor, &tile), LF_INVALID_ARGUMENT);
    }
  EXPECT_EQ(pack->region(0, {kWestM, kSouthM, 100, 200, 100, 3}, 1).status(), LF_INVALID_ARGUMENT);
  EXPECT_EQ(pack->region(0, {kWestM, kSouthM, -1, 0, 100, 3}, 1).status(), LF_INVALID_ARGUMENT);
  for (const double gsd_m : {0.0, -1.0, std::nan("")})
    EXPECT_EQ(pack->region(0, good, gsd_m).status(), LF_INVALID_ARGUMENT);
  EXPECT_EQ(pack->region(1, good, 1).status(), LF_INVALID_ARGUMENT);
  EXPECT_EQ(pack->box(0, kWestM, kSouthM, kWestM - 1, kNorthM, 1).status(), LF_INVALID_ARGUMENT);
  EXPECT_EQ(pack->box(0, std::nan(""), kSouthM, kEastM, kNorthM, 1).status(), LF_INVALID_ARGUMENT);
  EXPECT_EQ(pack->box(7, kWestM, kSouthM, kEastM, kNorthM, 1).status(), LF_INVALID_ARGUMENT);
}

TEST(Region, TooManyPixelsAreRefused) {
  const OpenPack pack(small_pack());
  // 3 sigma of 5 km each way at 1 m: 30 000 x 30 000 pixels; the limit is 2^28, 16 384 x 16 384.
  EXPECT_EQ(pack->region(0, {kWestM, kSouthM, 25e6, 0, 25e6, 3}, 1).status(), LF_REGION_TOO_LARGE);
  EXPECT_EQ(pack->region(0, {kWestM, kSouthM, 7e6, 0, 7e6, 3}, 1).status(), LF_OK);
}

TEST(Read, CrossesTilesAndHoles) {
  const OpenPack pack(small_pack());
  // All of the map and a rim of 10 pixels around it.
  const auto r = pack->box(0, kWestM - 10, kSouthM - 10, kEastM + 10, kNorthM + 10, 1);
  ASSERT_TRUE(r);
  const Read got = read(*pack, *r);
  ASSERT_EQ(got.status, LF_OK);
  size_t data = 0;
  for (int64_t y = 0; y < r->height; ++y)
    for (int64_t x = 0; x < r->width; ++x) {
      const int64_t column = r->first_column + x, row = r->first_row + y;
      const char letter = small_letter(column, row);
      const int expected = letter == '.' ? 0 : pattern({letter, 0, column, row, 0});
      ASSERT_EQ(got.pixels[size_t(y) * r->width + size_t(x)], expected) << letter << " " << x << " " << y;
      data += expected != 0;
    }
  EXPECT_EQ(data, 65536u * 4 + 65536u / 2);  // a, b, c, d and half of E
}

TEST(Read, IsTheSameHoweverManyTilesLieSideBySide) {
  // 19 tiles in a row with holes: wider than what is copied in one go.
  const std::string map = "abcdefgh.ijklmn.opq";
  DrawnLayer layer = small_gray();
  layer.levels = {{0, kWestX, kSouthY, map}};
  const OpenPack pack(draw({{layer}}));
  const auto r = pack->box(0, kWestM + 3, kSouthM + 100, kWestM + 19 * 256 - 5, kSouthM + 104, 1);
  ASSERT_TRUE(r);
  const Read got = read(*pack, *r);
  ASSERT_EQ(got.status, LF_OK);
  for (int64_t y = 0; y < r->height; ++y)
    for (int64_t x = 0; x < r->width; ++x) {
      const int64_t column = r->first_column + x, row = r->first_row + y;
      const char letter = map[size_t(column / 256 - kWestX)];
      const int expected = letter == '.' ? 0 : pattern({letter, 0, column, row, 0});
      ASSERT_EQ(got.pixels[size_t(y) * r->width + size_t(x)], expected) << letter << " " << x << " " << y;
    }
}

TEST(Read, KeepsToTheCallersRows) {
  const OpenPack pack(small_pack());
  const auto r = pack->box(0, kWestM + 250, kSouthM + 250, kWestM + 262, kSouthM + 262,
                           1);  // 12 x 12 around the corner of four tiles
  ASSERT_TRUE(r);
  constexpr size_t kRow = 20;
  std::vector<uint8_t> out(kRow * 11 + 12, 0xEE);
  ASSERT_EQ(pack->read(*r, out, kRow), LF_OK);
  for (size_t y = 0; y < 12; ++y)
    for (size_t x = 0; x < kRow && y * kRow + x < out.size(); ++x) {
      const int64_t column = r->first_column + int64_t(x), row = r->first_row + int64_t(y);
      const char letter = small_letter(column, row);
      const int expected = x >= 12 ? 0xEE : letter == '.' ? 0 : pattern({letter, 0, column, row, 0});
      ASSERT_EQ(out[y * kRow + x], expected) << x << " " << y;
    }
}

TEST(Read, RefusesSmallBuffers) {
  const OpenPack pack(small_pack());
  const Region r = whole(pack);
  std::vector<uint8_t> out(768 * 512);
  EXPECT_EQ(lf_read(pack.c_pack(), &r, out.data(), 768, out.size()), LF_OK);
  EXPECT_EQ(lf_read(pack.c_pack(), &r, out.data(), 768, out.size() - 1), LF_BUFFER_TOO_SMALL);
  EXPECT_EQ(lf_read(pack.c_pack(), &r, out.data(), 767, out.size()), LF_BUFFER_TOO_SMALL);
  EXPECT_EQ(lf_read(pack.c_pack(), &r, out.data(), 0, out.size()), LF_BUFFER_TOO_SMALL);
  EXPECT_EQ(lf_read(pack.c_pack(), &r, out.data(), SIZE_MAX, out.size()), LF_BUFFER_TOO_SMALL);
  EXPECT_EQ(lf_read(pack.c_pack(), &r, out.data(), 768, 0), LF_BUFFER_TOO_SMALL);
}

TEST(Read, RefusesRegionsThatNobodyGaveOut) {
  const OpenPack pack(small_pack());
  const Region good = whole(pack);
  std::vector<uint8_t> out(1 << 20);
  const int64_t far = std::numeric_limits<int64_t>::max();
  const auto with = [&](auto change) {
    Region r = good;
    change(r);
    Tile tile;
    uint64_t cursor = 0;
    const lf_status s = lf_read(pack.c_pack(), &r, out.data(), 1024, out.size());
    EXPECT_EQ(lf_prepare(pack.c_pack(), &r, 0), s);
    EXPECT_EQ(lf_next_tile(pack.c_pack(), &r, nullptr, &cursor, &tile), s);
    return s;
  };
  EXPECT_EQ(with([](Region& r) { r.layer = 1; }), LF_INVALID_ARGUMENT);
  EXPECT_EQ(with([](Region& r) { r.level = 2; }), LF_INVALID_ARGUMENT);
  EXPECT_EQ(with([](Region& r) { r.level = -100; }), LF_INVALID_ARGUMENT);
  EXPECT_EQ(with([](Region& r) { r.width = 0; }), LF_INVALID_ARGUMENT);
  EXPECT_EQ(with([](Region& r) { r.height = 0; }), LF_INVALID_ARGUMENT);
  for (const int64_t value : {far, -far, int64_t(1) << 25, -(int64_t(1) << 25) - 1}) {
    EXPECT_EQ(with([=](Region& r) { r.first_column = value; }), LF_INVALID_ARGUMENT) << value;
    EXPECT_EQ(with([=](Region& r) { r.first_row = value; }), LF_INVALID_ARGUMENT) << value;
  }
  EXPECT_EQ(with([](Region& r) { r.width = r.height = 0xFFFFFFFF; }), LF_REGION_TOO_LARGE);
}

TEST(TileView, PointsIntoTheMapping) {
  const TemporaryFolder folder;
  const std::string path = folder.file("small.lfpack");
  write_file(path, small_pack());
  const auto pack = Pack::open(path.c_str());
  ASSERT_TRUE(pack);
  const auto tile = pack->tile(0, 0, kWestX, kSouthY + 1);
  ASSERT_TRUE(tile);
  EXPECT_EQ(tile->row_bytes, 256u);
  EXPECT_EQ(tile->west_m, kWestM);
  EXPECT_EQ(tile->north_m, kNorthM);
  const auto* pixels = static_cast<const uint8_t*>(tile->pixels);
  EXPECT_EQ(pixels[3 * 256 + 5], pattern({'a', 0, 5, 3, 0}));
  // The kernel's list of mappings names the file for the pointer's address: nothing was copied.
  const std::vector<uint8_t> maps = read_file("/proc/self/maps");
  std::istringstream lines(std::string(maps.begin(), maps.end()));
  bool found = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.find(path) == std::string::npos) continue;
    const uintptr_t begin = std::stoull(line, nullptr, 16),
                    end = std::stoull(line.substr(line.find('-') + 1), nullptr, 16);
    found |= reinterpret_cast<uintptr_t>(pixels) >= begin && reinterpret_cast<uintptr_t>(pixels) < end;
  }
  EXPECT_TRUE(found);
}

TEST(TileView, SaysWhereThereIsNone) {
  const OpenPack pack(small_pack());
  EXPECT_EQ(pack->tile(0, 0, kWestX + 1, kSouthY).status(), LF_OUTSIDE_MAP);  // the hole
  EXPECT_EQ(pack->tile(0, 0, 0, 0).status(), LF_OUTSIDE_MAP);
  EXPECT_EQ(pack->tile(0, 0, std::numeric_limits<int32_t>::max(), std::numeric_limits<int32_t>::min()).status(),
            LF_OUTSIDE_MAP);
  EXPECT_EQ(pack->tile(0, 5, kWestX, kSouthY).status(), LF_INVALID_ARGUMENT);
  EXPECT_EQ(pack->tile(1, 0, kWestX, kSouthY).status(), LF_INVALID_ARGUMENT);
}

std::string letters(const OpenPack& pack, const Region& region, const Ellipse* ellipse) {
  std::string found;
  const Status s = pack->for_each_tile(region, ellipse, [&](const Tile& tile) {
    found += small_letter(int64_t(tile.x) * 256, -int64_t(tile.y) * 256 - 1);
  });
  EXPECT_EQ(s, LF_OK);
  return found;
}

TEST(NextTile, WalksTheTilesWithData) {
  const OpenPack pack(small_pack());
  EXPECT_EQ(letters(pack, whole(pack), nullptr), "abcdE");
  EXPECT_EQ(letters(pack, *pack->box(0, kWestM + 300, kSouthM, kEastM, kSouthM + 200, 1), nullptr), "E");
}

TEST(NextTile, LeavesOutWhatTheEllipseDoesNotTouch) {
  const OpenPack pack(small_pack());
  // Long and thin from the north-west to the south-east, through the map's middle: a and E, and b at its south-western
  // corner.
  const Ellipse thin{kWestM + 384, kSouthM + 256, 160000, -106000, 71000, 1};
  std::string expected;
  const tiles::Ellipse e{thin.east_m, thin.north_m, {thin.cov_ee, thin.cov_en, thin.cov_nn}, thin.k};
  for (int32_t y = kSouthY + 1; y >= kSouthY; --y)
    for (int32_t x = kWestX; x < kWestX + 3; ++x) {
      const char letter = small_letter(int64_t(x) * 256, -int64_t(y) * 256 - 1);
      if (letter != '.' && tiles::touches(e, {0, x, y})) expected += letter;
    }
  EXPECT_EQ(letters(pack, whole(pack), &thin), expected);
  EXPECT_EQ(expected, "abE");
  const Ellipse nowhere{kWestM - 5000, kSouthM, 1, 0, 1, 1};
  EXPECT_EQ(letters(pack, whole(pack), &nowhere), "");
}

TEST(Arguments, NullIsAnErrorEverywhere) {
  const OpenPack pack(small_pack());
  const lf_pack* p = pack.c_pack();
  const Region r = whole(pack);
  const Ellipse e{kWestM, kSouthM, 1, 0, 1, 1};
  Region region;
  Tile tile;
  uint64_t cursor = 0;
  uint8_t pixels[4];
  float heights[4];
  uint64_t words[4];
  uint16_t epochs[1];
  uint32_t count;
  lf_epoch_info epoch;
  lf_epoch_range range;
  double d;
  const char* text;
  uint32_t layer;
  lf_pack* opened;
  const lf_status all[] = {lf_open(nullptr, nullptr, &opened),
                           lf_open("x", nullptr, nullptr),
                           lf_open_memory(nullptr, 8, nullptr, &opened),
                           lf_get_info(nullptr, nullptr),
                           lf_get_info(p, nullptr),
                           lf_find_layer(p, nullptr, &layer),
                           lf_find_layer(p, "gray", nullptr),
                           lf_find_layer(nullptr, "gray", &layer),
                           lf_get_layer(p, 0, nullptr),
                           lf_get_level(p, 0, 0, nullptr),
                           lf_get_source(p, 0, nullptr),
                           lf_get_parameter(p, 0, nullptr, &text),
                           lf_get_parameter(p, 0, &text, nullptr),
                           lf_ellipse_region(nullptr, 0, &e, 1, &region),
                           lf_ellipse_region(p, 0, nullptr, 1, &region),
                           lf_ellipse_region(p, 0, &e, 1, nullptr),
                           lf_box_region(nullptr, 0, 0, 0, 1, 1, 1, &region),
                           lf_box_region(p, 0, 0, 0, 1, 1, 1, nullptr),
                           lf_read(nullptr, &r, pixels, 1, 4),
                           lf_read(p, nullptr, pixels, 1, 4),
                           lf_read(p, &r, nullptr, 1, 4),
                           lf_read_heights(nullptr, &r, heights, 4, 16),
                           lf_read_heights(p, nullptr, heights, 4, 16),
                           lf_read_heights(p, &r, nullptr, 4, 16),
                           lf_read_bits(nullptr, &r, words, 1, 1, 4),
                           lf_read_bits(p, nullptr, words, 1, 1, 4),
                           lf_read_bits(p, &r, nullptr, 1, 1, 4),
                           lf_get_epoch(nullptr, 0, &epoch),
                           lf_get_epoch(p, 0, nullptr),
                           lf_tile_epochs(nullptr, 0, 0, 0, 0, epochs, 1, &count),
                           lf_tile_epochs(p, 0, 0, kWestX, kSouthY, nullptr, 1, &count),
                           lf_tile_epochs(p, 0, 0, kWestX, kSouthY, epochs, 1, nullptr),
                           lf_region_epochs(nullptr, &r, &range),
                           lf_region_epochs(p, nullptr, &range),
                           lf_region_epochs(p, &r, nullptr),
                           lf_tile_view(nullptr, 0, 0, 0, 0, &tile),
                           lf_tile_view(p, 0, 0, 0, 0, nullptr),
                           lf_next_tile(nullptr, &r, nullptr, &cursor, &tile),
                           lf_next_tile(p, nullptr, nullptr, &cursor, &tile),
                           lf_next_tile(p, &r, nullptr, nullptr, &tile),
                           lf_next_tile(p, &r, nullptr, &cursor, nullptr),
                           lf_prepare(nullptr, &r, 0),
                           lf_prepare(p, nullptr, 0),
                           lf_height(nullptr, 0, 0, &d, nullptr),
                           lf_height(p, 0, 0, nullptr, nullptr),
                           lf_undulation(nullptr, 0, 0, &d),
                           lf_undulation(p, 0, 0, nullptr),
                           lf_grid_from_geodetic(nullptr, 0, 0, &d, &d, nullptr, nullptr),
                           lf_grid_from_geodetic(p, 0, 0, nullptr, &d, nullptr, nullptr),
                           lf_geodetic_from_grid(nullptr, 0, 0, &d, &d, nullptr, nullptr),
                           lf_geodetic_from_grid(p, 0, 0, &d, nullptr, nullptr, nullptr),
                           lf_verify_pack(nullptr, 0, nullptr)};
  for (size_t i = 0; i < std::size(all); ++i) EXPECT_EQ(all[i], LF_INVALID_ARGUMENT) << "call " << i;
  lf_close(nullptr);
}

}  // namespace
}  // namespace landfix::tests
