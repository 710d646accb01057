// Contours on drawn shapes, chains and distances against plain definitions.
#include "runtime/features/contour.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "tests/features/draw.h"

namespace landfix::features {
namespace {

struct Found {
  cv::Mat mask, known, direction, distance;
};

Found find_contours(const cv::Mat& gray, const cv::Mat& valid = {}, const ContourOptions& options = {}) {
  Found f;
  contours(gray, valid, options, f.mask, f.known, f.direction);
  contour_distance(f.mask, f.known, options, f.distance);
  return f;
}

cv::Mat square(int dark, int bright) {
  cv::Mat gray(100, 100, CV_8UC1, cv::Scalar(dark));
  gray(cv::Rect(30, 30, 40, 40)).setTo(bright);
  return gray;
}

TEST(Contour, OfASquareIsOnePixelWideAndPointsInwards) {
  const Found f = find_contours(square(60, 160));
  // Edges lie between columns 29 and 30: one of the two is the contour, all along the side.
  for (int y = 36; y < 64; ++y) {
    EXPECT_EQ((f.mask.at<uint8_t>(y, 29) != 0) + (f.mask.at<uint8_t>(y, 30) != 0), 1) << y;
    EXPECT_EQ(cv::countNonZero(f.mask.row(y)), 2) << y;  // and the opposite side
  }
  const int x = f.mask.at<uint8_t>(50, 29) ? 29 : 30;
  EXPECT_NEAR(f.direction.at<float>(50, x), 0, 1e-3);  // dark to bright is to the right
  const int top = f.mask.at<uint8_t>(29, 50) ? 29 : 30;
  EXPECT_NEAR(f.direction.at<float>(top, 50), std::numbers::pi / 2, 1e-3);  // and down
  EXPECT_EQ(f.direction.at<float>(50, 50), 0);
}

TEST(Contour, DoesNotDependOnBrightnessOrContrast) {
  cv::Mat bright = scene(300, 300, 1, 11);
  cv::GaussianBlur(bright, bright, {}, 1);
  cv::Mat dark;
  bright.convertTo(dark, CV_8U, 0.5, 3);
  const Found a = find_contours(bright), b = find_contours(dark);
  // Rounding to 8 bits moves some by a pixel and cuts chains; a few of the weakest fall below the floor.
  const auto share_near = [](const Found& of, const Found& to) {
    return double(cv::countNonZero(of.mask & (to.distance <= 2))) / cv::countNonZero(of.mask);
  };
  EXPECT_GT(cv::countNonZero(a.mask), 2000);
  EXPECT_GT(share_near(a, b), 0.85);
  EXPECT_GT(share_near(b, a), 0.85);
}

TEST(Contour, HasNoneOnNoiseBelowTheFloor) {
  Numbers numbers(12);
  cv::Mat water(200, 200, CV_8UC1);
  for (auto& v : cv::Mat_<uint8_t>(water)) v = uint8_t(40 + numbers.within(0, 3));
  EXPECT_EQ(cv::countNonZero(find_contours(water).mask), 0);
}

TEST(Contour, DropsShortChainsOnly) {
  ContourOptions o;
  const cv::Mat gray = scene(300, 200, 1, 13);
  o.min_length_px = 1;
  const cv::Mat all = find_contours(gray, {}, o).mask;
  o.min_length_px = 20;
  const cv::Mat long_ones = find_contours(gray, {}, o).mask;
  cv::Mat labels, statistics, centres;
  const int count = cv::connectedComponentsWithStats(all, labels, statistics, centres, 8);
  cv::Mat expected = cv::Mat::zeros(all.size(), CV_8UC1);
  int kept = 0;
  for (int i = 1; i < count; ++i)
    if (statistics.at<int>(i, cv::CC_STAT_AREA) >= 20) expected.setTo(255, labels == i), ++kept;
  EXPECT_TRUE(same(long_ones, expected));
  EXPECT_GT(kept, 10);
  EXPECT_LT(kept, count - 10);
}

TEST(Contour, DistanceIsThatToTheNearestContourRounded) {
  const ContourOptions o;
  const Found f = find_contours(scene(150, 120, 1, 14), mask_with_holes(150, 120, 15), o);
  const int reach = o.truncation_px;
  int wrong = 0, near = 0;
  for (int y = 0; y < f.mask.rows; ++y)
    for (int x = 0; x < f.mask.cols; ++x) {
      double least = reach;
      for (int dy = -reach; dy <= reach; ++dy)
        for (int dx = -reach; dx <= reach; ++dx)
          if (cv::Rect({}, f.mask.size()).contains({x + dx, y + dy}) && f.mask.at<uint8_t>(y + dy, x + dx))
            least = std::min(least, std::hypot(dx, dy));
      int expected = 0;  // the nearest of 0, 1, 2, 4, 6, 8
      for (const int d : {0, 1, 2, 4, 6, 8})
        if (f.known.at<uint8_t>(y, x) && (expected == 0 || std::abs(least - d) <= std::abs(least - (expected - 1))))
          expected = 1 + d;
      wrong += f.distance.at<uint8_t>(y, x) != expected;
      near += expected > 0 && expected <= reach;
    }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(near, 1000);
}

TEST(Contour, NodataMakesNone) {
  cv::Mat gray(100, 100, CV_8UC1, cv::Scalar(200)), valid(100, 100, CV_8UC1, cv::Scalar(255));
  cv::circle(valid, {50, 50}, 20, cv::Scalar(0), cv::FILLED);
  gray.setTo(0, valid == 0);
  const Found f = find_contours(gray, valid);
  EXPECT_EQ(cv::countNonZero(f.mask), 0);
  EXPECT_EQ(f.distance.at<uint8_t>(50, 73), 0);  // its gradient would touch column 70
  EXPECT_EQ(f.distance.at<uint8_t>(50, 74), 1 + 8);
  EXPECT_EQ(f.distance.at<uint8_t>(50, 2), 0);
}

TEST(Contour, DoesNotDependOnTheWindow) {
  const ContourOptions o;
  const cv::Mat gray = scene(400, 300, 1, 16), valid = mask_with_holes(400, 300, 17);
  const Found whole = find_contours(gray, valid, o);
  EXPECT_GT(cv::countNonZero(whole.mask), 3000);
  Numbers numbers(18);
  for (int i = 0; i < 30; ++i) {
    const cv::Rect part = random_rect(gray.size(), numbers), wide = grown(part, contour_halo_px(o), gray.size());
    const Found f = find_contours(gray(wide), valid(wide), o);
    EXPECT_TRUE(same(f.distance(part - wide.tl()), whole.distance(part))) << part;
    const cv::Rect less = grown(part, contours_halo_px(o), gray.size());
    const Found g = find_contours(gray(less), valid(less), o);
    EXPECT_TRUE(same(g.mask(part - less.tl()), whole.mask(part))) << part;
    EXPECT_TRUE(same(g.direction(part - less.tl()), whole.direction(part))) << part;
  }
}

TEST(Contour, RefusesWhatItCannotServe) {
  ContourOptions o;
  o.truncation_px = 16;
  EXPECT_THROW(find_contours(square(1, 200), {}, o), cv::Exception);
  EXPECT_THROW(find_contours(cv::Mat(9, 9, CV_8UC3)), cv::Exception);
  EXPECT_EQ(cv::countNonZero(find_contours(cv::Mat(3, 3, CV_8UC1, cv::Scalar(7))).distance), 0);
}

}  // namespace
}  // namespace landfix::features
