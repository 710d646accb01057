// Orientation against its definition in double precision, and the bit planes against it.
#include "runtime/features/orientation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/features/draw.h"

namespace landfix::features {
namespace {

constexpr double kBinomial[5] = {1 / 16.0, 4 / 16.0, 6 / 16.0, 4 / 16.0, 1 / 16.0};

DatedOrientation orientation_of(const cv::Mat& bands, const cv::Mat& valid = {}) {
  DatedOrientation out;
  orientation(bands, valid, {}, out.ab, out.valid);
  return out;
}

cv::Mat_<double> smoothed(const cv::Mat_<double>& image) {
  cv::Mat_<double> out = cv::Mat_<double>::zeros(image.size());
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      for (int j = -2; j <= 2; ++j)
        for (int i = -2; i <= 2; ++i)
          if (cv::Rect({}, image.size()).contains({x + i, y + j}))
            out(y, x) += kBinomial[i + 2] * kBinomial[j + 2] * image(y + j, x + i);
  return out;
}

bool gradient_is_known(const cv::Mat& valid, int x, int y) {
  for (int j = -3; j <= 3; ++j)
    for (int i = -3; i <= 3; ++i)
      if (!cv::Rect({}, valid.size()).contains({x + i, y + j}) || !valid.at<uint8_t>(y + j, x + i)) return false;
  return true;
}

// The definition, step by step.
DatedOrientation plain_orientation(const cv::Mat& bands, const cv::Mat& valid) {
  const cv::Size size = bands.size();
  cv::Mat_<double> difference = cv::Mat_<double>::zeros(size), cross = difference.clone(), energy = difference.clone();
  DatedOrientation out{cv::Mat::zeros(size, CV_32FC2), cv::Mat::zeros(size, CV_8UC1)};
  for (int c = 0; c < bands.channels(); ++c) {
    cv::Mat band;
    cv::extractChannel(bands, band, c);
    const cv::Mat_<double> s = smoothed(cv::Mat_<double>(band));
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x) {
        if (!gradient_is_known(valid, x, y)) continue;
        out.valid.at<uint8_t>(y, x) = 255;
        const double gx =
            s(y - 1, x + 1) + 2 * s(y, x + 1) + s(y + 1, x + 1) - s(y - 1, x - 1) - 2 * s(y, x - 1) - s(y + 1, x - 1);
        const double gy =
            s(y + 1, x - 1) + 2 * s(y + 1, x) + s(y + 1, x + 1) - s(y - 1, x - 1) - 2 * s(y - 1, x) - s(y - 1, x + 1);
        difference(y, x) += gx * gx - gy * gy;
        cross(y, x) += 2 * gx * gy;
        energy(y, x) += gx * gx + gy * gy;
      }
  }
  difference = smoothed(difference), cross = smoothed(cross), energy = smoothed(energy);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      if (!out.valid.at<uint8_t>(y, x)) continue;
      const double m = std::sqrt(energy(y, x)), w = 1 / ((m + 1) * (m + 15 * std::sqrt(bands.channels())));
      out.ab.at<cv::Vec2f>(y, x) = {float(difference(y, x) * w), float(cross(y, x) * w)};
    }
  return out;
}

TEST(Orientation, IsTheSmoothedColourStructureTensor) {
  for (const int bands : {1, 2, 3, 4}) {
    const cv::Mat image = scene(90, 70, bands, 21), valid = mask_with_holes(90, 70, 22);
    const DatedOrientation fast = orientation_of(image, valid), plain = plain_orientation(image, valid);
    EXPECT_TRUE(same(fast.valid, plain.valid));
    EXPECT_GT(cv::countNonZero(plain.valid), 1500);
    // Smoothed bands are rounded to 1/8 of a gray level.
    EXPECT_LT(cv::norm(fast.ab, plain.ab, cv::NORM_INF), 0.015) << bands;
    EXPECT_GT(cv::norm(plain.ab, cv::NORM_INF), 0.5);
  }
}

