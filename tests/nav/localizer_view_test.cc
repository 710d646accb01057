// What the localizer makes of a view: relief under an oblique camera, a heading that is off, parts of the image that
// show the airframe, colours and their order.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "runtime/nav/localizer.h"
#include "tests/nav/relief_scene.h"
#include "tests/nav/scene.h"

namespace landfix::nav {
namespace {

using features::GridImage;
using testing::GrayMap;
using testing::Pose;

constexpr double kDegree = 0.017453292519943295;

double error_m(const Fix& fix, double east_m, double north_m) {
  return std::hypot(fix.east_m - east_m, fix.north_m - north_m);
}

// ---- relief

/// 500 m of texture at 0.5 m.
const GridImage& texture() {
  static const GridImage g{testing::random_texture(1000, 1000, 41), {}, -250, 250, 0.5};
  return g;
}

/// A valley side that rises to the north by 1 in 4, with hills of ±8 m every 120 m.
double hillside_m(double east_m, double north_m) {
  return 300 + 0.25 * north_m + 8 * std::sin(east_m / 19) * std::cos(north_m / 19);
}

double shade(double east_m, double north_m) {
  const double column = texture().column_of(east_m), row = texture().row_of(north_m);
  if (!(column >= 0 && row >= 0 && column < 999 && row < 999)) return 0;
  const int x = int(column), y = int(row);
  const double u = column - x, v = row - y;
  const auto at = [&](int dy, int dx) { return double(texture().pixels.at<uint8_t>(y + dy, x + dx)); };
  return (1 - v) * ((1 - u) * at(0, 0) + u * at(0, 1)) + v * ((1 - u) * at(1, 0) + u * at(1, 1));
}

const testing::ReliefScene kHillside{hillside_m, shade, 400};

/// The texture as a map with the ground's heights at 1 m. Without `tell_heights` only that of a point is known.
class HillsideMap : public GrayMap {
 public:
  HillsideMap() : GrayMap(texture(), 4, 0) {}
  std::optional<double> ground_height_m(double east_m, double north_m) const override {
    return hillside_m(east_m, north_m);
  }
  Status read_heights(double west_m, double south_m, double east_m, double north_m, double,
                      GridImage& heights) const override {
    if (!tell_heights) return Status::kNoLayer;
    const double half_m = std::ceil(0.5 * std::max(east_m - west_m, north_m - south_m));
    heights = kHillside.heights(0.5 * (west_m + east_m), 0.5 * (south_m + north_m), half_m, 1);
    return Status::kOk;
  }
  bool tell_heights = true;
};

TEST(LocalizerRelief, ObliqueViewsOfAHillsideNeedItsHeights) {
  // From 80 m, 30° ahead: uphill the ground in the middle of the view is 12 m higher than below the aircraft and shows
  // 8 m from where a plane has it; downhill it is as much too near. Through the heights it is as over flat ground: a
  // pixel is 1 m, and of the relief only what 2 m of uncertainty blur is left.
  HillsideMap map;
  const Camera camera = camera_from_field_of_view(200, 150, 50 * kDegree);
  for (const double heading_deg : {0., 90., 180., 250.}) {
    SCOPED_TRACE(heading_deg);
    const Attitude attitude{3 * kDegree, 30 * kDegree, heading_deg * kDegree};
    const double height_m = hillside_m(10, -20) + 80;
    const cv::Mat image = kHillside.take_picture(camera, attitude, {10, -20, height_m});
    const auto fix = [&] {
      Localizer localizer(map);
      EXPECT_EQ(localizer.start(11.5, -22, 2), Status::kOk);
      return localizer.update(image, camera, attitude, height_m, 0);
    };
    map.tell_heights = true;
    const Fix with = fix();
    ASSERT_EQ(with.status, Status::kOk) << to_text(with.status);
    EXPECT_EQ(with.gsd_m, 1);
    EXPECT_LT(error_m(with, 10, -20), 0.5);
    EXPECT_GT(with.score, 0.9);
    EXPECT_GT(with.probability, 0.95);
    map.tell_heights = false;
    const Fix without = fix();
    EXPECT_GT(error_m(without, 10, -20), 1.5);
    EXPECT_LT(without.score, 0.8);
  }
}

TEST(LocalizerRelief, HolesInTheHeightsDoNotSpread) {
  // One height in a hundred is unknown. Blurred over the uncertain position, a hole must not take its neighbours with
  // it: none is farther than 7 m from one, and all would be gone.
  class Pierced : public HillsideMap {
    Status read_heights(double west_m, double south_m, double east_m, double north_m, double gsd_m,
                        GridImage& heights) const override {
      const Status s = HillsideMap::read_heights(west_m, south_m, east_m, north_m, gsd_m, heights);
      for (int y = 0; y < heights.pixels.rows; y += 10)
        for (int x = 0; x < heights.pixels.cols; x += 10)
          heights.pixels.at<float>(y, x) = std::numeric_limits<float>::quiet_NaN();
      return s;
    }
  };
  const Pierced map;
  const Camera camera = camera_from_field_of_view(200, 150, 50 * kDegree);
  const Attitude attitude{0, 30 * kDegree, 0};
  const double height_m = hillside_m(10, -20) + 80;
  const cv::Mat image = kHillside.take_picture(camera, attitude, {10, -20, height_m});
  Localizer localizer(map);
  ASSERT_EQ(localizer.start(11.5, -22, 2), Status::kOk);
  const Fix fix = localizer.update(image, camera, attitude, height_m, 0);
  ASSERT_EQ(fix.status, Status::kOk) << to_text(fix.status);
  EXPECT_LT(error_m(fix, 10, -20), 0.5);
  EXPECT_GT(fix.score, 0.85);
}

// ---- heading

/// 300 m of fields at 0.25 m, as one season shows them.
const GridImage& fields(uint64_t season = 0) {
  static const GridImage seasons[] = {testing::ground_of(testing::countryside(1200, 5, 0)),
                                      testing::ground_of(testing::countryside(1200, 5, 1))};
  return seasons[season];
}
/// All layers of the first season.
const ImageMap& fields_map() {
  static const ImageMap map(fields(), 4, 210);
  return map;
}
const Camera kCamera = camera_from_field_of_view(240, 180, 60 * kDegree);

class LocalizerHeading : public ::testing::TestWithParam<Method> {};
std::string name_of_case(const ::testing::TestParamInfo<Method>& info) { return name_of(info.param); }
INSTANTIATE_TEST_SUITE_P(Methods, LocalizerHeading, ::testing::ValuesIn(kMethods), name_of_case);

TEST_P(LocalizerHeading, HasAnUncertaintyThatHoldsTheTruth) {
  // Up to 5.5° off where 3° of sigma are told, straight down and 15° ahead. The patch is some 140 px wide: half a pixel
  // at its rim is 0.4°. Contours, truncated and rounded distances, tell less.
  const bool contour = GetParam() == Method::kContour;
  LocalizerOptions options;
  options.method = GetParam();
  options.heading_sigma_rad = 3 * kDegree;
  for (const double off_deg : {-5.5, -3.7, -1.2, 0.4, 2.3, 4.6}) {
    SCOPED_TRACE(off_deg);
    const Pose truth{6 * off_deg, 10, 60, {0, off_deg > 0 ? 15 * kDegree : 0, (70 + off_deg) * kDegree}};
    const cv::Mat image = testing::take_picture(fields(), kCamera, truth);
    Localizer localizer(fields_map(), options);
    ASSERT_EQ(localizer.start(truth.east_m + 4, truth.north_m - 3, 5), Status::kOk);
    const Fix fix = localizer.update(image, kCamera, {0, truth.attitude.pitch, 70 * kDegree}, 270, 0);
    ASSERT_EQ(fix.status, Status::kOk) << to_text(fix.status);
    EXPECT_LT(error_m(fix, truth.east_m, truth.north_m), contour ? 0.8 : 0.3);
    EXPECT_LT(std::abs(fix.rotation_rad - off_deg * kDegree), 3 * fix.rotation_sigma_rad);
    EXPECT_LT(fix.rotation_sigma_rad, (contour ? 0.6 : 0.3) * kDegree);
  }
}

// ---- what of the image votes

TEST(LocalizerMask, WhatItCoversDoesNotMatter) {
  // Two skids: noise, glare, and, worst, ground from 12 m to the east, which would agree with a wrong place.
  Camera camera = kCamera;
  camera.mask = cv::Mat(180, 240, CV_8U, cv::Scalar(255));
  const cv::Rect skids[] = {{0, 110, 90, 70}, {150, 110, 90, 70}};
  for (const cv::Rect& skid : skids) camera.mask(skid).setTo(0);
  const cv::Mat world = testing::take_picture(fields(), camera, {5, 7, 60, {}});
  cv::Mat noise(world.size(), CV_8UC3);
  cv::RNG(8).fill(noise, cv::RNG::UNIFORM, 0, 256);
  const cv::Mat glare(world.size(), CV_8UC3, cv::Scalar::all(255));
  const cv::Mat elsewhere = testing::take_picture(fields(), camera, {17, 7, 60, {}});
  for (const std::optional<Method> method : {std::optional<Method>(), std::optional(Method::kGray),
                                             std::optional(Method::kEdge), std::optional(Method::kContour)}) {
    SCOPED_TRACE(method ? name_of(*method) : "auto");
    LocalizerOptions options;
    options.method = method;
    const auto look = [&](const cv::Mat& covered) {
      cv::Mat image = world.clone();
      for (const cv::Rect& skid : skids) covered(skid).copyTo(image(skid));
      Localizer localizer(fields_map(), options);
      EXPECT_EQ(localizer.start(8, 4, 5), Status::kOk);
      return localizer.update(image, camera, {}, 270, 0);
    };
    const Fix clean = look(world);
    ASSERT_EQ(clean.status, Status::kOk) << to_text(clean.status);
    EXPECT_LT(error_m(clean, 5, 7), 0.3);
    for (const cv::Mat& covered : {noise, glare, elsewhere}) {
      const Fix fix = look(covered);
      ASSERT_EQ(fix.status, Status::kOk);
      EXPECT_EQ(fix.east_m, clean.east_m);
      EXPECT_EQ(fix.north_m, clean.north_m);
      EXPECT_EQ(fix.score, clean.score);
      EXPECT_EQ(fix.probability, clean.probability);
      EXPECT_EQ(fix.covariance_m2, clean.covariance_m2);
    }
  }
}

// ---- colours

cv::Mat gray_of(const cv::Mat& rgb) {
  cv::Mat gray;
  cv::cvtColor(rgb, gray, cv::COLOR_RGB2GRAY);
  return gray;
}

/// The fields without their differences in lightness, but where a colour would leave the range: colours alone tell them
/// apart.
GridImage level_in_lightness(const GridImage& image) {
  cv::Mat lightness, out;
  cv::cvtColor(gray_of(image.pixels), lightness, cv::COLOR_GRAY2RGB);
  cv::addWeighted(image.pixels, 1, lightness, -1, 125, out);
  return {out, {}, image.west_m, image.north_m, image.gsd_m};
}

TEST(LocalizerColour, TellsWhatGrayDoesNot) {
  // Another season, fields equally light, narrow views (30 m): gray finds next to nothing, colour all.
  const GridImage summer = level_in_lightness(fields(0)), winter = level_in_lightness(fields(1));
  const ImageMap map(summer, 4, 210, std::span(&kMapLayers[3], 1));
  const Camera camera = camera_from_field_of_view(160, 160, 34 * kDegree);
  LocalizerOptions options;
  options.method = Method::kOrientation;
  int colour_hits = 0, gray_hits = 0;
  double colour_sum = 0, gray_sum = 0;
  for (int i = 0; i < 8; ++i) {
    const Pose pose{-75 + 50. * (i % 4), -50 + 90. * (i / 4), 50, {0, 0, 0.4 * i}};
    const cv::Mat image = testing::take_picture(winter, camera, pose);
    const auto look = [&](const cv::Mat& picture, int& hits, double& sum) {
      Localizer localizer(map, options);
      EXPECT_EQ(localizer.start(pose.east_m + 9, pose.north_m - 7, 8), Status::kOk);
      const Fix fix = localizer.update(picture, camera, pose.attitude, 260, 0);
      EXPECT_EQ(fix.status, Status::kOk) << to_text(fix.status);
      hits += error_m(fix, pose.east_m, pose.north_m) < 1;
      sum += fix.probability;
    };
    look(image, colour_hits, colour_sum);
    look(gray_of(image), gray_hits, gray_sum);
  }
  EXPECT_EQ(colour_hits, 8);
  EXPECT_GT(colour_sum, 7.7);
  EXPECT_LE(gray_hits, 4);
  EXPECT_LT(gray_sum, 4) << "and says so";
}

TEST(LocalizerColour, IsRedGreenBlue) {
  // What OpenCV reads from a file is blue, green, red: so given, its luma weighs red and blue the wrong way round.
  // Where red and blue differ as they do on these fields, only the right order agrees with the map's gray values.
  LocalizerOptions options;
  options.method = Method::kGray;
  const Pose pose{5, 7, 60, {}};
  const cv::Mat rgb = testing::take_picture(fields(), kCamera, pose);
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  const auto score = [&](const cv::Mat& image) {
    Localizer localizer(fields_map(), options);
    EXPECT_EQ(localizer.start(8, 4, 5), Status::kOk);
    return localizer.update(image, kCamera, {}, 270, 0).score;
  };
  EXPECT_GT(score(rgb), 0.95);
  EXPECT_NEAR(score(rgb), score(gray_of(rgb)), 0.01);
  EXPECT_LT(score(bgr), score(rgb) - 0.05);
}

}  // namespace
}  // namespace landfix::nav
