// The point-mass filter against the Kalman filter where both are exact, and where only it can go.
#include "runtime/nav/point_mass_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace landfix::nav {
namespace {

/// Gaussian likelihood at a position, on a floor.
Likelihood gaussian(double east_m, double north_m, double sigma_m, double floor, double half_width_m, double gsd_m) {
  const int n = int(2 * half_width_m / gsd_m);
  Likelihood l;
  l.values = {cv::Mat(n, n, CV_32F), cv::Mat(n, n, CV_8U, cv::Scalar(255)), east_m - half_width_m,
              north_m + half_width_m, gsd_m};
  l.outside = floor;
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const double e = (x + 0.5) * gsd_m - half_width_m, u = half_width_m - (y + 0.5) * gsd_m;
      l.values.pixels.at<float>(y, x) = float(std::exp(-0.5 * (e * e + u * u) / (sigma_m * sigma_m)) + floor);
    }
  return l;
}

double mass_within(const PointMassFilter& filter, double east_m, double north_m, double radius_m) {
  double sum = 0;
  for (int y = 0; y < filter.masses().rows; ++y)
    for (int x = 0; x < filter.masses().cols; ++x) {
      const double e = filter.west_m() + x * filter.cell_m(), n = filter.north_m() - y * filter.cell_m();
      if (std::hypot(e - east_m, n - north_m) <= radius_m) sum += filter.masses().at<double>(y, x);
    }
  return sum;
}

TEST(PointMassFilter, StartsAsTheGaussianItWasGiven) {
  for (double sigma : {0.3, 5.0, 80.0, 3000.0}) {
    PointMassFilter filter;
    ASSERT_EQ(filter.start(500000, 4000000, sigma), Status::kOk);
    const auto m = filter.moments();
    EXPECT_NEAR(m.east_m, 500000, 1e-6 * sigma);
    EXPECT_NEAR(m.north_m, 4000000, 1e-6 * sigma);
    // 1/12 cell² comes on top.
    const double variance = sigma * sigma + filter.cell_m() * filter.cell_m() / 12;
    EXPECT_NEAR(m.covariance_m2[0], variance, 0.01 * variance) << sigma;
    EXPECT_NEAR(m.covariance_m2[3], variance, 0.01 * variance) << sigma;
    EXPECT_NEAR(m.covariance_m2[1], 0, 1e-3 * variance);
    EXPECT_LE(std::max(filter.masses().cols, filter.masses().rows), 401);
  }
}

TEST(PointMassFilter, EqualsTheKalmanFilterOnALinearGaussianProblem) {
  PointMassFilter filter;
  ASSERT_EQ(filter.start(10, 20, 8), Status::kOk);
  double east = 10, north = 20, variance = 64;
  for (int step = 0; step < 40; ++step) {
    const double de = 3.137 * std::cos(0.2 * step), dn = 3.137 * std::sin(0.2 * step);
    ASSERT_EQ(filter.predict(de, dn, 0.7, 0.7), Status::kOk);
    east += de, north += dn, variance += 0.49;
    if (step % 4 != 3) continue;
    const double sigma = 1.5, ze = east + 0.8 * std::sin(step), zn = north - 0.6 * std::cos(step);
    ASSERT_EQ(filter.update(gaussian(ze, zn, sigma, 0, 40, 0.5)), Status::kOk);
    const double gain = variance / (variance + sigma * sigma);
    east += gain * (ze - east), north += gain * (zn - north), variance *= 1 - gain;
    const auto m = filter.moments();
    EXPECT_NEAR(m.east_m, east, 0.02) << step;
    EXPECT_NEAR(m.north_m, north, 0.02) << step;
    EXPECT_NEAR(m.covariance_m2[0], variance, 0.05 * variance) << step;
    EXPECT_NEAR(m.covariance_m2[3], variance, 0.05 * variance) << step;
  }
  EXPECT_EQ(filter.cell_m(), 0.25);  // sigma is below 1 m by now
}

TEST(PointMassFilter, TranslatesExactly) {
  PointMassFilter filter;
  ASSERT_EQ(filter.start(0, 0, 3), Status::kOk);
  const cv::Mat before = filter.masses().clone();
  ASSERT_EQ(filter.predict(0.123, -7.7, 0, 0), Status::kOk);
  EXPECT_EQ(cv::norm(before, filter.masses(), cv::NORM_INF), 0);
  EXPECT_NEAR(filter.moments().east_m, 0.123, 1e-9);
  EXPECT_NEAR(filter.moments().north_m, -7.7, 1e-9);
}

TEST(PointMassFilter, SumsManySmallNoises) {
  // 2000 steps of 0.02 m, a twelfth of a cell: variance 1 + 2000·0.0004 = 1.8 m² (+ 1/12 cell²), where sampled
  // densities would lose it.
  PointMassFilter filter;
  ASSERT_EQ(filter.start(0, 0, 1), Status::kOk);
  for (int i = 0; i < 2000; ++i) ASSERT_EQ(filter.predict(0.1, 0, 0.02, 0.02), Status::kOk);
  EXPECT_NEAR(filter.moments().covariance_m2[0], 1.8 + 0.0052, 0.02);
  EXPECT_NEAR(filter.moments().east_m, 200, 1e-3);
}

