// What a similarity does to a patch: which way it turns, about what, and what it leaves without data.
#include <gtest/gtest.h>

#include "runtime/nav/matcher.h"

namespace landfix::nav {
namespace {

using features::GridImage;

constexpr double kDegree = 0.017453292519943295;

TEST(Similarity, TurnsClockwiseAndStretchesAboutTheOrigin) {
  // One bright spot 20 m north of the origin (at row 30, column 50); turned by 90° and stretched by 1.5 it is 30 m
  // east.
  GridImage image{cv::Mat::zeros(101, 101, CV_8UC1), {}, -50.5, 50.5, 1}, out;
  image.pixels.at<uint8_t>(30, 50) = 255;
  apply({90 * kDegree, 1.5}, image, out);
  cv::Point top;
  cv::minMaxLoc(out.pixels, nullptr, nullptr, nullptr, &top);
  EXPECT_EQ(top, cv::Point(80, 50));
  EXPECT_EQ(cv::countNonZero(out.valid), int(out.valid.total()));
  // An origin in the south-western corner: what is north of it turns to the east.
  image = {cv::Mat::zeros(101, 101, CV_8UC1), {}, -0.5, 100.5, 1};
  image.pixels.at<uint8_t>(30, 0) = 255;
  apply({90 * kDegree, 1}, image, out);
  cv::minMaxLoc(out.pixels, nullptr, nullptr, nullptr, &top);
  EXPECT_EQ(top, cv::Point(70, 100));
}

TEST(Similarity, KnowsWhatComesFromBeyondTheImage) {
  GridImage image{cv::Mat(100, 100, CV_8UC1, cv::Scalar(9)), {}, -50, 50, 1}, out;
  apply({}, image, out);
  EXPECT_EQ(cv::countNonZero(out.valid), 10000);
  apply({0, 0.5}, image, out);
  EXPECT_NEAR(cv::countNonZero(out.valid), 50 * 50, 110) << "shrunk, less its rim";
  apply({45 * kDegree, 1}, image, out);
  EXPECT_NEAR(cv::countNonZero(out.valid), 8284, 160) << "a regular octagon";
  image.valid = cv::Mat(100, 100, CV_8U, cv::Scalar(255));
  image.valid.colRange(0, 50).setTo(0);
  apply({180 * kDegree, 1}, image, out);
  EXPECT_EQ(cv::countNonZero(out.valid.colRange(51, 100)), 0);
  EXPECT_NEAR(cv::countNonZero(out.valid.colRange(0, 50)), 5000, 160);
}

}  // namespace
}  // namespace landfix::nav
