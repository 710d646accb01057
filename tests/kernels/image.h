// Images of -1, 0 and 1 for the tests of kernels, and the sums that they must give, by the definition.
#pragma once

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include "runtime/kernels/correlate.h"

namespace landfix::tests {

/// Channels of width x height pixels, in value and as planes.
class Image {
 public:
  /// Every pixel by `value(channel, column, row)`. Rows of planes are `spare_words` longer than they need to be, and
  /// hold ones there, which no kernel may look at.
  template <typename Value>
  Image(int channels, int width, int height, Value value, int spare_words = 0)
      : channels_(channels), width_(width), height_(height) {
    const int row_words = kernels::words_for(width) + spare_words;
    for (int c = 0; c < channels; ++c) {
      std::vector<int8_t>& pixels = pixels_.emplace_back();
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) pixels.push_back(int8_t(value(c, x, y)));
      for (const int sign : {1, -1}) words_.push_back(pack(pixels, sign, row_words));
    }
    for (const auto& words : words_) planes_.push_back({words.data(), width, height, row_words});
  }

  int width() const { return width_; }
  int height() const { return height_; }
  int channels() const { return channels_; }
  int at(int channel, int x, int y) const { return pixels_[size_t(channel)][size_t(y) * size_t(width_) + size_t(x)]; }
  /// +1 and -1 of each channel in turn.
  const std::vector<kernels::PlaneView>& planes() const { return planes_; }

 private:
  std::vector<uint64_t> pack(const std::vector<int8_t>& pixels, int sign, int row_words) const {
    std::vector<uint64_t> words;
    for (int y = 0; y < height_; ++y) {
      for (int k = 0; k < row_words; ++k) {
        uint64_t word = k < kernels::words_for(width_) ? 0 : ~uint64_t{0};
        for (int x = 64 * k; x < std::min(width_, 64 * k + 64); ++x)
          word |= uint64_t{pixels[size_t(y) * size_t(width_) + size_t(x)] == sign} << (x % 64);
        words.push_back(word);
      }
    }
    return words;
  }

  int channels_, width_, height_;
  std::vector<std::vector<int8_t>> pixels_;
  std::vector<std::vector<uint64_t>> words_;
  std::vector<kernels::PlaneView> planes_;
};

/// A share `density` of the pixels is +1 or -1, by equal chance.
inline Image random_image(int channels, int width, int height, double density, std::mt19937& random,
                          int spare_words = 0) {
  const auto value = [&](int, int, int) {
    if (double(random()) >= density * 0x1p32) return 0;
    return random() & 1 ? 1 : -1;
  };
  return Image(channels, width, height, value, spare_words);
}

/// The sum of products at one place of the patch, pixel by pixel.
inline int32_t sum_at(const Image& window, const Image& patch, int x, int y) {
  int32_t sum = 0;
  for (int c = 0; c < patch.channels(); ++c)
    for (int v = 0; v < patch.height(); ++v)
      for (int u = 0; u < patch.width(); ++u) sum += window.at(c, x + u, y + v) * patch.at(c, u, v);
  return sum;
}

}  // namespace landfix::tests
