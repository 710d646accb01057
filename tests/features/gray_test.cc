// The gray value that map and camera share.
#include "runtime/features/gray.h"

#include <gtest/gtest.h>

namespace landfix::features {
namespace {

TEST(Gray, IsTheLumaInIntegers) {
  // (299 * 200 + 587 * 100 + 114 * 50 + 500) / 1000 = 124.7: 124; a fourth channel does not count.
  const cv::Mat rgbn(2, 3, CV_8UC4, cv::Scalar(200, 100, 50, 255));
  const cv::Mat gray = gray_from_rgb(rgbn);
  ASSERT_EQ(gray.type(), CV_8UC1);
  ASSERT_EQ(gray.size(), rgbn.size());
  EXPECT_EQ(cv::countNonZero(gray != 124), 0);
  EXPECT_EQ(gray_from_rgb(cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(255))).at<uint8_t>(0, 0), 255);
}

TEST(Gray, CopiesOneChannel) {
  cv::Mat in(1, 2, CV_8UC1, cv::Scalar(7));
  const cv::Mat out = gray_from_rgb(in);
  in.setTo(9);
  EXPECT_EQ(out.at<uint8_t>(0, 1), 7);
}

TEST(Gray, RefusesOtherTypes) {
  EXPECT_THROW(gray_from_rgb(cv::Mat(2, 2, CV_8UC2, cv::Scalar::all(0))), cv::Exception);
  EXPECT_THROW(gray_from_rgb(cv::Mat(2, 2, CV_32FC3, cv::Scalar::all(0))), cv::Exception);
}

}  // namespace
}  // namespace landfix::features
