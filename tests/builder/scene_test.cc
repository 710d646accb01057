// The ray-traced scene: where things appear, how they are filtered, and what counts as data.
#include "builder/terrain/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "builder/error.h"

namespace landfix::terrain {
namespace {

using features::GridImage;

// Coordinates of a real UTM zone: floats alone would be wrong by half a metre here.
constexpr double kWest = 678'000, kNorth = 3'467'400, kGsd = 0.5;
constexpr int kSize = 800;

double degrees(double deg) { return deg * M_PI / 180; }

/// Ground that rises to the east by 10 % and to the north by 5 %.
double slope_height(double east, double north) { return 300 + 0.10 * (east - kWest) + 0.05 * (north - kNorth); }

GridImage slope() {
  GridImage heights{cv::Mat(kSize / 2, kSize / 2, CV_32FC1), {}, kWest, kNorth, 2 * kGsd};
  for (int y = 0; y < heights.pixels.rows; ++y) {
    for (int x = 0; x < heights.pixels.cols; ++x) {
      heights.pixels.at<float>(y, x) =
          float(slope_height(kWest + (x + 0.5) * heights.gsd_m, kNorth - (y + 0.5) * heights.gsd_m));
    }
  }
  return heights;
}

GridImage dark_ortho() { return {cv::Mat(kSize, kSize, CV_8UC1, cv::Scalar(20)), {}, kWest, kNorth, kGsd}; }

/// A bright spot with a radius of about three texels.
void draw_spot(GridImage& ortho, double east, double north) {
  const double column = ortho.column_of(east), row = ortho.row_of(north);
  for (int y = int(row) - 8; y <= int(row) + 9; ++y) {
    for (int x = int(column) - 8; x <= int(column) + 9; ++x) {
      const double r2 = (x - column) * (x - column) + (y - row) * (y - row);
      ortho.pixels.at<uchar>(y, x) = uchar(20 + 220 * std::exp(-r2 / 8) + 0.5);
    }
  }
}

cv::Point2d predicted(const nav::Camera& camera, const Pose& pose, double east, double north, double height) {
  const Eigen::Vector3d ray = nav::enu_from_camera(pose.attitude).transpose() *
                              Eigen::Vector3d(east - pose.east_m, north - pose.north_m, height - pose.height_m);
  return {camera.cx + camera.fx * ray.x() / ray.z(), camera.cy + camera.fy * ray.y() / ray.z()};
}

/// Centre of the light above the background within 25 px of a place.
cv::Point2d centroid(const cv::Mat& image, const cv::Point2d& about) {
  double sum = 0, sx = 0, sy = 0;
  for (int y = int(about.y) - 25; y <= int(about.y) + 25; ++y) {
    for (int x = int(about.x) - 25; x <= int(about.x) + 25; ++x) {
      const double light = std::max(0, image.at<uchar>(y, x) - 22);
      sum += light, sx += light * x, sy += light * y;
    }
  }
  EXPECT_GT(sum, 0) << "no spot near " << about;
  return {sx / sum, sy / sum};
}

TEST(Scene, WorldPointsAppearWhereTheCameraModelSaysWithAttitude) {
  const double points[][2] = {{200, -200}, {180, -175}, {225, -190}, {195, -235}};
  GridImage ortho = dark_ortho();
  for (const auto& p : points) draw_spot(ortho, kWest + p[0], kNorth + p[1]);
  const Scene scene(ortho, slope());
  const nav::Camera camera;
  const double east = kWest + 203, north = kNorth - 204;
  const Pose pose{east, north, slope_height(east, north) + 90, {degrees(4), degrees(-6), degrees(130)}};
  const Picture picture = scene.render(camera, pose);
  for (const auto& p : points) {
    const cv::Point2d expected =
        predicted(camera, pose, kWest + p[0], kNorth + p[1], slope_height(kWest + p[0], kNorth + p[1]));
    const cv::Point2d seen = centroid(picture.image, expected);
    // A spot of 1.5 m on the slope is seen slightly askew, which moves its centroid by up to 0.2 px.
    EXPECT_NEAR(seen.x, expected.x, 0.5);
    EXPECT_NEAR(seen.y, expected.y, 0.5);
  }
  EXPECT_EQ(cv::countNonZero(picture.valid), camera.width * camera.height);
}

TEST(Scene, RoofsLeanOutwardByTheReliefDisplacement) {
  // A roof 20 m above flat ground, seen from 100 m: a point 30 m to the right of nadir appears at f·30/80, not
  // f·30/100.
  GridImage heights{cv::Mat(kSize, kSize, CV_32FC1, cv::Scalar(50)), {}, kWest, kNorth, kGsd};
  heights.pixels(cv::Rect(430, 360, 80, 80)).setTo(70);
  GridImage ortho = dark_ortho();
  const double east = kWest + 200, north = kNorth - 200;
  draw_spot(ortho, east + 30, north);
  const Scene scene(ortho, heights);
  const nav::Camera camera;
  const Picture picture = scene.render(camera, {east, north, 150, {}});
  const cv::Point2d seen = centroid(picture.image, {camera.cx + 554.0 * 30 / 80, camera.cy});
  EXPECT_NEAR(seen.x - camera.cx, 207.75, 0.5);
  EXPECT_NEAR(seen.y - camera.cy, 0.0, 0.5);
}

TEST(Scene, HeadingTurnsThePictureClockwiseFromNorth) {
  GridImage ortho = dark_ortho();
  draw_spot(ortho, kWest + 200, kNorth - 170);  // 30 m north of the camera
  const Scene scene(ortho, 0.0);
  const nav::Camera camera;
  // Flying east, north is on the left: 30 m at 100 m are 166.2 px left of the middle.
  const Picture picture = scene.render(camera, {kWest + 200, kNorth - 200, 100, {0, 0, degrees(90)}});
  const cv::Point2d seen = centroid(picture.image, {camera.cx - 166.2, camera.cy});
  EXPECT_NEAR(seen.x - camera.cx, -166.2, 0.5);
  EXPECT_NEAR(seen.y - camera.cy, 0.0, 0.5);
}

TEST(Scene, LensDistortionMovesWhatItShows) {
  // 40 m east and 30 m north of the camera, 100 m up: r² = 0.25, so that k1 = -0.2 pulls the spot in by a factor of
  // 0.95, which is 13.85 px of the 277 px from the middle.
  GridImage ortho = dark_ortho();
  draw_spot(ortho, kWest + 240, kNorth - 170);
  const Scene scene(ortho, 0.0);
  nav::Camera camera;
  camera.distortion.k1 = -0.2;
  const Picture picture = scene.render(camera, {kWest + 200, kNorth - 200, 100, {}});
  const cv::Point2d seen = centroid(picture.image, {camera.cx + 0.95 * 221.6, camera.cy - 0.95 * 166.2});
  EXPECT_NEAR(seen.x - camera.cx, 0.95 * 221.6, 0.5);
  EXPECT_NEAR(seen.y - camera.cy, -0.95 * 166.2, 0.5);

  // With k1 = -0.7 the distortion turns back at r = 0.69, where it shows 0.46: pixels further than 255 px from the
  // middle see nothing.
  camera.distortion.k1 = -0.7;
  const Picture folded = scene.render(camera, {kWest + 200, kNorth - 200, 100, {}});
  EXPECT_NE(folded.valid.at<uchar>(240, 319 + 250), 0);
  EXPECT_EQ(folded.valid.at<uchar>(240, 319 + 260), 0);
}

TEST(Scene, FineTextureAveragesWhenSeenFromAbove) {
  // A checkerboard of single texels, pixels of 4 texels on the ground: its mean, 100, everywhere; without a pyramid the
  // picture would alternate between 0 and 200.
  GridImage ortho = dark_ortho();
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) ortho.pixels.at<uchar>(y, x) = (x + y) % 2 ? 200 : 0;
  }
  const Scene scene(ortho, 0.0);
  const nav::Camera camera{64, 64, 100, 100, 31.5, 31.5};
  const Picture picture = scene.render(camera, {kWest + 200, kNorth - 200, 2 * 100, {0, 0, 0.3}});
  double low, high;
  cv::minMaxLoc(picture.image, &low, &high);
  EXPECT_GE(low, 99);
  EXPECT_LE(high, 101);
}