// A step of 100 gray levels across the middle of an image, its gradient towards `direction` (x right, y down) where
// `rises`, else against it.
cv::Vec2f at_a_step(double direction_rad, int bands = 1, bool rises = true) {
  cv::Mat image(41, 41, CV_8UC(bands));
  for (int y = 0; y < 41; ++y)
    for (int x = 0; x < 41; ++x) {
      const double along = (x - 20) * std::cos(direction_rad) + (y - 20) * std::sin(direction_rad);
      for (int b = 0; b < bands; ++b) {
        const bool bright = (along > 0) == ((b % 2 == 0) == rises);
        image.ptr<uint8_t>(y)[x * bands + b] = bright ? 150 : 50;
      }
    }
  return orientation_of(image).ab.at<cv::Vec2f>(20, 20);
}

TEST(Orientation, DoublesTheAngleOfTheGradient) {
  const double pi = std::numbers::pi;
  EXPECT_GT(at_a_step(0)[0], 0.7);            // gradient east: the edge runs north-south
  EXPECT_LT(at_a_step(pi / 2)[0], -0.7);      // gradient south
  EXPECT_GT(at_a_step(pi / 4)[1], 0.7);       // gradient south-east
  EXPECT_LT(at_a_step(3 * pi / 4)[1], -0.7);  // gradient south-west
  EXPECT_NEAR(at_a_step(0)[1], 0, 1e-6);
  for (const double direction : {0.0, 0.3, 1.0}) {  // blind to contrast reversal
    EXPECT_LT(cv::norm(at_a_step(direction) - at_a_step(direction, 1, false)), 1e-3);
  }
}

TEST(Orientation, SeesEdgesThatCancelInGray) {
  EXPECT_GT(at_a_step(0, 2)[0], 0.7);  // one band rises as much as the other falls
}

TEST(Orientation, NodataMakesNoneAndAddsNothing) {
  cv::Mat gray(60, 60, CV_8UC1, cv::Scalar(180)), valid(60, 60, CV_8UC1, cv::Scalar(255));
  valid.colRange(30, 60).setTo(0);
  gray.colRange(30, 60).setTo(0);
  const DatedOrientation o = orientation_of(gray, valid);
  EXPECT_EQ(cv::norm(o.ab, cv::NORM_INF), 0);
  EXPECT_EQ(o.valid.at<uint8_t>(30, 26), 255);  // its 7x7 pixels end at column 29
  EXPECT_EQ(o.valid.at<uint8_t>(30, 27), 0);
  EXPECT_EQ(o.valid.at<uint8_t>(2, 10), 0);
}

TEST(Orientation, DoesNotDependOnTheWindow) {
  const cv::Mat image = scene(300, 200, 4, 23), valid = mask_with_holes(300, 200, 24);
  const DatedOrientation whole = orientation_of(image, valid);
  Numbers numbers(25);
  for (int i = 0; i < 40; ++i) {
    const cv::Rect part = random_rect(image.size(), numbers), wide = grown(part, kOrientationHaloPx, image.size());
    const DatedOrientation o = orientation_of(image(wide), valid(wide));
    EXPECT_TRUE(same(o.ab(part - wide.tl()), whole.ab(part))) << part;
    EXPECT_TRUE(same(o.valid(part - wide.tl()), whole.valid(part))) << part;
  }
}

TEST(Orientation, DoesNotDependOnThreads) {
  const cv::Mat image = scene(200, 200, 3, 26);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const DatedOrientation one = orientation_of(image);
  cv::setNumThreads(4);
  const DatedOrientation four = orientation_of(image);
  cv::setNumThreads(threads);
  EXPECT_TRUE(same(one.ab, four.ab));
}

