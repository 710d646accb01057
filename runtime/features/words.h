// Visual words: dense local descriptors of an image on a grid, and the nearest word of a vocabulary for each
// (DeAngelo 2016 ch. 3, bag of visual words). Map and camera compute them alike.
//
// Images are at kWordGsdM. Node (column i, row j) of the grid lies on the pixel corner (2 i + 1, 2 j + 1). Everything
// is made of integers, or of float sums in a fixed order: the same words on every machine.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

namespace landfix::features {

inline constexpr double kWordGsdM = 1.0;  ///< ground sample distance that the descriptors are made for
inline constexpr int kWordStepPx = 2;     ///< between nodes
inline constexpr int kTextureDims = 32;   ///< 2x2 cells of 3x3 pixels, 8 unsigned orientations
inline constexpr int kColourDims = 7;     ///< of an image with colours
inline constexpr int kGrayDims = 3;       ///< of one without: luminance alone
inline constexpr uint8_t kNoWord = 255;   ///< at nodes without data
inline constexpr int kMostWords = 255;    ///< of a vocabulary
inline constexpr int kWordReachPx = 7;    ///< a node without data within this distance has no word

/// Brightness differs between sensors and days, colour balance belongs to the ground: one factor for all channels,
/// 110 / G with G the geometric mean over the channels of exp(mean of ln(v + 8)) over the valid pixels that are not
/// black (a channel above 8: mosaics often have a black frame and no mask); 1 where there is none. `image`: CV_8UC1 or
/// CV_8UC3; `valid`: CV_8UC1 or empty (all valid). Throws cv::Exception for other types.
double word_gain(const cv::Mat& image, const cv::Mat& valid);

/// The image times a gain, rounded, at most 255.
cv::Mat with_gain(const cv::Mat& image, double gain);

/// Describes the nodes of an image row by row.
///
/// Texture: g = 64 ln(luma + 16), smoothed by the binomial [1 4 6 4 1] / 16 (sigma 1), Scharr / 32, magnitudes shared
/// between the two nearest of 8 unsigned orientations, means over 2x2 cells of 3x3 pixels; v / (|v| + 3), square root.
/// Colour, with L = ln(v + 16) and lum its mean over the channels: 3x3 means of 4 (R - G), 4 (B - (R + G) / 2), lum
/// less its mean over 24 m, 0.6 lum; 2 standard deviations of lum and of the two opponent channels. Gray images: the
/// three terms of lum alone.
class WordDescriptors {
 public:
  /// `image`: CV_8UC1 or CV_8UC3 (red, green, blue), with its gain; `valid`: CV_8UC1 or empty. What is
  /// needed of them is kept. Throws cv::Exception for other types or sizes.
  void prepare(const cv::Mat& image, const cv::Mat& valid);

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  int colour_dims() const { return colour_dims_; }

  /// Node row j: `texture` of columns() x kTextureDims, `colour` of columns() x colour_dims(), `known` of columns(): 0
  /// where data are missing nearby (descriptors are not defined there).
  void row(int j, std::span<float> texture, std::span<float> colour, std::span<uint8_t> known);

 private:
  void fill_orientations(int y);
  void describe_texture(int j, std::span<float> texture);
  void describe_colour(int j, std::span<float> colour) const;
  float surroundings(int x, int y) const;

  int width_ = 0, height_ = 0, columns_ = 0, rows_ = 0, colour_dims_ = kGrayDims;
  cv::Mat smooth_;                          ///< CV_32FC1, g after the binomial
  std::vector<cv::Mat> opponents_;          ///< CV_32SC1 in units of 1 / kLogScale: lum, then R - G, B - (R + G) / 2
  cv::Mat sum_, count_;                     ///< integral images of valid lum and of valid pixels, CV_64FC1 and CV_32SC1
  cv::Mat known_;                           ///< CV_8UC1, per pixel
  std::array<std::vector<float>, 6> ring_;  ///< of orientation sums over 3 pixels of a row, 8 each, by row mod 6
  std::array<int, 6> ring_row_{};
  std::vector<float> orientations_;  ///< of one row, 8 each
};

/// Centres of clusters in the space of a descriptor.
class Vocabulary {
 public:
  Vocabulary() = default;
  /// `centres`: words x dims, CV_32FC1, between 1 and kMostWords words. Throws cv::Exception otherwise.
  explicit Vocabulary(const cv::Mat& centres);

  int words() const { return centres_.rows; }
  int dims() const { return centres_.cols; }
  const cv::Mat& centres() const { return centres_; }

  /// The nearest word (Euclidean, the first of equals) of each descriptor in `descriptors` (words.size() x dims()).
  void assign(std::span<const float> descriptors, std::span<uint8_t> words) const;

 private:
  cv::Mat centres_;
  std::vector<float> transposed_;    ///< dims x padded words: one descriptor against all words at once
  std::vector<float> half_squares_;  ///< |centre|^2 / 2, infinite for padding
};

/// Histograms of words over any window of nodes in O(words), by integral images of every word.
class WordHistograms {
 public:
  /// `words`: node image CV_8UC1 of values below `word_count`, or kNoWord; at most 65535 nodes per window.
  void prepare(const cv::Mat& words, int word_count);
  /// Counts of the words in the columns [left, right) and rows [top, bottom), which lie within the image.
  void window(int left, int top, int right, int bottom, std::span<uint16_t> counts) const;

 private:
  int columns_ = 0, word_count_ = 0;
  std::vector<uint16_t> sums_;  ///< (rows + 1) x (columns + 1) x words, modulo 2^16: differences are exact
};

}  // namespace landfix::features