TEST(Scene, MaskIsFalseOverHolesOfImageAndHeightsAndOutside) {
  GridImage ortho = dark_ortho();
  ortho.valid = cv::Mat(ortho.pixels.size(), CV_8UC1, cv::Scalar(255));
  ortho.valid(cv::Rect(420, 380, 20, 20)).setTo(0);  // 10...20 m east, 0...10 m north of the camera
  GridImage heights{cv::Mat(kSize, kSize, CV_32FC1, cv::Scalar(0)), {}, kWest, kNorth, kGsd};
  heights.pixels(cv::Rect(360, 400, 20, 20)).setTo(std::numeric_limits<float>::quiet_NaN());  // -20...-10 m, -10...0 m
  const Scene scene(ortho, heights);
  const nav::Camera camera;
  const Picture picture = scene.render(camera, {kWest + 200, kNorth - 200, 100, {}});
  const auto valid_at = [&](double east, double north) {
    return picture.valid.at<uchar>(cvRound(camera.cy - 5.54 * north), cvRound(camera.cx + 5.54 * east)) != 0;
  };
  EXPECT_FALSE(valid_at(15, 5));
  EXPECT_FALSE(valid_at(-15, -5));
  EXPECT_TRUE(valid_at(9, 5));
  EXPECT_TRUE(valid_at(21, 5));
  EXPECT_TRUE(valid_at(-15, 1));
  EXPECT_TRUE(valid_at(-21.5, -5));
  EXPECT_EQ(cv::countNonZero(picture.image == 0), cv::countNonZero(picture.valid == 0));

  // 180 m further east the image ends 20 m from the camera: 20·5.54 px right of the middle.
  const Picture edge = scene.render(camera, {kWest + 380, kNorth - 200, 100, {}});
  EXPECT_NE(edge.valid.at<uchar>(240, 319 + 105), 0);
  EXPECT_EQ(edge.valid.at<uchar>(240, 319 + 116), 0);
}

