// What stands in a window of an image: bag of visual words and linear support vector machines with calibrated
// probabilities (DeAngelo 2016 ch. 3; Platt 1999). The same from map and camera.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "runtime/features/words.h"

namespace landfix::features {

/// The first five as tiles::LandmarkClass.
enum class LandmarkLabel : uint8_t { kBuilding, kField, kTree, kWater, kPaved, kNone };
inline constexpr size_t kLandmarkLabels = 6;  ///< kNone included
inline constexpr size_t kTrainedLabels = 5;   ///< kNone is where no machine says yes
inline constexpr size_t kWeightColumns = 8;   ///< of which the last three are zero: whole vectors
inline constexpr std::array<const char*, kLandmarkLabels> kLandmarkLabelNames = {"building", "field", "tree",
                                                                                 "water",    "paved", "none"};
/// Nodes a side of the two squares around a window's centre whose words are counted: 12 m and 24 m.
inline constexpr std::array<int, 2> kPoolingNodes = {6, 12};

enum class ClassifierStatus : uint8_t {
  kOk,
  kNotAModel,     ///< the bytes do not begin as a model does
  kOtherVersion,  ///< a model of a version that this program does not read
  kDamaged,       ///< truncated, longer than it says, checksum wrong, or values that cannot be
  kBadImage,      ///< empty, or of a type other than CV_8UC1 and CV_8UC3, or a mask that does not fit
  kNoData,        ///< fewer than half of the window's nodes have words
  kNotPrepared,   ///< no image, or an index outside of it
  kInternal,      ///< a library failed, or memory ran out
};
const char* to_text(ClassifierStatus status);

/// Sizes of a classifier for one kind of image.
struct LandmarkBag {
  Vocabulary texture, colour;
  /// (2 squares x (texture words + colour words)) x kWeightColumns, CV_32FC1: weights of the unit-norm histogram, in
  /// the order texture 12 m, texture 24 m, colour 12 m, colour 24 m.
  cv::Mat weights;
  std::array<float, kTrainedLabels> bias{};
  /// Platt: probability = 1 / (1 + exp(a f + b)) of a machine's value f.
  std::array<float, kTrainedLabels> platt_a{}, platt_b{};

  int features() const { return int(kPoolingNodes.size()) * (texture.words() + colour.words()); }
};

/// Vocabularies, weights and calibration, for images with colours and for gray ones.
struct LandmarkModel {
  LandmarkBag colour, gray;
};

/// A model as a file. Magic "LFLMARK\n", u32 version, u32 length of all, BLAKE2b-256 of what follows; then for either
/// bag the u16 words of texture and colour, u16 dims of either, and its values as little-endian float32.
std::vector<uint8_t> encode_model(const LandmarkModel& model);

/// The inverse. Never reads outside of `bytes`; `model` is unchanged unless the status is kOk.
ClassifierStatus decode_model(std::span<const uint8_t> bytes, LandmarkModel& model) noexcept;

/// What a window shows.
struct LandmarkAnswer {
  std::array<float, kLandmarkLabels> probability{};  ///< sum 1
  LandmarkLabel label = LandmarkLabel::kNone;        ///< the most probable
  float confidence = 0;                              ///< its probability
};

/// Unit-norm histogram of a window from the counts of its words, in the order of LandmarkBag::weights. False where
/// fewer than half of a square's nodes have words.
bool pooled(std::span<const uint16_t> counts, const LandmarkBag& bag, std::span<float> histogram);

/// Values of the machines for a histogram.
std::array<float, kTrainedLabels> values_of(const LandmarkBag& bag, std::span<const float> histogram);

/// Probabilities from the machines' values. Each says yes or no on its own; at most one may be right: the probability
/// of a label is that it alone says yes, that of kNone a tenth of that none does (machines hesitate more in cities that
/// they have not seen than there is ground of no class), and they are scaled to sum 1.
LandmarkAnswer answer_of(const LandmarkBag& bag, const std::array<float, kTrainedLabels>& values);

/// Classifies windows of an image. Preparing and scanning allocate; single windows do not.
class LandmarkClassifier {
 public:
  explicit LandmarkClassifier(const LandmarkModel& model) : model_(model) {}

  /// Finds the words of an image at kWordGsdM, CV_8UC1 or CV_8UC3 (red, green, blue); `valid`: CV_8UC1, 0 where there
  /// is no data, or empty. Brightness is evened out over the whole image first, unless `even` is false.
  ClassifierStatus prepare(const cv::Mat& image, const cv::Mat& valid, bool even = true) noexcept;

  int columns() const { return texture_.cols; }  ///< nodes; their places: words.h
  int rows() const { return texture_.rows; }
  const cv::Mat& texture_words() const { return texture_; }  ///< CV_8UC1, kNoWord where there is no data
  const cv::Mat& colour_words() const { return colour_; }
  const LandmarkBag& bag() const { return is_gray_ ? model_.gray : model_.colour; }

  /// Histogram of the window whose centre lies at the corner between nodes (column - 1, row - 1) and (column, row): the
  /// pixel corner (2 column, 2 row). Parts beyond the image do not count.
  ClassifierStatus histogram(int column, int row, std::span<float> out) noexcept;
  ClassifierStatus classify(int column, int row, LandmarkAnswer& answer) noexcept;

  /// Windows all over the image, `step` nodes apart: the window of pixel (x, y) of the result has its centre in the
  /// middle of the square of step x step nodes that the pixel covers. `labels`: CV_8UC1 of LandmarkLabel, kNoWord where
  /// there is no data; `confidence`: CV_8UC1, 255 for 1; both rows() / step x columns() / step.
  ClassifierStatus scan(int step, cv::Mat& labels, cv::Mat& confidence) noexcept;

 private:
  void find_words(const cv::Mat& image, const cv::Mat& valid, bool even);
  void scan_band(int step, int first, int last, cv::Mat& labels, cv::Mat& confidence);

  const LandmarkModel& model_;
  bool is_gray_ = false;
  WordDescriptors descriptors_;
  cv::Mat texture_, colour_;
  std::vector<float> texture_row_, colour_row_, histogram_;
  std::vector<uint8_t> known_;
  std::vector<uint16_t> counts_;
  std::array<WordHistograms, 2> integrals_;
};

}  // namespace landfix::features