TEST(Orientation, RefusesOtherTypes) {
  EXPECT_THROW(orientation_of(cv::Mat(20, 20, CV_16UC1)), cv::Exception);
  EXPECT_THROW(orientation_of(cv::Mat(20, 20, CV_8UC(5))), cv::Exception);
  EXPECT_THROW(orientation_of(cv::Mat(20, 20, CV_8UC1), cv::Mat(20, 19, CV_8UC1)), cv::Exception);
  EXPECT_EQ(cv::countNonZero(orientation_of(cv::Mat(5, 5, CV_8UC1, cv::Scalar(3))).valid), 0);
}

DatedOrientation uniform(float a, float b, cv::Size size = {8, 8}) {
  return {cv::Mat(size, CV_32FC2, cv::Scalar(a, b)), cv::Mat(size, CV_8UC1, cv::Scalar(255))};
}

TEST(Fuse, IsTheMeanOverTheDatesWithData) {
  std::vector<DatedOrientation> dates = {uniform(0.6f, -0.3f), uniform(0.2f, 0.1f), uniform(0.1f, 0.5f)};
  for (const int date : {1, 2}) {
    dates[size_t(date)].valid.at<uint8_t>(0, 0) = 0;
    dates[size_t(date)].ab.at<cv::Vec2f>(0, 0) = {0, 0};
  }
  for (DatedOrientation& date : dates) date.valid.at<uint8_t>(1, 1) = 0, date.ab.at<cv::Vec2f>(1, 1) = {0, 0};
  const DatedOrientation fused = fuse(dates);
  EXPECT_NEAR(fused.ab.at<cv::Vec2f>(5, 5)[0], 0.3, 1e-6);
  EXPECT_NEAR(fused.ab.at<cv::Vec2f>(5, 5)[1], 0.1, 1e-6);
  EXPECT_NEAR(fused.ab.at<cv::Vec2f>(0, 0)[0], 0.6, 1e-6);  // one date alone
  EXPECT_EQ(fused.valid.at<uint8_t>(0, 0), 255);
  EXPECT_EQ(fused.valid.at<uint8_t>(1, 1), 0);
  EXPECT_THROW(fuse({}), cv::Exception);
}

TEST(Agreement, IsFullForEqualDatesAndNoneForOppositeOnes) {
  const auto value = [](const std::vector<DatedOrientation>& dates) {
    cv::Mat out;
    agreement(dates, 4, out);
    EXPECT_EQ(out.size(), cv::Size(2, 2));
    return out.at<cv::Vec2b>(1, 1);
  };
  EXPECT_EQ(value({uniform(0.3f, 0.4f), uniform(0.3f, 0.4f)}), cv::Vec2b(255, 2));
  EXPECT_EQ(value({uniform(0.3f, 0.4f), uniform(-0.3f, -0.4f), uniform(0, 0)}), cv::Vec2b(1, 3));
  // At right angles: sqrt(2) / 2 of 254, and one more.
  EXPECT_EQ(value({uniform(0.5f, 0), uniform(0, 0.5f)}), cv::Vec2b(1 + 180, 2));
  EXPECT_EQ(value({uniform(0.5f, 0)}), cv::Vec2b(0, 0));  // nobody to agree with
  EXPECT_EQ(value({uniform(0, 0), uniform(0, 0)}), cv::Vec2b(1, 2));
}

TEST(Agreement, NeedsTwoDatesAtHalfOfThePixels) {
  std::vector<DatedOrientation> dates = {uniform(0.5f, 0), uniform(0.5f, 0)};
  dates[1].valid.rowRange(0, 2).setTo(0);  // of the upper blocks, half
  dates[1].valid.at<uint8_t>(2, 0) = 0;    // of the upper left one, more
  cv::Mat out;
  agreement(dates, 4, out);
  EXPECT_EQ(out.at<cv::Vec2b>(0, 0), cv::Vec2b(0, 0));
  EXPECT_EQ(out.at<cv::Vec2b>(0, 1), cv::Vec2b(255, 2));
  EXPECT_EQ(out.at<cv::Vec2b>(1, 0), cv::Vec2b(255, 2));
  EXPECT_THROW(agreement(dates, 3, out), cv::Exception);
}

}  // namespace
}  // namespace landfix::features
