// Correlation against OpenCV where nothing is masked, and against the plain definition in doubles where something is.
#include "runtime/nav/ncc.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tests/nav/scene.h"

namespace landfix::nav {
namespace {

using features::GridImage;

GridImage image(const cv::Mat& pixels, const cv::Mat& valid = {}) { return {pixels, valid, 0, 0, 1}; }

/// A rotated rectangle, as a footprint is.
cv::Mat footprint(int width, int height) {
  cv::Mat mask = cv::Mat::zeros(height, width, CV_8U);
  const cv::Point corners[] = {
      {width / 3, 0}, {width - 1, height / 4}, {2 * width / 3, height - 1}, {0, 3 * height / 4}};
  cv::fillConvexPoly(mask, corners, 4, 255);
  return mask;
}

/// Conte 2009 eq. 5.15 by its definition, over the pixels valid in both.
double reference(const GridImage& patch, const GridImage& window, int u, int v, double& count) {
  double n = 0, p = 0, w = 0;
  const auto each = [&](auto&& visit) {
    for (int y = 0; y < patch.pixels.rows; ++y)
      for (int x = 0; x < patch.pixels.cols; ++x) {
        if (!patch.valid.empty() && !patch.valid.at<uint8_t>(y, x)) continue;
        if (!window.valid.empty() && !window.valid.at<uint8_t>(v + y, u + x)) continue;
        visit(double(patch.pixels.at<uint8_t>(y, x)), double(window.pixels.at<uint8_t>(v + y, u + x)));
      }
  };
  each([&](double a, double b) { n += 1, p += a, w += b; });
  count = n;
  double pp = 0, ww = 0, pw = 0;
  each([&](double a, double b) {
    pp += (a - p / n) * (a - p / n), ww += (b - w / n) * (b - w / n), pw += (a - p / n) * (b - w / n);
  });
  return pp > n / 12 && ww > n / 12 ? pw / std::sqrt(pp * ww) : 0;
}

void expect_like_reference(const GridImage& patch, const GridImage& window, double min_coverage) {
  Ncc matcher(min_coverage);
  GridImage surface;
  ASSERT_EQ(matcher.match(patch, window, surface), Status::kOk);
  const double all = patch.valid.empty() ? double(patch.pixels.total()) : cv::countNonZero(patch.valid);
  int valid = 0;
  for (int v = 0; v < surface.pixels.rows; ++v)
    for (int u = 0; u < surface.pixels.cols; ++u) {
      double count;
      const double expected = reference(patch, window, u, v, count);
      const bool covered = count >= min_coverage * all;
      ASSERT_EQ(surface.valid.at<uint8_t>(v, u) != 0, covered) << u << " " << v;
      ASSERT_NEAR(surface.pixels.at<float>(v, u), covered ? expected : 0, 1e-3) << u << " " << v;
      valid += covered;
    }
  EXPECT_GT(valid, 20);
}

TEST(Ncc, EqualsOpenCvWhereNothingIsMasked) {
  const cv::Mat map = testing::random_texture(208, 200, 1);
  cv::Mat patch = map(cv::Rect(30, 50, 128, 120)).clone(), expected;
  patch = patch * 0.6 + testing::random_texture(128, 120, 2) * 0.2;
  cv::matchTemplate(map, patch, expected, cv::TM_CCOEFF_NORMED);
  Ncc matcher;
  GridImage surface;
  ASSERT_EQ(matcher.match(image(patch), image(map), surface), Status::kOk);
  ASSERT_EQ(surface.pixels.size(), expected.size());
  EXPECT_LT(cv::norm(surface.pixels, expected, cv::NORM_INF), 1e-3);
  EXPECT_EQ(cv::countNonZero(surface.valid), int(surface.valid.total()));
}

TEST(Ncc, EqualsOpenCvForTemplatesWhoseSquaresOverflow32Bits) {
  // 600 × 500 pixels of 255 and 0: squares about 128 sum to 4.9e9, beyond 2^32.
  cv::Mat map(520, 630, CV_8U);
  cv::RNG(5).fill(map, cv::RNG::UNIFORM, 0, 2);
  map *= 255;
  cv::Mat patch = map(cv::Rect(7, 9, 600, 500)).clone(), expected;
  cv::matchTemplate(map, patch, expected, cv::TM_CCOEFF_NORMED);
  Ncc matcher;
  GridImage surface;
  ASSERT_EQ(matcher.match(image(patch), image(map), surface), Status::kOk);
  EXPECT_LT(cv::norm(surface.pixels, expected, cv::NORM_INF), 1e-3);
  EXPECT_NEAR(surface.pixels.at<float>(9, 7), 1, 1e-4);
}

TEST(Ncc, EqualsItsDefinitionUnderMasks) {
  const cv::Mat map = testing::random_texture(90, 80, 3);
  const cv::Mat patch = cv::Mat(map(cv::Rect(20, 15, 48, 40))) * 0.5 + testing::random_texture(48, 40, 4) * 0.3;
  cv::Mat holes(80, 90, CV_8U, cv::Scalar(255));
  holes(cv::Rect(0, 0, 30, 80)).setTo(0);
  cv::circle(holes, {60, 40}, 9, 0, cv::FILLED);
  expect_like_reference(image(patch, footprint(48, 40)), image(map), 0.5);
  expect_like_reference(image(patch), image(map, holes), 0.6);
  expect_like_reference(image(patch, footprint(48, 40)), image(map, holes), 0.7);
}

TEST(Ncc, OneMatcherServesChangingSizes) {
  Ncc matcher;
  const cv::Mat map = testing::random_texture(300, 300, 6);
  for (int size : {200, 40, 120, 41}) {
    const cv::Mat window = map(cv::Rect(0, 0, size + 20, size + 31));
    GridImage surface;
    ASSERT_EQ(matcher.match(image(map(cv::Rect(7, 11, size, size)), footprint(size, size)), image(window), surface),
              Status::kOk);
    EXPECT_EQ(surface.pixels.size(), cv::Size(21, 32));
    EXPECT_NEAR(surface.pixels.at<float>(11, 7), 1, 1e-3);
  }
}

TEST(Ncc, FlatPlacesCountZero) {
  cv::Mat map = testing::random_texture(120, 60, 7);
  map.colRange(0, 60).setTo(200);
  const cv::Mat patch = map(cv::Rect(80, 10, 32, 32)).clone();
  Ncc matcher;
  GridImage surface;
  ASSERT_EQ(matcher.match(image(patch), image(map), surface), Status::kOk);
  EXPECT_TRUE(cv::checkRange(surface.pixels));
  for (int u = 0; u <= 28; ++u) EXPECT_EQ(surface.pixels.at<float>(3, u), 0) << u;  // 32 pixels from u on end at 60
  EXPECT_EQ(matcher.match(image(cv::Mat(32, 32, CV_8U, cv::Scalar(9))), image(map), surface), Status::kNoTexture);
  EXPECT_EQ(cv::norm(surface.pixels, cv::NORM_INF), 0);
}

TEST(Ncc, SurfaceLiesWhereThePatchOriginLies) {
  // The patch, cut out at column 25 and row 13, hangs 8 m west and 6 m north of its origin: the origin must come out at
  // east 1000 + 25·0.5 + 8, north 2000 − 13·0.5 − 6.
  const cv::Mat map = testing::random_texture(100, 90, 8);
  const GridImage window{map, {}, 1000, 2000, 0.5}, patch{map(cv::Rect(25, 13, 40, 30)), {}, -8, 6, 0.5};
  Ncc matcher;
  GridImage surface;
  ASSERT_EQ(matcher.match(patch, window, surface), Status::kOk);
  cv::Point top;
  cv::minMaxLoc(surface.pixels, nullptr, nullptr, nullptr, &top);
  EXPECT_DOUBLE_EQ(surface.west_m + (top.x + 0.5) * surface.gsd_m, 1020.5);
  EXPECT_DOUBLE_EQ(surface.north_m - (top.y + 0.5) * surface.gsd_m, 1987.5);
}

TEST(Ncc, CountsIndependentPixelsByTheAutocorrelation) {
  // White noise blurred with sigma s has ρ = exp(−d²/4s²) and Σρ² = 2πs²: 56.5 pixels for s = 3, so 200² pixels are
  // worth 707.
  cv::Mat noise(260, 260, CV_32F), texture;
  cv::RNG(4).fill(noise, cv::RNG::NORMAL, 0, 200);
  cv::GaussianBlur(noise, noise, {25, 25}, 3);
  noise.convertTo(texture, CV_8U, 1, 128);
  Ncc matcher;
  EXPECT_EQ(matcher.independent_pixels(), 0);
  GridImage surface;
  ASSERT_EQ(matcher.match(image(texture(cv::Rect(20, 20, 200, 200))), image(texture), surface), Status::kOk);
  EXPECT_NEAR(matcher.independent_pixels(), 707, 0.2 * 707);
}

TEST(Ncc, RefusesWhatItCannotUse) {
  const GridImage map = image(testing::random_texture(50, 50, 9)), patch = image(testing::random_texture(20, 20, 9));
  Ncc matcher;
  GridImage surface;
  EXPECT_EQ(matcher.match({}, map, surface), Status::kBadImage);
  EXPECT_EQ(matcher.match(patch, image(cv::Mat(50, 50, CV_32F, cv::Scalar(1))), surface), Status::kBadImage);
  EXPECT_EQ(matcher.match(image(patch.pixels, cv::Mat(5, 5, CV_8U)), map, surface), Status::kBadImage);
  EXPECT_EQ(matcher.match(map, patch, surface), Status::kTemplateTooLarge);
  EXPECT_EQ(matcher.match(patch, image(map.pixels, cv::Mat::zeros(50, 50, CV_8U)), surface), Status::kOutsideMap);
  EXPECT_EQ(matcher.match(image(patch.pixels, cv::Mat::zeros(20, 20, CV_8U)), map, surface), Status::kNoTexture);
}

}  // namespace
}  // namespace landfix::nav