TEST(Scene, HeightBelowIsThatOfTheSurface) {
  const Scene scene(dark_ortho(), slope());
  for (const auto& [x, y] : {std::pair{10.0, 20.0}, {200.25, 133.3}, {390.0, 380.0}}) {
    const auto height = scene.height_below(kWest + x, kNorth - y);
    ASSERT_TRUE(height);
    EXPECT_NEAR(*height, slope_height(kWest + x, kNorth - y), 1e-3);  // a plane is interpolated exactly
  }
  EXPECT_FALSE(scene.height_below(kWest - 5, kNorth - 20));
  EXPECT_NEAR(*Scene(dark_ortho(), 77.0).height_below(kWest + 1, kNorth - 1), 77.0, 1e-4);
}

TEST(Scene, RefusesWhatItCannotDrape) {
  EXPECT_THROW(Scene(GridImage{}, 0.0), Error);
  EXPECT_THROW(Scene(GridImage{cv::Mat(4, 4, CV_16UC1), {}, 0, 4, 1}, 0.0), Error);
  GridImage empty{cv::Mat(4, 4, CV_32FC1, cv::Scalar(std::nan(""))), {}, 0, 4, 1};
  EXPECT_THROW(Scene(dark_ortho(), empty), Error);
}

}  // namespace
}  // namespace landfix::terrain
