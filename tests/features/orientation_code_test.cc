// Orientation in five levels: rounding, the code of five bit planes and the way back.
#include "runtime/features/orientation_code.h"

#include <gtest/gtest.h>

#include <cstring>
#include <set>
#include <vector>

#include "tests/features/draw.h"

namespace landfix::features {
namespace {

constexpr int kColumns = 100, kRows = 7;

/// What lf_read_bits would leave: 64-bit words, plane after plane.
std::vector<uint64_t> words_of(const cv::Mat& planes) {
  std::vector<uint64_t> words(planes.total() / 8);
  std::memcpy(words.data(), planes.data, planes.total());
  return words;
}

TEST(OrientationCode, RoundsToFiveLevels) {
  const cv::Mat ab = (cv::Mat_<cv::Vec2f>(1, 5) << cv::Vec2f(0.05f, -0.05f), cv::Vec2f(0.11f, -0.11f),
                      cv::Vec2f(0.29f, -0.29f), cv::Vec2f(0.31f, -0.31f), cv::Vec2f(0.99f, -0.99f));
  cv::Mat levels;
  orientation_levels(ab, levels);
  const int expected[] = {0, 1, 1, 2, 2};
  for (int x = 0; x < 5; ++x) {
    EXPECT_EQ(levels.at<cv::Vec2b>(0, x)[0], uint8_t(expected[x])) << x;
    EXPECT_EQ(int8_t(levels.at<cv::Vec2b>(0, x)[1]), -expected[x]) << x;
  }
}

TEST(OrientationCode, ComesBackAsItWas) {
  Numbers numbers(5);
  cv::Mat levels(kRows, kColumns, CV_8SC2), valid(kRows, kColumns, CV_8UC1), planes, again, again_valid;
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kColumns; ++x) {
      valid.at<uint8_t>(y, x) = numbers.within(0, 9) ? 255 : 0;
      for (int c = 0; c < 2; ++c) levels.ptr<int8_t>(y)[2 * x + c] = int8_t(numbers.within(-2, 2));
    }
  pack_orientation(levels, valid, planes);
  ASSERT_EQ(planes.size(), cv::Size(16, kOrientationPlanes * kRows));  // two words of 64 pixels
  unpack_orientation(words_of(planes).data(), 2, 2 * kRows, levels.size(), again, again_valid);
  EXPECT_EQ(cv::countNonZero(again_valid != valid), 0);
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < 2 * kColumns; ++x)
      ASSERT_EQ(again.ptr<int8_t>(y)[x], valid.at<uint8_t>(y, x / 2) ? levels.ptr<int8_t>(y)[x] : 0) << x << " " << y;
}

/// The five bits of pixel (0, 0).
int code_of(int a, int b) {
  cv::Mat levels(1, 1, CV_8SC2), planes;
  levels.ptr<int8_t>(0)[0] = int8_t(a);
  levels.ptr<int8_t>(0)[1] = int8_t(b);
  pack_orientation(levels, {}, planes);
  int code = 0;
  for (int p = 0; p < kOrientationPlanes; ++p) code |= (planes.at<uint8_t>(p, 0) & 1) << p;
  return code;
}

TEST(OrientationCode, IsAsTheFormatSays) {
  EXPECT_EQ(code_of(0, 0), 0b00011);
  EXPECT_EQ(code_of(1, 1), 0b00000);
  EXPECT_EQ(code_of(2, -1), 0b10010);
  EXPECT_EQ(code_of(-1, 2), 0b01100);
  EXPECT_EQ(code_of(-2, 0), 0b01101);
  EXPECT_EQ(code_of(0, 1), 0b10001);
  std::set<int> all;
  for (int a = -2; a <= 2; ++a)
    for (int b = -2; b <= 2; ++b) all.insert(code_of(a, b));
  EXPECT_EQ(all.size(), 25u);
  EXPECT_EQ(all.count(31), 0u);
}

TEST(OrientationCode, TakesCodesThatNoWriterMakesForNoData) {
  // Both zero (planes 0 and 1), but with a sign.
  std::vector<uint64_t> words(kOrientationPlanes, 0);
  for (const int plane : {0, 1, 3}) words[size_t(plane)] = 1;
  cv::Mat levels, valid;
  unpack_orientation(words.data(), 1, 1, {1, 1}, levels, valid);
  EXPECT_EQ(valid.at<uint8_t>(0, 0), 0);
  EXPECT_EQ(levels.at<cv::Vec2b>(0, 0), cv::Vec2b(0, 0));
}

}  // namespace
}  // namespace landfix::features
