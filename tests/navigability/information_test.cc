// The Cramér-Rao bound of a view: against an estimator that reaches it, and against simple images.
#include "builder/navigability/information.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tests/nav/scene.h"

namespace landfix::navigability {
namespace {

using features::GridImage;

constexpr int kSidePx = 120;
const cv::Rect kView(40, 40, 40, 40);

GridImage image_of(const cv::Mat& pixels) { return {pixels, {}, 0, 0, 4}; }

cv::Mat smooth(uint64_t seed) {
  cv::Mat out;
  cv::GaussianBlur(nav::testing::random_texture(kSidePx, kSidePx, seed), out, {0, 0}, 2);
  return out;
}

cv::Mat with_noise(const cv::Mat& image, double sigma, uint64_t seed) {
  cv::Mat noise(image.size(), CV_64F), out;
  cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0, sigma);
  image.convertTo(out, CV_64F);
  out += noise;
  out.convertTo(out, CV_8U);
  return out;
}

TEST(Information, LeastSquaresReachesTheBound) {
  constexpr double kSigma = 8;
  const cv::Mat ground = smooth(3);
  cv::Mat dx, dy;
  cv::Sobel(ground, dx, CV_64F, 1, 0, 3, 1 / 8.0);
  cv::Sobel(ground, dy, CV_64F, 0, 1, 3, -1 / 8.0);
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero(), spread = normal, bound = normal;
  const cv::Mat gx = dx(kView), gy = dy(kView);
  normal << gx.dot(gx), gx.dot(gy), gx.dot(gy), gy.dot(gy);
  constexpr int kTrials = 400;
  for (int i = 0; i < kTrials; ++i) {
    const cv::Mat seen = with_noise(ground, kSigma, uint64_t(i + 1));
    cv::Mat apart;
    cv::subtract(seen, ground, apart, cv::noArray(), CV_64F);
    const Eigen::Vector2d off = normal.inverse() * Eigen::Vector2d(gx.dot(apart(kView)), gy.dot(apart(kView)));
    spread += off * off.transpose() / kTrials;
    const auto least = Information(image_of(ground), image_of(seen)).least_covariance_px2(kView, 40);
    bound += Eigen::Map<const Eigen::Matrix2d>(least.data()) / kTrials;
  }
  EXPECT_NEAR(bound(0, 0) / spread(0, 0), 1, 0.15) << "400 trials know a variance to 7 %";
  EXPECT_NEAR(bound(1, 1) / spread(1, 1), 1, 0.15);
  EXPECT_NEAR(bound(0, 1), spread(0, 1), 0.15 * std::sqrt(spread(0, 0) * spread(1, 1)));
}

TEST(Information, GainAndOffsetAreNoNoise) {
  const cv::Mat ground = smooth(3);
  const auto same = Information(image_of(ground), image_of(ground)).least_covariance_px2(kView, 40),
             darker = Information(image_of(ground), image_of(ground * 0.5 + 20)).least_covariance_px2(kView, 40),
             noisy = Information(image_of(ground), image_of(with_noise(ground, 20, 1))).least_covariance_px2(kView, 40);
  EXPECT_NEAR(darker[0] / same[0], 1, 0.2);
  EXPECT_GT(noisy[0], 100 * same[0]) << "20 gray levels instead of 1";
}

TEST(Information, AlongBarsAndOnFlatGroundOnlyTheSearchIsKnown) {
  cv::Mat bars(kSidePx, kSidePx, CV_8U);
  for (int x = 0; x < kSidePx; ++x) bars.col(x).setTo(x / 6 % 2 ? 60 : 160);
  const double known = 40 * 40 / 3.0;
  const auto along = Information(image_of(bars), {}).least_covariance_px2(kView, 40);
  EXPECT_LT(along[0], 0.01);
  EXPECT_NEAR(along[3], known, 1e-6 * known);
  const auto flat =
      Information(image_of(cv::Mat(bars.size(), CV_8U, cv::Scalar(90))), {}).least_covariance_px2(kView, 40);
  EXPECT_NEAR(flat[0], known, 1e-6 * known);
  const auto beyond = Information(image_of(bars), {}).least_covariance_px2(kView + cv::Point(500, 0), 40);
  EXPECT_NEAR(beyond[0], known, 1e-6 * known) << "the image has none of the view";
}

TEST(BoundedBelow, RaisesOnlyWhatIsTooSmall) {
  const std::array<double, 4> least = {4, 0, 0, 1};
  const auto kept = bounded_below({9, 1, 1, 5}, least), raised = bounded_below({1, 0, 0, 5}, least);
  const std::array<double, 4> kAsItWas = {9, 1, 1, 5}, kRaised = {4, 0, 0, 5};
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(kept[i], kAsItWas[i], 1e-12);
    EXPECT_NEAR(raised[i], kRaised[i], 1e-12);
  }
  // Along (1, 1) the bound is far larger; across it the covariance stays.
  const auto turned = bounded_below({2, 0, 0, 2}, {50.5, 49.5, 49.5, 50.5});
  EXPECT_NEAR((turned[0] + 2 * turned[1] + turned[3]) / 2, 100, 1e-9);
  EXPECT_NEAR((turned[0] - 2 * turned[1] + turned[3]) / 2, 2, 1e-9);
}

}  // namespace
}  // namespace landfix::navigability
