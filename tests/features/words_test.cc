// Words against what drawn images must give, and against FLANN's exact search.
#include "runtime/features/words.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/flann.hpp>

#include "tests/features/draw.h"

namespace landfix::features {
namespace {

struct Row {
  std::vector<float> texture, colour;
  std::vector<uint8_t> known;
};

Row describe_row(const cv::Mat& image, const cv::Mat& valid, int j) {
  WordDescriptors d;
  d.prepare(image, valid);
  Row row{std::vector<float>(size_t(d.columns()) * kTextureDims),
          std::vector<float>(size_t(d.columns() * d.colour_dims())), std::vector<uint8_t>(size_t(d.columns()))};
  d.row(j, row.texture, row.colour, row.known);
  return row;
}

TEST(WordGain, BringsTheGeometricMeanTo110OverValidPixelsAlone) {
  cv::Mat image(20, 20, CV_8UC3, cv::Scalar(42, 42, 42)), valid(20, 20, CV_8UC1, cv::Scalar(255));
  EXPECT_NEAR(word_gain(image, valid), 110.0 / 50, 1e-9);  // 42 + 8
  image(cv::Rect(0, 0, 10, 20)).setTo(cv::Scalar::all(0));
  valid(cv::Rect(0, 0, 10, 20)).setTo(0);
  EXPECT_NEAR(word_gain(image, valid), 110.0 / 50, 1e-9);
  valid.setTo(255);  // a black frame that no mask declares
  EXPECT_NEAR(word_gain(image, valid), 110.0 / 50, 1e-9);
  EXPECT_EQ(with_gain(cv::Mat(1, 1, CV_8UC1, cv::Scalar(200)), 2).at<uint8_t>(0), 255);
}

TEST(WordDescriptors, AVerticalEdgeFillsTheFirstOrientation) {
  cv::Mat image(32, 32, CV_8UC1, cv::Scalar(60));
  image(cv::Rect(16, 0, 16, 32)).setTo(180);
  const Row row = describe_row(image, {}, 8);
  const float* at = &row.texture[7 * kTextureDims];  // node 7: corner 15, the edge is inside its right cells
  float first = 0, others = 0;
  for (int k = 0; k < kTextureDims; ++k) (k % 8 == 0 ? first : others) += at[k];
  EXPECT_GT(first, 1);
  EXPECT_NEAR(others, 0, 1e-3);
}

TEST(WordDescriptors, AFlatImageHasNoTextureAndItsOwnColour) {
  const cv::Mat image(32, 32, CV_8UC3, cv::Scalar(100, 50, 20));
  const Row row = describe_row(image, {}, 5);
  for (const float value : row.texture) EXPECT_EQ(value, 0);
  const double r = std::log(116), g = std::log(66), b = std::log(36), lum = (r + g + b) / 3;
  const double expected[kColourDims] = {4 * (r - g), 4 * (b - (r + g) / 2), 0, 0.6 * lum, 0, 0, 0};
  for (int k = 0; k < kColourDims; ++k) EXPECT_NEAR(row.colour[size_t(kColourDims * 6 + k)], expected[k], 0.01) << k;
}

TEST(WordDescriptors, NodesNearMissingDataAreUnknown) {
  const cv::Mat image = scene(64, 64, 3, 1);
  cv::Mat valid(64, 64, CV_8UC1, cv::Scalar(255));
  valid(cv::Rect(0, 0, 10, 64)).setTo(0);
  const Row row = describe_row(image, valid, 16);
  for (size_t i = 0; i < row.known.size(); ++i) EXPECT_EQ(row.known[i] != 0, 2 * int(i) + 1 >= 10 + kWordReachPx) << i;
}

TEST(WordDescriptors, SmallImagesAreDescribedWithoutHarm) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(2, 2), cv::Size(3, 2), cv::Size(5, 40)}) {
    WordDescriptors d;
    d.prepare(scene(64, 64, 3, 2)(cv::Rect({0, 0}, size)).clone(), {});
    EXPECT_EQ(d.columns(), size.width / 2);
    std::vector<float> texture(size_t(d.columns()) * kTextureDims), colour(size_t(d.columns() * kColourDims));
    std::vector<uint8_t> known(static_cast<size_t>(d.columns()));
    for (int j = 0; j < d.rows(); ++j) d.row(j, texture, colour, known);
    for (const float value : texture) EXPECT_TRUE(std::isfinite(value));
  }
}

TEST(Vocabulary, AssignsWhatFlannFindsExactly) {
  Numbers numbers(3);
  cv::Mat centres(100, 7, CV_32FC1), queries(500, 7, CV_32FC1);
  for (cv::Mat* m : {&centres, &queries})
    for (int i = 0; i < int(m->total()); ++i) m->at<float>(i / 7, i % 7) = float(numbers.within(-1000, 1000)) / 500;
  cv::Mat index, distance;
  cv::flann::Index flann(centres, cv::flann::LinearIndexParams());
  flann.knnSearch(queries, index, distance, 1);
  std::vector<uint8_t> words(500);
  Vocabulary(centres).assign({queries.ptr<float>(), queries.total()}, words);
  for (int i = 0; i < 500; ++i) EXPECT_EQ(int(words[size_t(i)]), index.at<int>(i)) << i;
}

TEST(WordHistograms, CountWhatLiesInAWindow) {
  Numbers numbers(4);
  cv::Mat words(40, 60, CV_8UC1);
  for (int i = 0; i < int(words.total()); ++i) words.at<uint8_t>(i / 60, i % 60) = uint8_t(numbers.within(0, 20));
  words.at<uint8_t>(10, 10) = kNoWord;
  WordHistograms histograms;
  histograms.prepare(words, 21);
  for (const cv::Rect& r : {cv::Rect(0, 0, 60, 40), cv::Rect(5, 7, 12, 12), cv::Rect(59, 39, 1, 1)}) {
    std::vector<uint16_t> counts(21), expected(21);
    histograms.window(r.x, r.y, r.x + r.width, r.y + r.height, counts);
    for (int y = r.y; y < r.y + r.height; ++y)
      for (int x = r.x; x < r.x + r.width; ++x)
        if (words.at<uint8_t>(y, x) != kNoWord) ++expected[words.at<uint8_t>(y, x)];
    EXPECT_EQ(counts, expected);
  }
}

}  // namespace
}  // namespace landfix::features
