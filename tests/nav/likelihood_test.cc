// The likelihood against its formula, and its honesty on flat, ambiguous and partly unknown surfaces.
#include "runtime/nav/likelihood.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace landfix::nav {
namespace {

using features::GridImage;

GridImage surface_of(const cv::Mat& ncc) { return {ncc, cv::Mat(ncc.size(), CV_8U, cv::Scalar(255)), 100, 200, 0.5}; }

GridImage flat_surface(int width, int height, float value) {
  return surface_of(cv::Mat(height, width, CV_32F, cv::Scalar(value)));
}

TEST(Likelihood, FollowsTheConcentratedGaussian) {
  // log L1/L2 = −N/2 log((1 − 0.5²)/(1 − 0.4²)) = 20·log(0.84/0.75) = 2.267 for N = 40: a ratio of 9.65.
  GridImage surface = flat_surface(9, 7, -0.3f);
  surface.pixels.at<float>(3, 4) = 0.5f;
  surface.pixels.at<float>(5, 2) = 0.4f;
  Likelihood l;
  ASSERT_EQ(likelihood_from_ncc(surface, {40, 0, 1e-9}, l), Status::kOk);
  EXPECT_NEAR(l.values.pixels.at<float>(3, 4) / l.values.pixels.at<float>(5, 2), 9.646, 0.01);
  // Contrast reversal is as good as no correlation: (1 − 0.4²)^−20 = 32.7 times below the second.
  EXPECT_NEAR(l.values.pixels.at<float>(5, 2) / l.values.pixels.at<float>(0, 0), 32.69, 0.05);
  EXPECT_NEAR(cv::mean(l.values.pixels)[0], 1, 1e-5);
  EXPECT_EQ(l.values.west_m, 100);
  EXPECT_EQ(l.values.north_m, 200);
  EXPECT_EQ(l.values.gsd_m, 0.5);
}

TEST(Likelihood, SaysNothingWhereTheSurfaceSaysNothing) {
  for (float value : {-0.5f, 0.0f, 0.8f}) {
    Likelihood l;
    ASSERT_EQ(likelihood_from_ncc(flat_surface(30, 20, value), {200, 2, 0.02}, l), Status::kOk);
    EXPECT_LT(cv::norm(l.values.pixels - 1.0, cv::NORM_INF), 1e-5) << value;
  }
}

TEST(Likelihood, IsAsWideAsThePositionError) {
  // A peak of one pixel, 0.5 m, blurred with 2 m: variance 4 m², and no correlation between the axes.
  GridImage surface = flat_surface(81, 81, 0);
  surface.pixels.at<float>(40, 40) = 0.95f;
  Likelihood l;
  ASSERT_EQ(likelihood_from_ncc(surface, {100, 2, 0.02}, l), Status::kOk);
  const auto c = covariance_m2(l);
  EXPECT_NEAR(c[0], 4, 0.1);
  EXPECT_NEAR(c[3], 4, 0.1);
  EXPECT_NEAR(c[1], 0, 1e-3);
  EXPECT_NEAR(l.outside, 0.02, 1e-12);
  EXPECT_NEAR(l.values.pixels.at<float>(0, 0), 0.02, 1e-3);
}

TEST(Likelihood, KeepsTwoEqualPeaksEqualAndSaysSoInTheCovariance) {
  // 20 m apart along the north-western diagonal: 10² per axis, correlation −1 (east rises where north falls: rows run
  // south).
  GridImage surface = flat_surface(81, 81, 0);
  surface.pixels.at<float>(20, 20) = surface.pixels.at<float>(60, 60) = 0.9f;
  Likelihood l;
  ASSERT_EQ(likelihood_from_ncc(surface, {100, 0.5, 0.02}, l), Status::kOk);
  EXPECT_FLOAT_EQ(l.values.pixels.at<float>(20, 20), l.values.pixels.at<float>(60, 60));
  const auto c = covariance_m2(l);
  EXPECT_NEAR(c[0], 100, 1);
  EXPECT_NEAR(c[1], -100, 1);
  EXPECT_NEAR(c[3], 100, 1);
}

TEST(Likelihood, NeitherExcludesNorFavoursWhatTheMapDoesNotShow) {
  GridImage surface = flat_surface(41, 41, 0);
  surface.pixels.at<float>(20, 30) = 0.9f;
  surface.valid.colRange(0, 20).setTo(0);
  Likelihood l;
  ASSERT_EQ(likelihood_from_ncc(surface, {100, 1, 0.02}, l), Status::kOk);
  EXPECT_EQ(l.values.pixels.at<float>(20, 5), 1);
  EXPECT_NEAR(l.values.pixels.at<float>(5, 25), 0.02, 1e-3);
  EXPECT_GT(l.values.pixels.at<float>(20, 30), 10);
}

TEST(Likelihood, TemperedHalfwayIsTheSquareRoot) {
  GridImage surface = flat_surface(21, 21, 0);
  surface.pixels.at<float>(10, 10) = 0.9f;
  Likelihood whole, half;
  ASSERT_EQ(likelihood_from_ncc(surface, {50, 1, 0.04}, whole), Status::kOk);
  ASSERT_EQ(likelihood_from_ncc(surface, {50, 1, 0.04}, half), Status::kOk);
  ASSERT_EQ(temper(0.5, half), Status::kOk);
  EXPECT_NEAR(half.values.pixels.at<float>(10, 10), std::sqrt(whole.values.pixels.at<float>(10, 10)), 1e-4);
  EXPECT_NEAR(half.outside, 0.2, 1e-12);
  EXPECT_EQ(temper(1.5, half), Status::kBadValue);
  EXPECT_EQ(temper(std::nan(""), half), Status::kBadValue);
}

TEST(Likelihood, RefusesWhatItCannotUse) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const GridImage surface = flat_surface(9, 9, 0);
  Likelihood l;
  EXPECT_EQ(likelihood_from_ncc({}, {}, l), Status::kBadImage);
  EXPECT_EQ(likelihood_from_ncc(surface, {nan, 1, 0.1}, l), Status::kNotFinite);
  EXPECT_EQ(likelihood_from_ncc(surface, {10, nan, 0.1}, l), Status::kNotFinite);
  EXPECT_EQ(likelihood_from_ncc(surface, {10, 1, 0}, l), Status::kBadValue);
  EXPECT_EQ(likelihood_from_ncc(surface, {10, -1, 0.1}, l), Status::kBadValue);
  GridImage unknown = surface;
  unknown.valid = cv::Mat::zeros(9, 9, CV_8U);
  EXPECT_EQ(likelihood_from_ncc(unknown, {}, l), Status::kOutsideMap);
  GridImage broken = flat_surface(9, 9, float(nan));
  EXPECT_EQ(likelihood_from_ncc(broken, {}, l), Status::kNotFinite);
}

TEST(Peak, IsFoundBetweenPixelsWithItsRival) {
  // A parabola about column 20.3, row 9.8 of height 0.8, and a rival of 0.5 far away.
  GridImage surface = flat_surface(60, 40, -1);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 60; ++x)
      surface.pixels.at<float>(y, x) =
          std::max(0.f, float(0.8 - 0.02 * (std::pow(x - 20.3, 2) + std::pow(y - 9.8, 2))));
  surface.pixels.at<float>(30, 50) = 0.5f;
  Peak peak;
  ASSERT_EQ(find_peak(surface, 6, peak), Status::kOk);
  EXPECT_NEAR(peak.east_m, 100 + (20.3 + 0.5) * 0.5, 1e-3);
  EXPECT_NEAR(peak.north_m, 200 - (9.8 + 0.5) * 0.5, 1e-3);
  EXPECT_NEAR(peak.value, 0.8, 0.01);
  EXPECT_NEAR(peak.gap, peak.value - 0.5, 1e-6);
}

}  // namespace
}  // namespace landfix::nav
