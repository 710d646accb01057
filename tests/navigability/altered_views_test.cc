// Views of another day: what changes, what stays, and that they are the same every time.
#include "builder/navigability/altered_views.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tests/nav/scene.h"

namespace landfix::navigability {
namespace {

using features::GridImage;

constexpr int kSidePx = 200, kHalfPx = 24;
const cv::Point kMiddle(kSidePx / 2, kSidePx / 2);

/// Two fields of one tone with grain of their own, and a bright track of 3 pixels between them, from north to south.
GridImage fields_and_track() {
  cv::Mat image(kSidePx, kSidePx, CV_8UC3, cv::Scalar(80, 110, 70)), grain(image.size(), CV_8UC3);
  image.colRange(kSidePx / 2, kSidePx).setTo(cv::Scalar(140, 120, 90));
  cv::RNG(4).fill(grain, cv::RNG::UNIFORM, 0, 16);
  image += grain;
  image.colRange(kSidePx / 2 - 1, kSidePx / 2 + 2).setTo(cv::Scalar::all(230));
  return {image, {}, 0, 0, 4};
}

AlteredViews::View around(const cv::Point& corner) { return {corner, kHalfPx, 160, 50}; }

/// Of two images of one size, over all bands.
double correlation(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat x, y, result;
  a.convertTo(x, CV_32F);
  b.convertTo(y, CV_32F);
  cv::matchTemplate(x, y, result, cv::TM_CCOEFF_NORMED);
  return double(result.at<float>(0, 0));
}

TEST(AlteredViews, FieldsChangeAndWhatLiesBetweenThemStays) {
  const GridImage ground = fields_and_track();
  const AlteredViews views(ground);
  double contrast = 0, texture = 0, tone = 0;
  constexpr int kDays = 20;
  for (uint64_t day = 0; day < kDays; ++day) {
    const cv::Mat seen = views.draw(around(kMiddle), day).pixels;
    const cv::Rect west(2, 2, kHalfPx - 8, 2 * kHalfPx - 4);
    const cv::Mat before = ground.pixels(west + kMiddle - cv::Point(kHalfPx, kHalfPx));
    texture += correlation(seen(west), before) / kDays;
    tone = std::max(tone, std::abs(cv::mean(seen(west))[1] / cv::mean(before)[1] - 1));
    const double track = cv::mean(seen(cv::Rect(kHalfPx - 1, 16, 3, 16)))[0],
                 beside = cv::mean(seen(cv::Rect(kHalfPx + 8, 16, 8, 16)))[0];
    contrast += track / beside / kDays;
  }
  EXPECT_NEAR(texture, 0, 0.1) << "grain of other ground";
  EXPECT_GT(tone, 0.2) << "on some of the days";
  EXPECT_GT(contrast, 1.3) << "the track was 1.6 times as bright as the field beside it, and half a degree moves it";
}

TEST(AlteredViews, WhatIsNoFieldKeepsItsPattern) {
  const GridImage ground{nav::testing::random_texture(kSidePx, kSidePx, 3), {}, 0, 0, 4};
  const AlteredViews views(ground);
  const cv::Rect there(kMiddle.x - kHalfPx, kMiddle.y - kHalfPx, 2 * kHalfPx, 2 * kHalfPx);
  double alike = 0;
  for (uint64_t day = 0; day < 8; ++day)
    alike += correlation(views.draw(around(kMiddle), day).pixels, ground.pixels(there)) / 8;
  EXPECT_GT(alike, 0.5) << "turned by a degree, scaled by 1.5 %, with noise and other shadows";
  EXPECT_LT(alike, 0.98);
}

TEST(AlteredViews, ADayIsTheSameWhenItIsDrawnAgain) {
  const AlteredViews views(fields_and_track());
  const cv::Mat one = views.draw(around(kMiddle), 7).pixels;
  EXPECT_EQ(cv::norm(one, views.draw(around(kMiddle), 7).pixels, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(one, views.draw(around(kMiddle), 8).pixels, cv::NORM_INF), 0);
}

TEST(AlteredViews, NothingIsSeenBeyondTheImageNorWhereItHasNoData) {
  GridImage ground = fields_and_track();
  ground.valid = cv::Mat(kSidePx, kSidePx, CV_8U, cv::Scalar(255));
  ground.valid.rowRange(0, kSidePx / 2).setTo(0);
  const AlteredViews views(ground);
  const GridImage seen = views.draw(around(kMiddle), 1), corner = views.draw(around({kSidePx, kSidePx}), 1);
  EXPECT_EQ(cv::countNonZero(seen.valid.rowRange(0, kHalfPx - 4)), 0);
  EXPECT_EQ(cv::countNonZero(seen.valid.rowRange(kHalfPx + 4, 2 * kHalfPx)), (kHalfPx - 4) * 2 * kHalfPx);
  EXPECT_EQ(cv::countNonZero(corner.valid.colRange(kHalfPx + 4, 2 * kHalfPx)), 0);
  EXPECT_EQ(seen.west_m, -kHalfPx * 4);
  EXPECT_EQ(seen.north_m, kHalfPx * 4);
}

TEST(AlteredViews, HeightsThatVaryMoveWhatIsSeenAndEvenOnesDoNot) {
  const GridImage ground{nav::testing::random_texture(kSidePx, kSidePx, 3), {}, 0, 0, 4};
  GridImage heights{cv::Mat(kSidePx, kSidePx, CV_32F, cv::Scalar(700)), {}, 0, 0, 4};
  const cv::Mat flat = AlteredViews(ground).draw(around(kMiddle), 5).pixels;
  EXPECT_EQ(cv::norm(AlteredViews(ground, heights).draw(around(kMiddle), 5).pixels, flat, cv::NORM_INF), 0);
  for (int x = 0; x < kSidePx; ++x) heights.pixels.col(x).setTo(2 * x);  // 50 %
  const cv::Mat slope = AlteredViews(ground, heights).draw(around(kMiddle), 5).pixels;
  EXPECT_LT(correlation(slope, flat), 0.9) << "heights of a place beside are off by tens of metres";
  const cv::Rect middle(kHalfPx - 4, kHalfPx - 4, 8, 8), rim(0, 0, 8, 2 * kHalfPx);
  EXPECT_GT(correlation(slope(middle), flat(middle)), correlation(slope(rim), flat(rim)) + 0.3)
      << "right below the camera nothing moves";
}

}  // namespace
}  // namespace landfix::navigability
