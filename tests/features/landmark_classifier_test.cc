// The classifier's model file under damage, its answers, and that scans say what single windows say.
#include "runtime/features/landmark_classifier.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "tests/features/draw.h"

namespace landfix::features {
namespace {

cv::Mat random_values(int rows, int columns, uint64_t seed) {
  Numbers numbers(seed);
  cv::Mat out(rows, columns, CV_32FC1);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) out.at<float>(y, x) = float(numbers.within(-1000, 1000)) / 1000;
  return out;
}

LandmarkBag drawn_bag(int colour_dims, uint64_t seed) {
  LandmarkBag bag;
  bag.texture = Vocabulary(cv::abs(random_values(20, kTextureDims, seed)));
  bag.colour = Vocabulary(3 * random_values(10, colour_dims, seed + 1));
  bag.weights = 4 * random_values(bag.features(), int(kWeightColumns), seed + 2);
  bag.bias = {-0.1f, 0.2f, 0, -0.3f, 0.1f};
  bag.platt_a = {-2, -1.5f, -2.5f, -1, -2};
  return bag;
}

LandmarkModel drawn_model() { return {drawn_bag(kColourDims, 1), drawn_bag(kGrayDims, 11)}; }

ClassifierStatus decoded(const std::vector<uint8_t>& bytes) {
  LandmarkModel model;
  return decode_model(bytes, model);
}

TEST(LandmarkModel, ComesBackAsItWas) {
  const std::vector<uint8_t> bytes = encode_model(drawn_model());
  LandmarkModel model;
  ASSERT_EQ(decode_model(bytes, model), ClassifierStatus::kOk);
  EXPECT_EQ(encode_model(model), bytes);
}

TEST(LandmarkModel, AnyCutAndAnyFlippedBitIsRefused) {
  std::vector<uint8_t> bytes = encode_model(drawn_model());
  for (size_t size = 0; size < bytes.size(); size += 1 + size / 40)
    EXPECT_NE(decoded({bytes.begin(), bytes.begin() + ptrdiff_t(size)}), ClassifierStatus::kOk) << size;
  for (size_t at = 0; at < bytes.size(); at += 1 + at / 40) {
    bytes[at] ^= uint8_t(1 << (at % 8));
    EXPECT_NE(decoded(bytes), ClassifierStatus::kOk) << at;
    bytes[at] ^= uint8_t(1 << (at % 8));
  }
  bytes.push_back(0);
  EXPECT_EQ(decoded(bytes), ClassifierStatus::kDamaged);
}

TEST(LandmarkModel, SaysWhatIsWrong) {
  std::vector<uint8_t> bytes = encode_model(drawn_model());
  bytes[8] = 2;
  EXPECT_EQ(decoded(bytes), ClassifierStatus::kOtherVersion);
  bytes[8] = 1, bytes[60] ^= 1;
  EXPECT_EQ(decoded(bytes), ClassifierStatus::kDamaged);
  bytes[0] = 'X';
  EXPECT_EQ(decoded(bytes), ClassifierStatus::kNotAModel);
}

TEST(LandmarkModel, RightChecksumsDoNotMakeWrongValuesRight) {
  LandmarkModel model = drawn_model();
  model.colour.bias[2] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(decoded(encode_model(model)), ClassifierStatus::kDamaged);
  model = drawn_model();
  model.gray.colour = Vocabulary(random_values(10, 5, 9));
  EXPECT_EQ(decoded(encode_model(model)), ClassifierStatus::kDamaged);
}

TEST(LandmarkClassifier, AScanSaysWhatSingleWindowsSay) {
  const LandmarkModel model = drawn_model();
  LandmarkClassifier classifier(model);
  for (const int channels : {1, 3}) {
    ASSERT_EQ(classifier.prepare(scene(150, 210, channels, 5), {}), ClassifierStatus::kOk);
    cv::Mat labels, confidence;
    ASSERT_EQ(classifier.scan(2, labels, confidence), ClassifierStatus::kOk);
    ASSERT_EQ(labels.size(), cv::Size(37, 52));
    for (int y = 0; y < labels.rows; ++y) {
      for (int x = 0; x < labels.cols; ++x) {
        LandmarkAnswer answer;
        const ClassifierStatus status = classifier.classify(2 * x + 1, 2 * y + 1, answer);
        if (status == ClassifierStatus::kNoData) {
          EXPECT_EQ(labels.at<uint8_t>(y, x), kNoWord);
          continue;
        }
        ASSERT_EQ(status, ClassifierStatus::kOk);
        EXPECT_EQ(labels.at<uint8_t>(y, x), uint8_t(answer.label));
        EXPECT_EQ(confidence.at<uint8_t>(y, x), uint8_t(std::lround(255 * answer.confidence)));
      }
    }
  }
}

TEST(LandmarkClassifier, ProbabilitiesAreOfWhoAloneSaysYes) {
  LandmarkBag bag = drawn_bag(kColourDims, 1);
  bag.platt_a.fill(-1), bag.platt_b.fill(0);
  // Odds e^f: 3, 1/3, 0, 0, 0 against 0.1 for "none".
  const LandmarkAnswer answer = answer_of(bag, {float(std::log(3)), -float(std::log(3)), -60, -60, -60});
  EXPECT_NEAR(answer.probability[0], 3 / (3 + 1 / 3.0 + 0.1), 1e-5);
  EXPECT_NEAR(answer.probability[5], 0.1 / (3 + 1 / 3.0 + 0.1), 1e-5);
  EXPECT_EQ(answer_of(bag, {-9, -9, -9, -9, -9}).label, LandmarkLabel::kNone);
  EXPECT_EQ(answer.label, LandmarkLabel::kBuilding);
}

TEST(LandmarkClassifier, BadImagesAndWindowsAreErrors) {
  const LandmarkModel model = drawn_model();
  LandmarkClassifier classifier(model);
  LandmarkAnswer answer;
  cv::Mat labels, confidence;
  EXPECT_EQ(classifier.classify(0, 0, answer), ClassifierStatus::kNotPrepared);
  EXPECT_EQ(classifier.prepare({}, {}), ClassifierStatus::kBadImage);
  EXPECT_EQ(classifier.prepare(cv::Mat::zeros(9, 9, CV_16UC1), {}), ClassifierStatus::kBadImage);
  EXPECT_EQ(classifier.prepare(cv::Mat::zeros(9, 9, CV_8UC3), cv::Mat::zeros(8, 9, CV_8UC1)),
            ClassifierStatus::kBadImage);
  ASSERT_EQ(classifier.prepare(cv::Mat::zeros(60, 60, CV_8UC3), cv::Mat::zeros(60, 60, CV_8UC1)),
            ClassifierStatus::kOk);
  EXPECT_EQ(classifier.classify(15, 15, answer), ClassifierStatus::kNoData);
  EXPECT_EQ(classifier.classify(31, 15, answer), ClassifierStatus::kNotPrepared);
  ASSERT_EQ(classifier.scan(2, labels, confidence), ClassifierStatus::kOk);
  EXPECT_EQ(cv::countNonZero(labels != kNoWord), 0);
}

}  // namespace
}  // namespace landfix::features
