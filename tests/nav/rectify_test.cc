// Rectification against a scene whose gray value is known everywhere.
#include "runtime/nav/rectify.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "tests/nav/scene.h"

namespace landfix::nav {
namespace {

using features::GridImage;
using testing::Pose;

constexpr double kDegree = 0.017453292519943295;

double gray_at(double east_m, double north_m) {
  return 128 + 60 * std::sin(east_m / 7) + 50 * std::cos(north_m / 5 + 1);
}

/// 400 m of it around the origin, 0.1 m apart.
GridImage wavy_ground() {
  GridImage ground{cv::Mat(4000, 4000, CV_8U), {}, -200, 200, 0.1};
  for (int y = 0; y < 4000; ++y)
    for (int x = 0; x < 4000; ++x)
      ground.pixels.at<uint8_t>(y, x) = uint8_t(std::lround(gray_at(-200 + (x + 0.5) * 0.1, 200 - (y + 0.5) * 0.1)));
  return ground;
}

Status rectify_default(const cv::Mat& image, const Camera& camera, const Attitude& attitude, double height_m,
                       double gsd_m) {
  GridImage patch;
  return rectify(image, camera, attitude, height_m, gsd_m, patch);
}

TEST(Rectify, ShowsTheGroundWhereItIsForAnyAttitude) {
  const GridImage ground = wavy_ground();
  const Camera camera = camera_from_field_of_view(320, 240, 60 * kDegree);
  const Attitude attitudes[] = {{0, 0, 0},        {0, 0, 1},         {0.3, 0, 0},           {0, -0.25, 0},
                                {0.2, 0.15, 2.5}, {-0.1, 0.3, -1.2}, {0.02, -0.03, 3.14159}};
  for (const Attitude& attitude : attitudes) {
    const cv::Mat image = testing::take_picture(ground, camera, {3.3, -2.2, 60, attitude});
    GridImage patch;
    ASSERT_EQ(rectify(image, camera, attitude, 60, 0.5, patch), Status::kOk);
    EXPECT_EQ(std::remainder(patch.west_m, 0.5), 0);
    EXPECT_EQ(std::remainder(patch.north_m, 0.5), 0);
    double worst = 0;
    for (int y = 0; y < patch.pixels.rows; ++y)
      for (int x = 0; x < patch.pixels.cols; ++x)
        if (patch.valid.at<uint8_t>(y, x)) {
          const double expected = gray_at(3.3 + patch.west_m + (x + 0.5) * 0.5, -2.2 + patch.north_m - (y + 0.5) * 0.5);
          worst = std::max(worst, std::abs(patch.pixels.at<uint8_t>(y, x) - expected));
        }
    // Rounding to 8 bits twice and bilinear interpolation cost 1 to 2 levels; half a pixel off would cost 0.25 m · 10
    // levels/m = 2.5.
    EXPECT_LT(worst, 2.5) << "roll " << attitude.roll << " pitch " << attitude.pitch << " heading " << attitude.heading;
  }
}

TEST(Rectify, MarksTheFootprintAndNothingElse) {
  // 60° across 320 pixels at 60 m: 69.28 m wide, 51.96 m high; the inside of its outline at 0.5 m is 136.6 × 101.9
  // pixels.
  const Camera camera = camera_from_field_of_view(320, 240, 60 * kDegree);
  const cv::Mat image(240, 320, CV_8U, cv::Scalar(7));
  for (double heading : {0.0, 0.5, 2.0}) {
    GridImage patch;
    ASSERT_EQ(rectify(image, camera, {0, 0, heading}, 60, 0.5, patch), Status::kOk);
    EXPECT_NEAR(cv::countNonZero(patch.valid), 137.15 * 102.51, 0.005 * 137.15 * 102.51);
    double lowest, highest;
    cv::minMaxLoc(patch.pixels, &lowest, &highest, nullptr, nullptr, patch.valid);
    EXPECT_EQ(lowest, 7);
    EXPECT_EQ(highest, 7);
  }
}

TEST(Rectify, AveragesWhatIsFinerThanThePatch) {
  // Stripes two image pixels apart; a patch pixel covers many: all must come out gray, where sampling would show beats
  // of 0 and 255.
  const Camera camera = camera_from_field_of_view(640, 480, 60 * kDegree);
  cv::Mat image(480, 640, CV_8U);
  for (int x = 0; x < 640; ++x) image.col(x).setTo(x % 2 ? 255 : 0);
  for (double gsd_m : {0.5, 1.0, 4.0}) {
    GridImage patch;
    ASSERT_EQ(rectify(image, camera, {0, 0, 0.3}, 60, gsd_m, patch), Status::kOk);
    double lowest, highest;
    cv::minMaxLoc(patch.pixels, &lowest, &highest, nullptr, nullptr, patch.valid);
    EXPECT_GT(lowest, 90) << gsd_m;
    EXPECT_LT(highest, 165) << gsd_m;
  }
}

TEST(Rectify, LooksNoFartherThanThreeHeights) {
  const Camera camera = camera_from_field_of_view(320, 240, 60 * kDegree);
  const cv::Mat image(240, 320, CV_8U, cv::Scalar(100));
  GridImage patch;
  // Pitched up by 70°, the image spans 47° to 93° from straight down: beyond the horizon at its top.
  ASSERT_EQ(rectify(image, camera, {0, 70 * kDegree, 0}, 50, 1, patch), Status::kOk);
  double nearest = 1e9, farthest = 0;
  for (int y = 0; y < patch.valid.rows; ++y)
    for (int x = 0; x < patch.valid.cols; ++x)
      if (patch.valid.at<uint8_t>(y, x)) {
        const double distance = std::hypot(patch.west_m + x + 0.5, patch.north_m - y - 0.5);
        nearest = std::min(nearest, distance);
        farthest = std::max(farthest, distance);
      }
  EXPECT_LE(farthest, 150);
  EXPECT_GT(farthest, 147);
  EXPECT_NEAR(nearest, 50 * std::tan((70 - 23.4) * kDegree), 3);
  EXPECT_GT(patch.north_m, 100);  // forward is north
  EXPECT_EQ(rectify_default(image, camera, {0, 120 * kDegree, 0}, 50, 1), Status::kNothingVisible);
}

/// The wavy ground through a lens: every pixel's ray, found by Newton's method, against the patch's way round.
cv::Mat wavy_picture(const Camera& camera, const Attitude& attitude, double height_m) {
  const Lens lens(camera);
  const Eigen::Matrix3d enu = enu_from_camera(attitude);
  cv::Mat image = cv::Mat::zeros(camera.height, camera.width, CV_8U);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      Eigen::Vector3d in_camera;
      if (!lens.ray_of({double(x), double(y)}, in_camera)) continue;
      const Eigen::Vector3d ray = enu * in_camera, p = ray * height_m / -ray.z();
      image.at<uint8_t>(y, x) = uint8_t(std::lround(gray_at(p.x(), p.y())));
    }
  return image;
}

TEST(Rectify, TakesTheDistortionOutInTheSameStep) {
  Camera camera = camera_from_field_of_view(320, 240, 60 * kDegree);
  for (const Distortion& lens : {Distortion{-0.28, 0.07, 0.001, -0.0005, 0}, Distortion{0.12, -0.05, 0, 0.002, 0.01}}) {
    camera.distortion = lens;
    for (const Attitude& attitude : {Attitude{0, 0, 0.4}, Attitude{0.2, 0.15, 2.5}}) {
      GridImage patch;
      ASSERT_EQ(rectify(wavy_picture(camera, attitude, 60), camera, attitude, 60, 0.5, patch), Status::kOk);
      EXPECT_GT(cv::countNonZero(patch.valid), 11000);
      double worst = 0;
      for (int y = 0; y < patch.pixels.rows; ++y)
        for (int x = 0; x < patch.pixels.cols; ++x)
          if (patch.valid.at<uint8_t>(y, x)) {
            const double expected = gray_at(patch.west_m + (x + 0.5) * 0.5, patch.north_m - (y + 0.5) * 0.5);
            worst = std::max(worst, std::abs(patch.pixels.at<uint8_t>(y, x) - expected));
          }
      EXPECT_LT(worst, 2.5) << lens.k1;  // as without distortion; without its removal the corners are 4 m off
    }
  }
}

TEST(Rectify, ShowsNothingFromBeyondTheLensFold) {
  // 110° across with k1 = −0.4: the fold, r = 0.9129, lies at 102 of 160 pixels from the centre, and no ray meets a
  // pixel farther out. Seen is the disc of 60 · 0.9129 = 54.8 m around the camera, or of 52 m without its thin rim that
  // the patch's half pixel and the side of the image leave out.
  Camera camera = camera_from_field_of_view(320, 240, 110 * kDegree);
  camera.distortion = {-0.4};
  const cv::Mat image = wavy_picture(camera, {}, 60);
  GridImage patch;
  ASSERT_EQ(rectify(image, camera, {}, 60, 0.5, patch), Status::kOk);
  const double fold_m = 60 * 0.91287;
  int valid = 0;
  for (int y = 0; y < patch.pixels.rows; ++y)
    for (int x = 0; x < patch.pixels.cols; ++x)
      if (patch.valid.at<uint8_t>(y, x)) {
        ++valid;
        EXPECT_LE(std::hypot(patch.west_m + (x + 0.5) * 0.5, patch.north_m - (y + 0.5) * 0.5), fold_m);
      }
  EXPECT_NEAR(valid, M_PI * fold_m * fold_m / 0.25, 0.02 * valid);
}

TEST(Rectify, KeepsColoursInTheirOrder) {
  const Camera camera = camera_from_field_of_view(320, 240, 60 * kDegree);
  for (int bands : {3, 4}) {
    const cv::Mat image(240, 320, CV_8UC(bands), cv::Scalar(200, 100, 50, 25));
    for (const Distortion& lens : {Distortion{}, Distortion{-0.1}}) {
      Camera bent = camera;
      bent.distortion = lens;
      GridImage patch;
      ASSERT_EQ(rectify(image, bent, {0, 0, 0.3}, 60, 1, patch), Status::kOk);
      ASSERT_EQ(patch.pixels.type(), CV_8UC(bands));
      const cv::Scalar mean = cv::mean(patch.pixels, patch.valid);
      for (int band = 0; band < bands; ++band) EXPECT_NEAR(mean[band], 200 / (1 << band), 1e-9);
    }
  }
}

TEST(Rectify, LeavesOutItsOwnAirframe) {
  // A skid across the lower quarter of the image, rows 180 to 239, drawn white; the rest of the scene is dark.
  Camera camera = camera_from_field_of_view(320, 240, 60 * kDegree);
  cv::Mat image(240, 320, CV_8U, cv::Scalar(10));
  image.rowRange(180, 240).setTo(255);
  camera.mask = image < 128;
  for (double gsd_m : {0.25, 0.5, 2.0}) {
    GridImage patch;
    ASSERT_EQ(rectify(image, camera, {0, 0, 0}, 60, gsd_m, patch), Status::kOk);
    double highest;
    cv::minMaxLoc(patch.pixels, nullptr, &highest, nullptr, nullptr, patch.valid);
    EXPECT_EQ(highest, 10) << gsd_m;
    // The skid begins 60 rows below the middle: 13.0 m south of the camera. Nothing else is lost.
    const double south_m = patch.north_m - patch.valid.rows * gsd_m;
    EXPECT_NEAR(south_m, -60 * 60 / camera.fy, 1.5 * gsd_m + 3 * 60 / camera.fy);
  }
}

TEST(Rectify, RefusesWhatItCannotUse) {
  const Camera camera = camera_from_field_of_view(64, 48, 1);
  const cv::Mat image(48, 64, CV_8U, cv::Scalar(1));
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(rectify_default(image, camera, {nan, 0, 0}, 50, 1), Status::kNotFinite);
  EXPECT_EQ(rectify_default(image, camera, {0, inf, 0}, 50, 1), Status::kNotFinite);
  EXPECT_EQ(rectify_default(image, camera, {0, 0, nan}, 50, 1), Status::kNotFinite);
  EXPECT_EQ(rectify_default(image, camera, {}, nan, 1), Status::kNotFinite);
  EXPECT_EQ(rectify_default(image, camera, {}, 50, inf), Status::kNotFinite);
  EXPECT_EQ(rectify_default(image, camera, {}, 50, 0), Status::kBadValue);
  EXPECT_EQ(rectify_default(image, camera, {}, 0, 1), Status::kBelowGround);
  EXPECT_EQ(rectify_default(image, camera, {}, -3, 1), Status::kBelowGround);
  EXPECT_EQ(rectify_default(image, camera, {}, 50, 1e-4), Status::kTooLarge);
  EXPECT_EQ(rectify_default({}, camera, {}, 50, 1), Status::kBadImage);
  EXPECT_EQ(rectify_default(cv::Mat(48, 64, CV_16U), camera, {}, 50, 1), Status::kBadImage);
  EXPECT_EQ(rectify_default(cv::Mat(48, 64, CV_8UC(5)), camera, {}, 50, 1), Status::kBadImage);
  EXPECT_EQ(rectify_default(cv::Mat(48, 63, CV_8U), camera, {}, 50, 1), Status::kBadImage);
  Camera broken = camera;
  broken.fx = 0;
  EXPECT_EQ(rectify_default(image, broken, {}, 50, 1), Status::kBadValue);
  broken = camera;
  broken.mask = cv::Mat::ones(48, 63, CV_8U);
  EXPECT_EQ(rectify_default(image, broken, {}, 50, 1), Status::kBadImage);
  broken = camera;
  broken.mask = cv::Mat::zeros(48, 64, CV_8U);
  EXPECT_EQ(rectify_default(image, broken, {}, 50, 1), Status::kNothingVisible);
}

}  // namespace
}  // namespace landfix::nav
