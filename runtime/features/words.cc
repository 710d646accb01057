#include "runtime/features/words.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "runtime/features/gradient.h"
#include "runtime/features/gray.h"
#include "runtime/features/vectorized.h"

namespace landfix::features {
namespace {

constexpr int kBins = 8;          // orientations
constexpr int kCell = 3;          // pixels a side
constexpr int kRing = 2 * kCell;  // rows of pixels that a row of nodes is made of
constexpr int kLogScale = 1024;   // of logarithms as integers: sums are exact
constexpr int kSurroundingsPx = 24;
constexpr uint8_t kBlack = 8;           // no channel above it: a frame without data that the file does not declare
constexpr int kAtOnce = 8, kTile = 32;  // descriptors and words that are compared at a time
constexpr int kLanes = 16;              // words are padded to whole vectors

/// ln(v + 16) of all 8-bit values, as float and in units of 1 / kLogScale.
struct Logarithms {
  std::array<float, 256> texture;
  std::array<int, 256> fixed;
  Logarithms() {
    for (int v = 0; v < 256; ++v) {
      const double l = std::log(v + 16.0);
      texture[size_t(v)] = float(64 * l);
      fixed[size_t(v)] = int(std::lround(kLogScale * l));
    }
  }
};

const Logarithms& logarithms() {
  static const Logarithms table;
  return table;
}

int mirrored(int i, int size) {
  if (i < 0) i = -i;
  if (i >= size) i = 2 * size - 2 - i;
  return std::clamp(i, 0, size - 1);
}

LANDFIX_VECTORIZED void binomial_of_5(const float* a, const float* b, const float* c, const float* d, const float* e,
                                      int width, float* out) {
  for (int x = 0; x < width; ++x) out[x] = ((a[x] + e[x]) + 4.0f * (b[x] + d[x]) + 6.0f * c[x]) * (1.0f / 16);
}

/// The binomial [1 4 6 4 1] / 16 in x and y of 64 ln(gray + 16), mirrored at the border.
cv::Mat smooth_logarithm(const cv::Mat& gray) {
  const int w = gray.cols, h = gray.rows;
  cv::Mat across(gray.size(), CV_32FC1), out(gray.size(), CV_32FC1);
  std::vector<float> line(size_t(w) + 4);
  for (int y = 0; y < h; ++y) {
    const uint8_t* in = gray.ptr<uint8_t>(y);
    for (int x = -2; x < w + 2; ++x) line[size_t(x + 2)] = logarithms().texture[in[mirrored(x, w)]];
    binomial_of_5(&line[0], &line[1], &line[2], &line[3], &line[4], w, across.ptr<float>(y));
  }
  for (int y = 0; y < h; ++y) {
    const auto row = [&](int dy) { return across.ptr<float>(mirrored(y + dy, h)); };
    binomial_of_5(row(-2), row(-1), row(0), row(1), row(2), w, out.ptr<float>(y));
  }
  return out;
}

/// Angle of an unsigned direction in units of pi / 8, within [0, 8): a polynomial for arctan, to 1e-4 of a unit, so
/// that no mathematical library decides a word.
inline float direction(float gx, float gy) {
  const float ax = std::abs(gx), ay = std::abs(gy);
  const float high = std::max(ax, ay), low = std::min(ax, ay);
  const float t = low / (high + 1e-12f), s = t * t;
  float angle = ((((0.0208351f * s - 0.0851330f) * s + 0.1801410f) * s - 0.3302995f) * s + 0.9998660f) * t;
  angle = ay > ax ? 1.5707963f - angle : angle;
  const bool second = (gx < 0) != (gy < 0);  // second and fourth quadrant: falls
  angle = second ? 3.1415927f - angle : angle;
  return angle * (kBins / 3.1415927f);
}

/// Scharr's gradient at the inner pixels of a row, its magnitude shared between the two nearest orientations.
LANDFIX_VECTORIZED void orient(const float* above, const float* here, const float* below, int width, float* magnitude,
                               float* angle) {
  for (int x = 1; x < width - 1; ++x) {
    const float gx = (3.0f * (above[x + 1] - above[x - 1]) + 10.0f * (here[x + 1] - here[x - 1]) +
                      3.0f * (below[x + 1] - below[x - 1])) *
                     (1.0f / 32);
    const float gy =
        (3.0f * (below[x - 1] - above[x - 1]) + 10.0f * (below[x] - above[x]) + 3.0f * (below[x + 1] - above[x + 1])) *
        (1.0f / 32);
    magnitude[x] = std::sqrt(gx * gx + gy * gy);
    angle[x] = direction(gx, gy);
  }
}

LANDFIX_VECTORIZED void share(const float* magnitude, const float* angle, int width, float* bins) {
  for (int x = 0; x < width; ++x) {
    for (int q = 0; q < kBins; ++q) {
      const float apart = std::abs(angle[x] - float(q));
      bins[x * kBins + q] = magnitude[x] * std::max(0.0f, 1.0f - std::min(apart, kBins - apart));
    }
  }
}

/// Sums over kCell neighbours along a row, at the place of the first.
LANDFIX_VECTORIZED void sum_across(const float* bins, int width, float* sums) {
  for (int x = 0; x + kCell <= width; ++x) {
    const float* b = bins + x * kBins;
    float* s = sums + x * kBins;
    for (int q = 0; q < kBins; ++q) s[q] = (b[q] + b[q + kBins]) + b[q + 2 * kBins];
  }
}

/// 3 rows of sums at the cell that begins at `at`, as means.
inline void add_cell(const float* a, const float* b, const float* c, int at, float* out) {
  for (int q = 0; q < kBins; ++q)
    out[q] = ((a[at * kBins + q] + b[at * kBins + q]) + c[at * kBins + q]) * (1.0f / (kCell * kCell));
}

LANDFIX_VECTORIZED void normalise(float* v, int columns) {
  for (int i = 0; i < columns; ++i, v += kTextureDims) {
    float lanes[kBins] = {};
    for (int k = 0; k < kTextureDims; k += kBins)
      for (int q = 0; q < kBins; ++q) lanes[q] += v[k + q] * v[k + q];
    float square = 0;
    for (int q = 0; q < kBins; ++q) square += lanes[q];
    const float inverse = 1.0f / (std::sqrt(square) + 3.0f);
    for (int k = 0; k < kTextureDims; ++k) v[k] = std::sqrt(v[k] * inverse);
  }
}

/// Scores of kAtOnce descriptors against all words: |centre|^2 / 2 - centre . descriptor; the smallest is the nearest.
LANDFIX_VECTORIZED void compare(const float* descriptors, int dims, const float* transposed, const float* half_squares,
                                int padded, float* scores) {
  for (int w = 0; w < padded; w += kTile) {  // as many words of as many descriptors at a time as registers hold
    float sums[kAtOnce][kTile] = {};
    for (int d = 0; d < dims; ++d) {
      const float* centre = transposed + d * padded + w;
      for (int i = 0; i < kAtOnce; ++i) {
        const float value = descriptors[i * dims + d];
        for (int l = 0; l < kTile; ++l) sums[i][l] += value * centre[l];
      }
    }
    for (int i = 0; i < kAtOnce; ++i)
      for (int l = 0; l < kTile; ++l) scores[i * padded + w + l] = half_squares[w + l] - sums[i][l];
  }
}

using Floats = float __attribute__((vector_size(kLanes * sizeof(float))));
using Indices = int __attribute__((vector_size(kLanes * sizeof(int))));

/// Index of the smallest score, the first of equals. Vectors are spelled out: compilers do not find them here.
LANDFIX_VECTORIZED int smallest(const float* scores, int padded) {
  Floats least;
  Indices here, at;
  for (int l = 0; l < kLanes; ++l) here[l] = l;
  std::memcpy(&least, scores, sizeof(least));
  at = here;
  for (int w = kLanes; w < padded; w += kLanes) {
    Floats score;
    std::memcpy(&score, scores + w, sizeof(score));
    here += kLanes;
    const Indices better = score < least;
    at = better ? here : at;
    least = better ? score : least;
  }
  int best = 0;
  for (int l = 1; l < kLanes; ++l)
    if (least[l] < least[best] || (least[l] == least[best] && at[l] < at[best])) best = l;
  return at[best];
}

LANDFIX_VECTORIZED void add_counts(const uint16_t* above, const uint16_t* along, int words, uint16_t* out) {
  for (int w = 0; w < words; ++w) out[w] = uint16_t(above[w] + along[w]);
}

LANDFIX_VECTORIZED void difference(const uint16_t* a, const uint16_t* b, const uint16_t* c, const uint16_t* d,
                                   int words, uint16_t* out) {
  for (int w = 0; w < words; ++w) out[w] = uint16_t(a[w] - b[w] - c[w] + d[w]);
}

}  // namespace

double word_gain(const cv::Mat& image, const cv::Mat& valid) {
  CV_Assert(image.type() == CV_8UC1 || image.type() == CV_8UC3);
  const cv::Mat mask = checked_mask(image, valid);
  const int channels = image.channels();
  std::vector<std::array<int64_t, 256>> counts(size_t(channels), std::array<int64_t, 256>{});
  for (int y = 0; y < image.rows; ++y) {
    const uint8_t* pixel = image.ptr<uint8_t>(y);
    const uint8_t* known = mask.ptr<uint8_t>(y);
    for (int x = 0; x < image.cols; ++x, pixel += channels)
      if (known[x] && *std::max_element(pixel, pixel + channels) > kBlack)
        for (int c = 0; c < channels; ++c) ++counts[size_t(c)][pixel[c]];
  }
  double sum = 0;
  int64_t total = 0;
  for (const auto& channel : counts) {
    for (int v = 0; v < 256; ++v) {
      sum += double(channel[size_t(v)]) * std::log(v + 8.0);
      total += channel[size_t(v)];
    }
  }
  return total > 0 ? 110 / std::exp(sum / double(total)) : 1;
}

cv::Mat with_gain(const cv::Mat& image, double gain) {
  cv::Mat table(1, 256, CV_8UC1), out;
  for (int v = 0; v < 256; ++v) table.at<uint8_t>(v) = uint8_t(std::clamp(std::floor(v * gain + 0.5), 0.0, 255.0));
  cv::LUT(image, table, out);
  return out;
}

void WordDescriptors::prepare(const cv::Mat& image, const cv::Mat& valid) {
  CV_Assert((image.type() == CV_8UC1 || image.type() == CV_8UC3) && !image.empty());
  const cv::Mat mask = checked_mask(image, valid);
  width_ = image.cols, height_ = image.rows;
  columns_ = width_ / kWordStepPx, rows_ = height_ / kWordStepPx;
  const bool colour = image.channels() == 3;
  colour_dims_ = colour ? kColourDims : kGrayDims;
  smooth_ = smooth_logarithm(gray_from_rgb(image));
  opponents_.resize(colour ? 3 : 1);
  for (cv::Mat& plane : opponents_) plane.create(image.size(), CV_32SC1);
  const auto& fixed = logarithms().fixed;
  for (int y = 0; y < height_; ++y) {
    const uint8_t* p = image.ptr<uint8_t>(y);
    int* lum = opponents_[0].ptr<int>(y);
    if (!colour) {
      for (int x = 0; x < width_; ++x) lum[x] = fixed[p[x]];
      continue;
    }
    int *red_green = opponents_[1].ptr<int>(y), *blue_yellow = opponents_[2].ptr<int>(y);
    for (int x = 0; x < width_; ++x, p += 3) {
      const int r = fixed[p[0]], g = fixed[p[1]], b = fixed[p[2]];
      lum[x] = (r + g + b + 1) / 3;
      red_green[x] = r - g;
      blue_yellow[x] = b - (r + g) / 2;
    }
  }
  cv::Mat lum_of_valid;
  opponents_[0].copyTo(lum_of_valid, mask);  // zero elsewhere: a new matrix
  lum_of_valid.convertTo(lum_of_valid, CV_32F);
  cv::integral(lum_of_valid, sum_, CV_64F);
  cv::integral(mask / 255, count_, CV_32S);
  // Beyond the border counts as mirrored, not as missing: a patch that was cut out is described to its edge.
  cv::erode(mask, known_, cv::Mat::ones(2 * kWordReachPx + 1, 2 * kWordReachPx + 1, CV_8UC1));
  ring_row_.fill(std::numeric_limits<int>::min());
  for (auto& row : ring_) row.assign(size_t(width_ + 2 * kCell) * kBins, 0);
  orientations_.assign(size_t(width_ + 2 * kCell) * kBins, 0);
}

/// Orientation sums of pixel row `y` (mirrored beyond the border) into the ring.
void WordDescriptors::fill_orientations(int y) {
  const size_t slot = size_t(y + kRing) % kRing;
  if (ring_row_[slot] == y) return;
  ring_row_[slot] = y;
  const int at = std::clamp(mirrored(y, height_), 0, height_ - 1);
  thread_local std::vector<float> magnitude, angle;
  magnitude.assign(size_t(width_) + 2 * kCell, 0);
  angle.assign(size_t(width_) + 2 * kCell, 0);
  if (width_ >= 3) {
    orient(smooth_.ptr<float>(mirrored(at - 1, height_)), smooth_.ptr<float>(at),
           smooth_.ptr<float>(mirrored(at + 1, height_)), width_, &magnitude[kCell], &angle[kCell]);
  }
  share(magnitude.data(), angle.data(), width_ + 2 * kCell, orientations_.data());
  sum_across(orientations_.data(), width_ + 2 * kCell, ring_[slot].data());
}

void WordDescriptors::describe_texture(int j, std::span<float> texture) {
  const int y = kWordStepPx * j + 1;  // the pixel below the node's corner
  for (int k = y - kCell; k < y + kCell; ++k) fill_orientations(k);
  const auto row = [&](int k) { return ring_[size_t(k + kRing) % kRing].data(); };
  float* out = texture.data();
  for (int i = 0; i < columns_; ++i, out += kTextureDims) {
    const int right = kWordStepPx * i + 1 + kCell, left = right - kCell;  // in padded columns
    add_cell(row(y - 3), row(y - 2), row(y - 1), left, out);
    add_cell(row(y - 3), row(y - 2), row(y - 1), right, out + kBins);
    add_cell(row(y), row(y + 1), row(y + 2), left, out + 2 * kBins);
    add_cell(row(y), row(y + 1), row(y + 2), right, out + 3 * kBins);
  }
  normalise(texture.data(), columns_);
}

/// Mean of lum over the valid pixels of the square around a pixel.
float WordDescriptors::surroundings(int x, int y) const {
  const int left = std::max(0, x - kSurroundingsPx / 2), right = std::min(width_, x + kSurroundingsPx / 2);
  const int top = std::max(0, y - kSurroundingsPx / 2), bottom = std::min(height_, y + kSurroundingsPx / 2);
  const double* above = sum_.ptr<double>(top);
  const double* below = sum_.ptr<double>(bottom);
  const int* count_above = count_.ptr<int>(top);
  const int* count_below = count_.ptr<int>(bottom);
  const int count = count_below[right] - count_below[left] - count_above[right] + count_above[left];
  return count > 0 ? float((below[right] - below[left] - above[right] + above[left]) / count) : 0;
}

void WordDescriptors::describe_colour(int j, std::span<float> colour) const {
  const int y = kWordStepPx * j + 1;
  const int rows[3] = {y - 1, std::min(y, height_ - 1), mirrored(y + 1, height_)};
  float* out = colour.data();
  for (int i = 0; i < columns_; ++i, out += colour_dims_) {
    const int x = kWordStepPx * i + 1;
    const int columns[3] = {x - 1, x, mirrored(x + 1, width_)};
    std::array<float, 3> mean{}, deviation{};
    for (size_t p = 0; p < opponents_.size(); ++p) {
      int sum = 0;
      int64_t squares = 0;
      for (const int r : rows) {
        const int* line = opponents_[p].ptr<int>(r);
        for (const int c : columns) sum += line[c], squares += int64_t(line[c]) * line[c];
      }
      mean[p] = float(sum) * (1.0f / (9 * kLogScale));
      deviation[p] = std::sqrt(float(9 * squares - int64_t(sum) * sum)) * (1.0f / (9 * kLogScale));
    }
    const float around = surroundings(x, y) * (1.0f / kLogScale);
    float* next = out;
    if (opponents_.size() == 3) *next++ = 4 * mean[1], *next++ = 4 * mean[2];
    *next++ = mean[0] - around;
    *next++ = 0.6f * mean[0];
    for (size_t p = 0; p < opponents_.size(); ++p) *next++ = 2 * deviation[p];
  }
}

void WordDescriptors::row(int j, std::span<float> texture, std::span<float> colour, std::span<uint8_t> known) {
  CV_Assert(j >= 0 && j < rows_ && texture.size() == size_t(columns_) * kTextureDims &&
            colour.size() == size_t(columns_) * size_t(colour_dims_) && known.size() == size_t(columns_));
  describe_texture(j, texture);
  describe_colour(j, colour);
  const uint8_t* line = known_.ptr<uint8_t>(kWordStepPx * j + 1);
  for (int i = 0; i < columns_; ++i) known[size_t(i)] = line[kWordStepPx * i + 1];
}

Vocabulary::Vocabulary(const cv::Mat& centres) : centres_(centres.clone()) {
  CV_Assert(centres.type() == CV_32FC1 && centres.rows >= 1 && centres.rows <= kMostWords && centres.cols >= 1);
  const size_t padded = size_t(centres.rows + 31) / 32 * 32;
  transposed_.assign(size_t(centres.cols) * padded, 0);
  half_squares_.assign(padded, std::numeric_limits<float>::infinity());
  for (int w = 0; w < centres.rows; ++w) {
    float square = 0;
    for (int d = 0; d < centres.cols; ++d) {
      const float value = centres.at<float>(w, d);
      transposed_[size_t(d) * padded + size_t(w)] = value;
      square += value * value;
    }
    half_squares_[size_t(w)] = square / 2;
  }
}

void Vocabulary::assign(std::span<const float> descriptors, std::span<uint8_t> words) const {
  CV_Assert(descriptors.size() == words.size() * size_t(dims()));
  const int padded = int(half_squares_.size());
  std::array<float, kAtOnce * 256> scores;
  std::vector<float> rest;
  for (size_t first = 0; first < words.size(); first += kAtOnce) {
    const size_t count = std::min(size_t(kAtOnce), words.size() - first);
    const float* from = descriptors.data() + first * size_t(dims());
    if (count < kAtOnce) {
      rest.assign(size_t(kAtOnce * dims()), 0);
      std::copy_n(from, count * size_t(dims()), rest.begin());
      from = rest.data();
    }
    compare(from, dims(), transposed_.data(), half_squares_.data(), padded, scores.data());
    for (size_t i = 0; i < count; ++i) words[first + i] = uint8_t(smallest(&scores[i * size_t(padded)], padded));
  }
}

void WordHistograms::prepare(const cv::Mat& words, int word_count) {
  CV_Assert(words.type() == CV_8UC1 && word_count >= 1 && word_count <= kMostWords);
  columns_ = words.cols, word_count_ = word_count;
  const size_t line = size_t(columns_ + 1) * size_t(word_count);
  sums_.resize(size_t(words.rows + 1) * line);
  std::fill_n(sums_.begin(), line, uint16_t(0));
  std::array<uint16_t, 256> along;
  for (int y = 0; y < words.rows; ++y) {
    along.fill(0);
    uint16_t* out = &sums_[size_t(y + 1) * line];
    std::fill_n(out, word_count, uint16_t(0));
    for (int x = 0; x < columns_; ++x) {
      const uint8_t word = words.at<uint8_t>(y, x);
      CV_Assert(word < word_count || word == kNoWord);
      if (word != kNoWord) ++along[word];
      out += word_count;
      add_counts(out - line, along.data(), word_count, out);
    }
  }
}

void WordHistograms::window(int left, int top, int right, int bottom, std::span<uint16_t> counts) const {
  const size_t words = size_t(word_count_), line = size_t(columns_ + 1) * words;
  const auto at = [&](int x, int y) { return &sums_[size_t(y) * line + size_t(x) * words]; };
  difference(at(right, bottom), at(left, bottom), at(right, top), at(left, top), word_count_, counts.data());
}

}  // namespace landfix::features
