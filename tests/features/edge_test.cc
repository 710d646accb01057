// Edge magnitude against the definition, written down plainly.
#include "runtime/features/edge.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/features/draw.h"

namespace landfix::features {
namespace {

cv::Mat edges(const cv::Mat& gray, const cv::Mat& valid = {}) {
  cv::Mat out;
  edge(gray, valid, out);
  return out;
}

int median_at(const cv::Mat& gray, int x, int y) {
  std::array<uint8_t, 9> v;
  for (int i = 0; i < 9; ++i) v[size_t(i)] = gray.at<uint8_t>(y + i / 3 - 1, x + i % 3 - 1);
  std::nth_element(v.begin(), v.begin() + 4, v.end());
  return v[4];
}

// 0 where the 5x5 pixels around are not all there and valid.
int plain_edge(const cv::Mat& gray, const cv::Mat& valid, int x, int y) {
  for (int dy = -2; dy <= 2; ++dy)
    for (int dx = -2; dx <= 2; ++dx)
      if (!cv::Rect({}, gray.size()).contains({x + dx, y + dy}) || !valid.at<uint8_t>(y + dy, x + dx)) return 0;
  const auto m = [&](int dx, int dy) { return median_at(gray, x + dx, y + dy); };
  const int gx = m(1, -1) + 2 * m(1, 0) + m(1, 1) - m(-1, -1) - 2 * m(-1, 0) - m(-1, 1);
  const int gy = m(-1, 1) + 2 * m(0, 1) + m(1, 1) - m(-1, -1) - 2 * m(0, -1) - m(1, -1);
  return 1 + int(std::min(254.0, std::floor(std::hypot(gx, gy) / 2 + 0.5)));
}

TEST(Edge, IsTheSobelMagnitudeOfTheMedian) {
  const cv::Mat gray = scene(120, 90, 1, 1), valid = mask_with_holes(120, 90, 2), out = edges(gray, valid);
  ASSERT_EQ(out.type(), CV_8UC1);
  int wrong = 0, with_data = 0;
  for (int y = 0; y < gray.rows; ++y)
    for (int x = 0; x < gray.cols; ++x) {
      wrong += out.at<uint8_t>(y, x) != plain_edge(gray, valid, x, y);
      with_data += out.at<uint8_t>(y, x) != 0;
    }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(with_data, 5000);  // of 10800: holes and borders take less than half
}

TEST(Edge, OfAStepIsHalfTheSobelMagnitude) {
  cv::Mat gray(20, 20, CV_8UC1, cv::Scalar(50));
  gray.colRange(10, 20).setTo(80);
  const cv::Mat out = edges(gray);
  EXPECT_EQ(out.at<uint8_t>(10, 9), 1 + 4 * 30 / 2);  // 30 · (1 + 2 + 1) / 2
  EXPECT_EQ(out.at<uint8_t>(10, 10), 61);
  EXPECT_EQ(out.at<uint8_t>(10, 5), 1);  // flat ground is data
  EXPECT_EQ(out.at<uint8_t>(1, 10), 0);  // the border is not
  gray.colRange(10, 20).setTo(250);
  EXPECT_EQ(edges(gray).at<uint8_t>(10, 10), 255);  // 1 + 400, cut off
}

TEST(Edge, NodataMakesNone) {
  cv::Mat gray(30, 30, CV_8UC1, cv::Scalar(200)), valid(30, 30, CV_8UC1, cv::Scalar(255));
  valid(cv::Rect(10, 10, 6, 6)).setTo(0);
  gray.setTo(0, valid == 0);
  const cv::Mat out = edges(gray, valid);
  EXPECT_EQ(cv::countNonZero(out > 1), 0);
  EXPECT_EQ(out.at<uint8_t>(8, 12), 0);  // 2 pixels from the hole
  EXPECT_EQ(out.at<uint8_t>(7, 12), 1);
}

TEST(Edge, DoesNotDependOnTheWindow) {
  const cv::Mat gray = scene(200, 150, 1, 3), valid = mask_with_holes(200, 150, 4), whole = edges(gray, valid);
  Numbers numbers(5);
  for (int i = 0; i < 50; ++i) {
    const cv::Rect part = random_rect(gray.size(), numbers), wide = grown(part, kEdgeHaloPx, gray.size());
    EXPECT_TRUE(same(edges(gray(wide), valid(wide))(part - wide.tl()), whole(part))) << part;
  }
}

TEST(Edge, TakesTinyImagesAndRefusesOtherTypes) {
  EXPECT_EQ(cv::countNonZero(edges(cv::Mat(4, 40, CV_8UC1, cv::Scalar(9)))), 0);
  EXPECT_EQ(cv::countNonZero(edges(cv::Mat(1, 1, CV_8UC1, cv::Scalar(9)))), 0);
  EXPECT_THROW(edges(cv::Mat(9, 9, CV_8UC3)), cv::Exception);
  EXPECT_THROW(edges(cv::Mat(9, 9, CV_8UC1), cv::Mat(9, 8, CV_8UC1)), cv::Exception);
}

}  // namespace
}  // namespace landfix::features
