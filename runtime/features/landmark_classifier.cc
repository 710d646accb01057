#include "runtime/features/landmark_classifier.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "runtime/features/vectorized.h"

namespace landfix::features {
namespace {

constexpr int kBandRows = 32;  ///< rows of nodes that a scan keeps integral histograms of, besides the windows' reach
constexpr int kReach = kPoolingNodes.back() / 2;
constexpr double kNoneOdds = 0.1;  ///< that none of the labels fits where each machine is of two minds
constexpr int kMostCounts = kPoolingNodes.back() * kPoolingNodes.back();

/// Square roots of counts: a histogram is a thousand of them.
const std::array<float, kMostCounts + 1>& roots() {
  static const auto table = [] {
    std::array<float, kMostCounts + 1> t{};
    for (size_t i = 0; i < t.size(); ++i) t[i] = std::sqrt(float(i));
    return t;
  }();
  return table;
}

/// One of the four histograms, with norm 1/2, so that together they have norm 1.
bool pool_one(std::span<const uint16_t> counts, int nodes, float* out) {
  int total = 0;
  for (const uint16_t count : counts) total += count;
  if (2 * total < nodes * nodes) return false;
  const float scale = 0.5f / std::sqrt(float(total));
  for (size_t w = 0; w < counts.size(); ++w) out[w] = roots()[counts[w]] * scale;
  return true;
}

using Columns = float __attribute__((vector_size(kWeightColumns * sizeof(float))));

/// Sums over the features in two interleaved runs: fixed order, short chains. `weights`: kWeightColumns a feature.
/// Vectors are spelled out: compilers do not find them here.
LANDFIX_VECTORIZED void multiply(const float* histogram, const float* weights, int features, float* values) {
  Columns even{}, odd{}, w;
  for (int f = 0; f + 1 < features; f += 2, weights += 2 * kWeightColumns) {
    std::memcpy(&w, weights, sizeof(w));
    even += histogram[f] * w;
    std::memcpy(&w, weights + kWeightColumns, sizeof(w));
    odd += histogram[f + 1] * w;
  }
  even += odd;
  for (size_t k = 0; k < kTrainedLabels; ++k) values[k] = even[k];
}

void count_words(const cv::Mat& words, const cv::Rect& window, std::span<uint16_t> counts) {
  std::fill(counts.begin(), counts.end(), uint16_t(0));
  for (int y = window.y; y < window.y + window.height; ++y) {
    const uint8_t* row = words.ptr<uint8_t>(y);
    for (int x = window.x; x < window.x + window.width; ++x)
      if (row[x] != kNoWord) ++counts[row[x]];
  }
}

/// The square of `nodes` nodes around a corner between nodes, within an image.
cv::Rect window_at(int column, int row, int nodes, const cv::Size& size) {
  return cv::Rect(column - nodes / 2, row - nodes / 2, nodes, nodes) & cv::Rect({0, 0}, size);
}

}  // namespace

const char* to_text(ClassifierStatus status) {
  switch (status) {
    case ClassifierStatus::kOk:
      return "done";
    case ClassifierStatus::kNotAModel:
      return "not a landmark model; `landfix train` makes one";
    case ClassifierStatus::kOtherVersion:
      return "a landmark model of another version; train it again with this version of landfix";
    case ClassifierStatus::kDamaged:
      return "the landmark model is damaged; copy or train it again";
    case ClassifierStatus::kBadImage:
      return "not an 8-bit image with one or three channels and a mask of its size";
    case ClassifierStatus::kNoData:
      return "too little of the window has data";
    case ClassifierStatus::kNotPrepared:
      return "no image was prepared, or the window lies outside of it";
    case ClassifierStatus::kInternal:
      return "a library failed or memory ran out";
  }
  return "unknown";
}

bool pooled(std::span<const uint16_t> counts, const LandmarkBag& bag, std::span<float> histogram) {
  size_t at = 0;
  for (const int words : {bag.texture.words(), bag.colour.words()}) {
    for (const int nodes : kPoolingNodes) {
      if (!pool_one(counts.subspan(at, size_t(words)), nodes, histogram.data() + at)) return false;
      at += size_t(words);
    }
  }
  return true;
}

std::array<float, kTrainedLabels> values_of(const LandmarkBag& bag, std::span<const float> histogram) {
  std::array<float, kTrainedLabels> values;
  multiply(histogram.data(), bag.weights.ptr<float>(), bag.features(), values.data());
  for (size_t k = 0; k < kTrainedLabels; ++k) values[k] += bag.bias[k];
  return values;
}

LandmarkAnswer answer_of(const LandmarkBag& bag, const std::array<float, kTrainedLabels>& values) {
  // Odds that a machine says yes; relative to "none says yes" its label alone has just these, were all labels alike.
  LandmarkAnswer answer;
  double total = kNoneOdds;
  std::array<double, kTrainedLabels> odds;
  for (size_t k = 0; k < kTrainedLabels; ++k) {
    odds[k] = std::exp(std::clamp(-(double(bag.platt_a[k]) * values[k] + bag.platt_b[k]), -50.0, 50.0));
    total += odds[k];
  }
  for (size_t k = 0; k < kTrainedLabels; ++k) answer.probability[k] = float(odds[k] / total);
  answer.probability[size_t(LandmarkLabel::kNone)] = float(kNoneOdds / total);
  const auto best = std::max_element(answer.probability.begin(), answer.probability.end());
  answer.label = LandmarkLabel(best - answer.probability.begin());
  answer.confidence = *best;
  return answer;
}

ClassifierStatus LandmarkClassifier::prepare(const cv::Mat& image, const cv::Mat& valid, bool even) noexcept {
  texture_.release();
  colour_.release();
  if (image.empty() || (image.type() != CV_8UC1 && image.type() != CV_8UC3) ||
      (!valid.empty() && (valid.type() != CV_8UC1 || valid.size() != image.size())))
    return ClassifierStatus::kBadImage;
  try {
    find_words(image, valid, even);
    return ClassifierStatus::kOk;
  } catch (...) {
    texture_.release();
    colour_.release();
    return ClassifierStatus::kInternal;
  }
}

void LandmarkClassifier::find_words(const cv::Mat& image, const cv::Mat& valid, bool even) {
  is_gray_ = image.channels() == 1;
  descriptors_.prepare(even ? with_gain(image, word_gain(image, valid)) : image, valid);
  const size_t columns = size_t(descriptors_.columns());
  texture_row_.resize(columns * kTextureDims);
  colour_row_.resize(columns * size_t(descriptors_.colour_dims()));
  known_.resize(columns);
  counts_.resize(size_t(bag().features()));
  histogram_.resize(counts_.size());
  texture_.create(descriptors_.rows(), descriptors_.columns(), CV_8UC1);
  colour_.create(texture_.size(), CV_8UC1);
  for (int j = 0; j < texture_.rows; ++j) {
    descriptors_.row(j, texture_row_, colour_row_, known_);
    const std::span<uint8_t> texture(texture_.ptr<uint8_t>(j), columns), colour(colour_.ptr<uint8_t>(j), columns);
    bag().texture.assign(texture_row_, texture);
    bag().colour.assign(colour_row_, colour);
    for (size_t i = 0; i < columns; ++i)
      if (!known_[i]) texture[i] = colour[i] = kNoWord;
  }
}

ClassifierStatus LandmarkClassifier::histogram(int column, int row, std::span<float> out) noexcept {
  if (texture_.empty() || column < 0 || row < 0 || column > texture_.cols || row > texture_.rows ||
      out.size() != size_t(bag().features()))
    return ClassifierStatus::kNotPrepared;
  size_t at = 0;
  for (const auto& [words, vocabulary] : {std::pair(&texture_, &bag().texture), std::pair(&colour_, &bag().colour)}) {
    for (const int nodes : kPoolingNodes) {
      const size_t count = size_t(vocabulary->words());
      count_words(*words, window_at(column, row, nodes, words->size()), std::span(counts_).subspan(at, count));
      at += count;
    }
  }
  return pooled(counts_, bag(), out) ? ClassifierStatus::kOk : ClassifierStatus::kNoData;
}

ClassifierStatus LandmarkClassifier::classify(int column, int row, LandmarkAnswer& answer) noexcept {
  const ClassifierStatus status = histogram(column, row, histogram_);
  if (status == ClassifierStatus::kOk) answer = answer_of(bag(), values_of(bag(), histogram_));
  return status;
}

ClassifierStatus LandmarkClassifier::scan(int step, cv::Mat& labels, cv::Mat& confidence) noexcept {
  if (texture_.empty() || step < 1) return ClassifierStatus::kNotPrepared;
  try {
    labels.create(texture_.rows / step, texture_.cols / step, CV_8UC1);
    confidence.create(labels.size(), CV_8UC1);
    const int band = std::max(1, kBandRows / step);
    for (int first = 0; first < labels.rows; first += band)
      scan_band(step, first, std::min(first + band, labels.rows), labels, confidence);
    return ClassifierStatus::kOk;
  } catch (...) {
    return ClassifierStatus::kInternal;
  }
}

/// Rows [first, last) of the result.
void LandmarkClassifier::scan_band(int step, int first, int last, cv::Mat& labels, cv::Mat& confidence) {
  const int top = std::max(0, first * step + step / 2 - kReach);
  const int bottom = std::min(texture_.rows, (last - 1) * step + step / 2 + kReach);
  const LandmarkBag& b = bag();
  const std::array<int, 2> words = {b.texture.words(), b.colour.words()};
  integrals_[0].prepare(texture_.rowRange(top, bottom), words[0]);
  integrals_[1].prepare(colour_.rowRange(top, bottom), words[1]);
  for (int y = first; y < last; ++y) {
    for (int x = 0; x < labels.cols; ++x) {
      size_t at = 0;
      for (size_t v = 0; v < integrals_.size(); ++v) {
        for (const int nodes : kPoolingNodes) {
          const cv::Rect w = window_at(x * step + step / 2, y * step + step / 2, nodes, texture_.size());
          integrals_[v].window(w.x, w.y - top, w.x + w.width, w.y + w.height - top,
                               std::span(counts_).subspan(at, size_t(words[v])));
          at += size_t(words[v]);
        }
      }
      uint8_t& label = labels.at<uint8_t>(y, x);
      uint8_t& sure = confidence.at<uint8_t>(y, x);
      label = kNoWord, sure = 0;
      if (!pooled(counts_, b, histogram_)) continue;
      const LandmarkAnswer answer = answer_of(b, values_of(b, histogram_));
      label = uint8_t(answer.label);
      sure = uint8_t(std::lround(255 * answer.confidence));
    }
  }
}

}  // namespace landfix::features
