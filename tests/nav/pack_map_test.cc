// A pack as the map of the localizer: what is valid, what is not, and a fix on it.
#include "runtime/nav/pack_map.h"

#include <gtest/gtest.h>

#include <cctype>
#include <cmath>

#include "runtime/features/orientation_code.h"
#include "runtime/nav/localizer.h"
#include "tests/nav/scene.h"
#include "tests/pack/small_map.h"

namespace landfix::nav {
namespace {

using landfix::tests::kEastM;
using landfix::tests::kNorthM;
using landfix::tests::kSouthM;
using landfix::tests::kWestM;

TEST(PackMap, MarksHolesAndWhatLiesBeyondTheMap) {
  // Tiles of 256 m: the middle one of the southern row is a hole, the eastern half of the one east of it is without
  // data.
  const landfix::tests::OpenPack pack(landfix::tests::small_pack());
  ASSERT_EQ(pack.status(), LF_OK);
  const PackMap map(*pack);
  EXPECT_EQ(map.gsd_range_m(MapLayer::kGray), std::make_pair(1.0, 2.0));
  features::GridImage window;
  ASSERT_EQ(map.read(MapLayer::kGray, kWestM - 10, kSouthM - 10, kEastM + 10, kNorthM + 10, 1, window),
            nav::Status::kOk);
  const auto valid = [&](double east_m, double north_m) {
    return window.valid.at<uint8_t>(int(std::lround(window.row_of(kSouthM + north_m))),
                                    int(std::lround(window.column_of(kWestM + east_m))));
  };
  EXPECT_EQ(valid(0.5, 0.5), 255);
  EXPECT_EQ(valid(-0.5, 0.5), 0);
  EXPECT_EQ(valid(255.5, 100.5), 255);
  EXPECT_EQ(valid(256.5, 100.5), 0);
  EXPECT_EQ(valid(511.5, 255.5), 0);
  EXPECT_EQ(valid(511.5, 256.5), 255);
  EXPECT_EQ(valid(639.5, 0.5), 255);
  EXPECT_EQ(valid(640.5, 0.5), 0);
  EXPECT_EQ(valid(767.5, 511.5), 255);
  EXPECT_EQ(valid(767.5, 512.5), 0);
  ASSERT_EQ(map.read(MapLayer::kGray, kWestM + 10, kSouthM + 10, kWestM + 60, kSouthM + 50, 2, window),
            nav::Status::kOk);
  EXPECT_EQ(window.gsd_m, 2);
  EXPECT_TRUE(window.valid.empty());
  EXPECT_EQ(map.read(MapLayer::kGray, 0, 0, 100, 100, 1, window), nav::Status::kOutsideMap);
  EXPECT_EQ(map.read(MapLayer::kGray, kWestM + 300, kSouthM + 50, kWestM + 400, kSouthM + 150, 1, window),
            nav::Status::kOutsideMap);
  EXPECT_EQ(map.read(MapLayer::kGray, std::nan(""), 0, 100, 100, 1, window), nav::Status::kMapError);
}

/// Orientation of five levels that tells tiles and neighbouring pixels apart.
cv::Vec<int8_t, 2> drawn_levels(int64_t column, int64_t row) {
  const auto mixed = uint32_t(column * 2654435761u ^ row * 2246822519u) * 3266489917u;
  return {int8_t(int(mixed >> 27) % 5 - 2), int8_t(int(mixed >> 22 & 31) % 5 - 2)};
}

/// No data: the eastern half of tiles with a capital letter, and every 37th pixel.
bool drawn_valid(const landfix::tests::PixelOf& p) {
  return !(std::isupper(p.letter) && (p.column & 255) >= 128) && (p.column * 5 + p.row) % 37 != 0;
}

/// The small map as the layer `orientation`, its bits made by the packing that the builder uses.
landfix::tests::Drawing orientation_drawing(tiles::Codec codec) {
  landfix::tests::DrawnLayer layer = landfix::tests::small_bits(codec);
  layer.format = {tiles::PixelType::kBit, features::kOrientationPlanes, 1};
  // All pairs of levels in a row, and no data behind them.
  cv::Mat levels(1, 26, CV_8SC2, cv::Scalar::all(0)), valid(1, 26, CV_8U, cv::Scalar(255)), planes;
  for (int i = 0; i < 25; ++i) levels.at<cv::Vec<int8_t, 2>>(0, i) = {int8_t(i / 5 - 2), int8_t(i % 5 - 2)};
  valid.at<uint8_t>(0, 25) = 0;
  features::pack_orientation(levels, valid, planes);
  layer.pixel = [planes](const landfix::tests::PixelOf& p) {
    const cv::Vec<int8_t, 2> drawn = drawn_levels(p.column, p.row);
    const int i = drawn_valid(p) ? 5 * (drawn[0] + 2) + drawn[1] + 2 : 25;
    return planes.at<uint8_t>(p.channel, i / 8) >> (i % 8) & 1;
  };
  landfix::tests::Drawing drawing{.layers = {layer}};
  drawing.description.bounds = {kWestM, kSouthM, kEastM, kNorthM};
  return drawing;
}

TEST(PackMap, ReadsOrientationFromBitPlanes) {
  // Across the corner of four tiles, one of which is a hole, at an odd place and size; every level and hole as drawn.
  const landfix::tests::OpenPack pack(draw(orientation_drawing(tiles::Codec::kRaw)));
  ASSERT_EQ(pack.status(), LF_OK);
  const PackMap map(*pack);
  EXPECT_EQ(map.gsd_range_m(MapLayer::kOrientation), std::make_pair(1.0, 2.0));
  EXPECT_EQ(map.gsd_range_m(MapLayer::kGray), std::make_pair(0.0, 0.0));
  features::GridImage window;
  ASSERT_EQ(map.read(MapLayer::kOrientation, kWestM + 201, kSouthM + 197, kWestM + 700, kSouthM + 300, 1, window),
            nav::Status::kOk);
  ASSERT_EQ(window.pixels.type(), CV_8SC2);
  ASSERT_EQ(window.pixels.size(), cv::Size(499, 103));
  int known = 0, levels_seen = 0;
  for (int y = 0; y < window.pixels.rows; ++y)
    for (int x = 0; x < window.pixels.cols; ++x) {
      // Rows of the grid count southwards from the equator's side: northing 0 is row 0, the row north of it is -1.
      const auto column = int64_t(kWestM) + 201 + x, row = -(int64_t(kSouthM) + 300) + y;
      const char letter = landfix::tests::small_letter(column, row);
      const bool valid = letter != '.' && drawn_valid({letter, 0, column, row, 0});
      ASSERT_EQ(window.valid.at<uint8_t>(y, x), valid ? 255 : 0) << x << " " << y;
      const auto levels = window.pixels.at<cv::Vec<int8_t, 2>>(y, x);
      if (valid) {
        ASSERT_EQ(levels, drawn_levels(column, row)) << x << " " << y;
      } else {
        ASSERT_EQ(levels, (cv::Vec<int8_t, 2>(0, 0)));
      }
      known += valid;
      levels_seen |= 1 << (levels[0] + 2);
    }
  EXPECT_GT(known, 25000);
  EXPECT_EQ(levels_seen, 31);
  EXPECT_EQ(map.read(MapLayer::kOrientation, kWestM + 300, kSouthM + 50, kWestM + 400, kSouthM + 150, 1, window),
            nav::Status::kOutsideMap);
  EXPECT_EQ(map.read(MapLayer::kGray, kWestM, kSouthM, kWestM + 100, kSouthM + 100, 1, window), nav::Status::kNoLayer);
}

TEST(PackMap, ALayerOfAnotherKindIsNone) {
  // Four planes are the ternary code of other packs; two channels of gray are no gray.
  landfix::tests::Drawing drawing{.layers = {landfix::tests::small_bits()}};
  drawing.description.bounds = {kWestM, kSouthM, kEastM, kNorthM};
  const landfix::tests::OpenPack pack(draw(drawing));
  ASSERT_EQ(pack.status(), LF_OK);
  const PackMap map(*pack);
  EXPECT_EQ(map.gsd_range_m(MapLayer::kOrientation), std::make_pair(0.0, 0.0));
  features::GridImage window;
  EXPECT_EQ(map.read(MapLayer::kOrientation, kWestM, kSouthM, kWestM + 9, kSouthM + 9, 1, window),
            nav::Status::kNoLayer);
}

TEST(PackMap, ReadsHeightsAndSaysWhereNoneAreKnown) {
  // One tile of 512 m at 2 m, 500 m high and a metre more with every column; the lower half of it is unknown.
  landfix::tests::DrawnLayer layer;
  layer.name = "height";
  layer.format = {tiles::PixelType::kI16, 1, -32768};
  layer.value_offset = 500;
  layer.value_step = 0.5;
  layer.levels = {{1, landfix::tests::kWestX >> 1, landfix::tests::kSouthY >> 1, "a"}};
  layer.pixel = [](const landfix::tests::PixelOf& p) {
    return (p.row & 255) < 128 ? int(2 * (p.column & 255)) : -32768;
  };
  landfix::tests::Drawing drawing{.layers = {landfix::tests::small_gray(), layer}};
  drawing.description.bounds = {kWestM, kSouthM, kEastM, kNorthM};
  const landfix::tests::OpenPack pack(draw(drawing));
  ASSERT_EQ(pack.status(), LF_OK);
  const double west = (landfix::tests::kWestX >> 1) * 512.0, north = (landfix::tests::kSouthY >> 1) * 512.0 + 512;
  const PackMap map(*pack);
  features::GridImage heights;
  ASSERT_EQ(map.read_heights(west + 300, north - 300, west + 320, north - 200, 0.5, heights), nav::Status::kOk);
  EXPECT_EQ(heights.gsd_m, 2) << "the finest there is";
  EXPECT_EQ(heights.pixels.type(), CV_32FC1);
  EXPECT_EQ(heights.west_m, west + 300);
  EXPECT_EQ(heights.north_m, north - 200);
  ASSERT_EQ(heights.pixels.size(), cv::Size(10, 50));
  EXPECT_EQ(heights.pixels.at<float>(0, 0), 650);
  EXPECT_EQ(heights.pixels.at<float>(27, 9), 659) << "the last row above the middle, 256 m from the top";
  EXPECT_TRUE(std::isnan(heights.pixels.at<float>(28, 9)));
  EXPECT_EQ(map.read_heights(0, 0, 100, 100, 2, heights), nav::Status::kOutsideMap);
  EXPECT_EQ(map.read_heights(std::nan(""), 0, 100, 100, 2, heights), nav::Status::kMapError);
  const landfix::tests::OpenPack without(landfix::tests::small_pack());
  EXPECT_EQ(PackMap(*without).read_heights(kWestM, kSouthM, kEastM, kNorthM, 2, heights), nav::Status::kNoLayer);
}

TEST(PackMap, SaysWhenTheMapWasSeen) {
  // a and b show 2018 and 2014, c 2014 and 2009, d is undated, E does not say.
  landfix::tests::Drawing drawing{.layers = {landfix::tests::small_gray()}};
  exporter::PackDescription& d = drawing.description;
  d.bounds = {kWestM, kSouthM, kEastM, kNorthM};
  for (const char* name : {"2018.tif", "2014.tif", "2009.tif", "undated.tif"})
    d.sources.emplace_back().source.name = name;
  d.epochs = {{"2018-07-16", {0}}, {"2014-07-20", {1}}, {"2009-08-18", {2}}, {"", {3}}};
  drawing.layers[0].epochs = [](char letter) -> catalog::EpochSet {
    return letter == 'c'   ? catalog::EpochSet{1, 2}
           : letter == 'd' ? catalog::EpochSet{3}
           : letter == 'E' ? catalog::EpochSet{}
                           : catalog::EpochSet{0, 1};
  };
  const landfix::tests::OpenPack pack(draw(drawing));
  ASSERT_EQ(pack.status(), LF_OK);
  const PackMap map(*pack);
  const auto days = [&](double west, double south, double east, double north) {
    const std::optional<CaptureDays> c =
        map.capture_days(kWestM + west, kSouthM + south, kWestM + east, kSouthM + north);
    return c ? std::make_pair(c->oldest, c->newest) : std::make_pair(0, 0);
  };
  // Days since 1970-01-01, as `date -d 2018-07-16 +%s` / 86400 says.
  EXPECT_EQ(days(10, 300, 20, 310), std::make_pair(16271, 17728)) << "a";
  EXPECT_EQ(days(520, 300, 530, 310), std::make_pair(14474, 16271)) << "c";
  EXPECT_EQ(days(500, 300, 520, 310), std::make_pair(14474, 17728)) << "b and c";
  EXPECT_EQ(days(200, 10, 210, 20), std::make_pair(0, 0)) << "d: undated";
  EXPECT_EQ(days(10, 250, 20, 260), std::make_pair(0, 0)) << "a and d: part of it may be older than any date";
  EXPECT_EQ(days(520, 10, 530, 20), std::make_pair(0, 0)) << "E";
  EXPECT_EQ(days(300, 10, 400, 20), std::make_pair(0, 0)) << "a hole";
  EXPECT_EQ(days(-9000, 10, -8000, 20), std::make_pair(0, 0)) << "outside";
  const landfix::tests::OpenPack without(landfix::tests::small_pack());
  EXPECT_FALSE(PackMap(*without).capture_days(kWestM, kSouthM, kEastM, kNorthM));
}

TEST(PackMap, CarriesAFix) {
  // 768 × 512 m of texture at 1 m above a plane of 100 m; the aircraft is 20 m off and 150 m above it.
  const cv::Mat texture = testing::random_texture(1024, 1024, 21);
  landfix::tests::Drawing drawing{.layers = {landfix::tests::small_gray()}};
  drawing.layers[0].levels = {{0, landfix::tests::kWestX, landfix::tests::kSouthY, "abc\ndef"}};
  drawing.layers[0].pixel = [&](const landfix::tests::PixelOf& p) {
    return int(texture.at<uint8_t>(int(p.row & 1023), int(p.column & 1023)));
  };
  drawing.description.bounds = {kWestM, kSouthM, kEastM, kNorthM};
  drawing.description.plane_height_m = 100;
  const landfix::tests::OpenPack pack(landfix::tests::draw(drawing));
  ASSERT_EQ(pack.status(), LF_OK);
  const PackMap map(*pack);
  features::GridImage ground;
  ASSERT_EQ(map.read(MapLayer::kGray, kWestM, kSouthM, kEastM, kNorthM, 1, ground), nav::Status::kOk);

  const Camera camera = camera_from_field_of_view(240, 180, 1);
  const testing::Pose pose{kWestM + 400, kSouthM + 260, 150, {0.1, -0.05, 2}};
  Localizer localizer(map);
  ASSERT_EQ(localizer.start(pose.east_m + 16, pose.north_m - 12, 10), nav::Status::kOk);
  const Fix fix = localizer.update(testing::take_picture(ground, camera, pose), camera, pose.attitude, 250, 7);
  ASSERT_EQ(fix.status, nav::Status::kOk) << to_text(fix.status);
  EXPECT_EQ(fix.time_s, 7);
  EXPECT_EQ(fix.ground_height_m, 100);
  EXPECT_EQ(fix.gsd_m, 1);
  EXPECT_GT(fix.score, 0.9);
  EXPECT_LT(std::hypot(fix.east_m - pose.east_m, fix.north_m - pose.north_m), 0.3);
}

}  // namespace
}  // namespace landfix::nav
