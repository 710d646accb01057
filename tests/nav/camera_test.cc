// The lens: OpenCV's distortion model forwards and backwards, and where it must not be believed.
#include "runtime/nav/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>

namespace landfix::nav {
namespace {

constexpr double kDegree = 0.017453292519943295;

Camera with(const Distortion& d) {
  Camera camera = camera_from_field_of_view(640, 480, 80 * kDegree);
  camera.distortion = d;
  return camera;
}

const Distortion kLenses[] = {{},
                              {-0.28, 0.07, 0.001, -0.0005, 0},
                              {0.12, -0.05, 0, 0.002, 0.01},
                              {-0.2, 0.05, -0.001, 0.001, 0.01, 0.02, -0.01, 0.005}};

TEST(Lens, ProjectsAsOpenCvDoes) {
  for (const Distortion& d : kLenses) {
    const Camera camera = with(d);
    const Lens lens(camera);
    const cv::Matx33d matrix(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
    const cv::Mat coefficients = (cv::Mat_<double>(1, 8) << d.k1, d.k2, d.p1, d.p2, d.k3, d.k4, d.k5, d.k6);
    for (double x = -0.8; x <= 0.81; x += 0.2) {
      for (double y = -0.6; y <= 0.61; y += 0.2) {
        std::vector<cv::Point2d> expected;
        cv::projectPoints(std::vector<cv::Point3d>{{3 * x, 3 * y, 3}}, cv::Vec3d(), cv::Vec3d(), matrix, coefficients,
                          expected);
        Eigen::Vector2d pixel;
        ASSERT_TRUE(lens.pixel_of({3 * x, 3 * y, 3}, pixel));
        EXPECT_NEAR(pixel.x(), expected[0].x, 1e-9);
        EXPECT_NEAR(pixel.y(), expected[0].y, 1e-9);
      }
    }
  }
}

TEST(Lens, FindsTheRayOfEveryPixelOfOrdinaryLenses) {
  for (const Distortion& d : kLenses) {
    const Camera camera = with(d);
    const Lens lens(camera);
    for (int y = -20; y <= 500; y += 20) {
      for (int x = -20; x <= 660; x += 20) {
        Eigen::Vector3d ray;
        Eigen::Vector2d back;
        ASSERT_TRUE(lens.ray_of({double(x), double(y)}, ray)) << x << ' ' << y;
        ASSERT_TRUE(lens.pixel_of(ray, back));
        EXPECT_NEAR(back.x(), x, 1e-6);
        EXPECT_NEAR(back.y(), y, 1e-6);
      }
    }
  }
}

TEST(Lens, SeesNothingBeyondItsFold) {
  // r (1 − 0.4 r²) grows up to r = 1 / √1.2 = 0.91287, where it reaches 0.60858, and turns back: the ray at r = 1.3
  // would fall on 0.4212, into the middle of the picture.
  const Camera camera = with({-0.4});
  const Lens lens(camera);
  EXPECT_NEAR(lens.fold_radius(), 1 / std::sqrt(1.2), 1e-8);
  Eigen::Vector2d pixel;
  Eigen::Vector3d ray;
  EXPECT_TRUE(lens.pixel_of({0.9, 0, 1}, pixel));
  EXPECT_FALSE(lens.pixel_of({0.93, 0, 1}, pixel));
  EXPECT_FALSE(lens.pixel_of({0, 1.3, 1}, pixel));
  EXPECT_TRUE(lens.ray_of({camera.cx + 0.6085 * camera.fx, camera.cy}, ray));
  EXPECT_LT(ray.x(), 0.91287);
  EXPECT_FALSE(lens.ray_of({camera.cx + 0.6087 * camera.fx, camera.cy}, ray));
  // A pole of the rational model: the denominator 1 − r² vanishes at r = 1.
  EXPECT_NEAR(Lens(with({0, 0, 0, 0, 0, -1})).fold_radius(), 1, 1e-8);
  // Tangential terms fold on one side sooner: along x, x + 3 p2 x² turns at x = −1 / (6 p2).
  EXPECT_NEAR(Lens(with({0, 0, 0, 0.2})).fold_radius(), 1 / 1.2, 1e-6);
  EXPECT_EQ(Lens(with({0.1, 0.1})).fold_radius(), std::numeric_limits<double>::infinity());
}

TEST(Lens, SeesNothingBehindTheCamera) {
  Eigen::Vector2d pixel;
  EXPECT_FALSE(Lens(with({})).pixel_of({0, 0, -1}, pixel));
  EXPECT_FALSE(Lens(with({})).pixel_of({1, 0, 0}, pixel));
}

TEST(CameraCheck, NamesWhatIsWrong) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(check(with({})), Status::kOk);
  EXPECT_EQ(check(with({nan})), Status::kNotFinite);
  EXPECT_EQ(check(with({0, 0, 0, 0, 0, 0, 0, nan})), Status::kNotFinite);
  Camera camera = with({});
  camera.fy = -1;
  EXPECT_EQ(check(camera), Status::kBadValue);
  camera = with({});
  camera.mask = cv::Mat::ones(480, 639, CV_8UC1);
  EXPECT_EQ(check(camera), Status::kBadImage);
  camera.mask = cv::Mat::ones(480, 640, CV_8UC3);
  EXPECT_EQ(check(camera), Status::kBadImage);
}

TEST(AttitudeFromRotation, InvertsTheRotation) {
  for (const Attitude& a : {Attitude{0, 0, 0}, {0.3, -0.7, 2.9}, {-3, 1.2, -3}, {1.7, -1.5, 0.1}}) {
    const Attitude back = attitude_from(ned_from_body(a));
    EXPECT_NEAR(back.roll, a.roll, 1e-9);
    EXPECT_NEAR(back.pitch, a.pitch, 1e-9);
    EXPECT_NEAR(back.heading, a.heading, 1e-9);
  }
  // Nose straight up: roll and heading turn about the same axis; the rotation is what must come back.
  const Eigen::Matrix3d up = ned_from_body({0.4, 90 * kDegree, 1.0});
  EXPECT_LT((ned_from_body(attitude_from(up)) - up).norm(), 1e-9);
  EXPECT_EQ(attitude_from(up).roll, 0);
}

}  // namespace
}  // namespace landfix::nav
