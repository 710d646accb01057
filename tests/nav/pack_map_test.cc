// A pack as the map of the localizer: what is valid, what is not, and a fix on it.
#include "runtime/nav/pack_map.h"

#include <gtest/gtest.h>

#include <cmath>

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
  ASSERT_EQ(map.read(MapLayer::kGray, kWestM - 10, kSouthM - 10, kEastM + 10, kNorthM + 10, 1, window), nav::Status::kOk);
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
  ASSERT_EQ(map.read(MapLayer::kGray, kWestM + 10, kSouthM + 10, kWestM + 60, kSouthM + 50, 2, window), nav::Status::kOk);
  EXPECT_EQ(window.gsd_m, 2);
  EXPECT_TRUE(window.valid.empty());
  EXPECT_EQ(map.read(MapLayer::kGray, 0, 0, 100, 100, 1, window), nav::Status::kOutsideMap);
  EXPECT_EQ(map.read(MapLayer::kGray, kWestM + 300, kSouthM + 50, kWestM + 400, kSouthM + 150, 1, window),
            nav::Status::kOutsideMap);
  EXPECT_EQ(map.read(MapLayer::kGray, std::nan(""), 0, 100, 100, 1, window), nav::Status::kMapError);
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
