// Images that the tests of the operators share, drawn by code.
#pragma once

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace landfix::features {

/// Numbers of a fixed sequence (splitmix64), the same on every machine.
class Numbers {
 public:
  explicit Numbers(uint64_t seed) : state_(seed) {}
  uint64_t next() {
    uint64_t z = (state_ += 0x9E3779B97F4A7C15);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EB;
    return z ^ (z >> 31);
  }
  /// Within [low, high].
  int within(int low, int high) { return low + int(next() % uint64_t(high - low + 1)); }

 private:
  uint64_t state_;
};

/// Fields, roofs and tracks: filled shapes and lines of random grays, with a little noise.
inline cv::Mat scene(int width, int height, int channels, uint64_t seed) {
  Numbers numbers(seed);
  cv::Mat image(height, width, CV_8UC(channels), cv::Scalar::all(90));
  const auto colour = [&] {
    return cv::Scalar(numbers.within(20, 230), numbers.within(20, 230), numbers.within(20, 230),
                      numbers.within(20, 230));
  };
  const auto point = [&] { return cv::Point(numbers.within(0, width - 1), numbers.within(0, height - 1)); };
  for (int i = 0; i < width * height / 1500; ++i) {
    cv::rectangle(image, {point(), cv::Size(numbers.within(4, 30), numbers.within(4, 30))}, colour(), cv::FILLED);
    if (i % 4 == 0) cv::line(image, point(), point(), colour(), numbers.within(1, 3));
    if (i % 5 == 0) cv::circle(image, point(), numbers.within(3, 12), colour(), cv::FILLED);
  }
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width * channels; ++x) {
      uint8_t& v = image.ptr<uint8_t>(y)[x];
      v = cv::saturate_cast<uint8_t>(v + numbers.within(-4, 4));
    }
  return image;
}

/// 255, with holes, a ragged edge and single pixels without data.
inline cv::Mat mask_with_holes(int width, int height, uint64_t seed) {
  Numbers numbers(seed);
  cv::Mat valid(height, width, CV_8UC1, cv::Scalar(255));
  for (int i = 0; i < 4; ++i)
    cv::circle(valid, {numbers.within(0, width), numbers.within(0, height)}, numbers.within(3, 25), cv::Scalar(0),
               cv::FILLED);
  for (int i = 0; i < 5; ++i) valid.at<uint8_t>(numbers.within(0, height - 1), numbers.within(0, width - 1)) = 0;
  return valid;
}

/// Whether two images are the same, bit for bit.
inline bool same(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) return false;
  for (int y = 0; y < a.rows; ++y)
    if (!std::equal(a.ptr<uint8_t>(y), a.ptr<uint8_t>(y) + size_t(a.cols) * a.elemSize(), b.ptr<uint8_t>(y)))
      return false;
  return true;
}

/// A rectangle of random place and size inside an image.
inline cv::Rect random_rect(cv::Size size, Numbers& numbers) {
  const int width = numbers.within(1, size.width / 2), height = numbers.within(1, size.height / 2);
  return {numbers.within(0, size.width - width), numbers.within(0, size.height - height), width, height};
}

/// `rect` with `px` more on every side, as far as the image goes.
inline cv::Rect grown(const cv::Rect& rect, int px, cv::Size size) {
  return cv::Rect(rect.x - px, rect.y - px, rect.width + 2 * px, rect.height + 2 * px) & cv::Rect({}, size);
}

}  // namespace landfix::features