TEST(PointMassFilter, SurvivesLongDeadReckoningAndComesBackFine) {
  // 1500 steps of 2 m and 3 m: sigma √(1 + 1500·4) = 77.5 m and 116.2 m. ±5 sigma of 116 m in 401 cells: 4 m cells at
  // most.
  PointMassFilter filter;
  ASSERT_EQ(filter.start(0, 0, 1), Status::kOk);
  for (int i = 0; i < 1500; ++i) ASSERT_EQ(filter.predict(5, 1, 2, 3), Status::kOk);
  auto m = filter.moments();
  EXPECT_NEAR(std::sqrt(m.covariance_m2[0]), 77.5, 1);
  EXPECT_NEAR(std::sqrt(m.covariance_m2[3]), 116.2, 1.5);
  EXPECT_NEAR(m.east_m, 7500, 0.5);
  EXPECT_LE(std::max(filter.masses().cols, filter.masses().rows), 401);
  EXPECT_LE(filter.cell_m(), 4);
  EXPECT_NEAR(cv::sum(filter.masses())[0], 1, 1e-9);
  // Fixes 60 m off, as narrow as the grid allows at each time, bring it back to the finest grid.
  for (int i = 0; i < 4; ++i)
    ASSERT_EQ(filter.update(gaussian(7560, 1500, std::max(0.5 * filter.cell_m(), 0.8), 1e-3, 60, 0.5)), Status::kOk);
  m = filter.moments();
  EXPECT_NEAR(m.east_m, 7560, 0.2);
  EXPECT_NEAR(m.north_m, 1500, 0.2);
  EXPECT_LT(m.covariance_m2[0], 1);
  EXPECT_EQ(filter.cell_m(), 0.25);
}

TEST(PointMassFilter, KeepsARareModeThatIsFarAway) {
  // 1 % of the probability, 90 m away from the rest: regridding may drop 1e-4 in all, so the mode stays, and a later
  // fix finds it.
  PointMassFilter filter;
  ASSERT_EQ(filter.start(0, 0, 30), Status::kOk);
  Likelihood two = gaussian(0, 0, 2, 0, 150, 0.5);
  const Likelihood other = gaussian(90, 0, 2, 0, 150, 0.5);
  cv::Mat shifted = cv::Mat::zeros(two.values.pixels.size(), CV_32F);
  other.values.pixels.colRange(0, 420).copyTo(shifted.colRange(180, 600));
  two.values.pixels += 0.01 * std::exp(0.5 * 9) * shifted;  // undoes the prior's decay at 3 sigma
  two.outside = 0;
  ASSERT_EQ(filter.update(two), Status::kOk);
  EXPECT_NEAR(mass_within(filter, 90, 0, 10), 0.01, 0.002);
  for (int i = 0; i < 20; ++i) ASSERT_EQ(filter.predict(1, 0, 0.1, 0.1), Status::kOk);
  EXPECT_NEAR(mass_within(filter, 110, 0, 10), 0.01, 0.002);
  ASSERT_EQ(filter.update(gaussian(110, 0, 2, 1e-6, 50, 0.5)), Status::kOk);
  EXPECT_NEAR(filter.moments().east_m, 110, 0.5);
}

TEST(PointMassFilter, BoundsHoldAllButTheTails) {
  // 1e-3 beyond each side of a Gaussian: 3.09 sigma.
  PointMassFilter filter;
  ASSERT_EQ(filter.start(100, 50, 10), Status::kOk);
  const auto b = filter.bounds(1e-3);
  EXPECT_NEAR(b.west_m, 100 - 30.9, 0.6);
  EXPECT_NEAR(b.east_m, 100 + 30.9, 0.6);
  EXPECT_NEAR(b.south_m, 50 - 30.9, 0.6);
  EXPECT_NEAR(b.north_m, 50 + 30.9, 0.6);
}

TEST(PointMassFilter, RefusesBadInputAndStaysAsItWas) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  PointMassFilter filter;
  EXPECT_EQ(filter.predict(1, 1, 1, 1), Status::kNotStarted);
  EXPECT_EQ(filter.update(gaussian(0, 0, 1, 0, 10, 1)), Status::kNotStarted);
  EXPECT_EQ(filter.start(nan, 0, 1), Status::kNotFinite);
  EXPECT_EQ(filter.start(0, 0, -1), Status::kBadValue);
  EXPECT_FALSE(filter.started());
  ASSERT_EQ(filter.start(3, 4, 2), Status::kOk);
  const cv::Mat before = filter.masses().clone();
  EXPECT_EQ(filter.predict(nan, 0, 1, 1), Status::kNotFinite);
  EXPECT_EQ(filter.predict(0, inf, 1, 1), Status::kNotFinite);
  EXPECT_EQ(filter.predict(0, 0, nan, 1), Status::kNotFinite);
  EXPECT_EQ(filter.predict(0, 0, 1, -1), Status::kBadValue);
  Likelihood broken = gaussian(0, 0, 1, 0, 10, 1);
  broken.values.pixels.at<float>(3, 3) = float(nan);
  EXPECT_EQ(filter.update(broken), Status::kNotFinite);
  broken.values.pixels.at<float>(3, 3) = -1;
  EXPECT_EQ(filter.update(broken), Status::kBadValue);
  EXPECT_EQ(filter.update({}), Status::kBadImage);
  EXPECT_EQ(filter.update(gaussian(5000, 0, 1, 0, 10, 1)), Status::kLost);
  EXPECT_EQ(filter.start(0, 0, inf), Status::kNotFinite);
  EXPECT_EQ(cv::norm(before, filter.masses(), cv::NORM_INF), 0);
  EXPECT_NEAR(filter.moments().east_m, 3, 1e-9);
}

}  // namespace
}  // namespace landfix::nav
