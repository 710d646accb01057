#include "runtime/features/gray.h"

#include "runtime/features/vectorized.h"

namespace landfix::features {
namespace {

inline uint8_t luma(const uint8_t* rgb) {
  return uint8_t((299u * rgb[0] + 587u * rgb[1] + 114u * rgb[2] + 500u) / 1000u);
}

// Of three and four channels apart: a stride that the compiler knows makes it a vector loop.
LANDFIX_VECTORIZED void luma_of_3(const uint8_t* in, int width, uint8_t* out) {
  for (int x = 0; x < width; ++x) out[x] = luma(in + 3 * x);
}

LANDFIX_VECTORIZED void luma_of_4(const uint8_t* in, int width, uint8_t* out) {
  for (int x = 0; x < width; ++x) out[x] = luma(in + 4 * x);
}

}  // namespace

cv::Mat gray_from_rgb(const cv::Mat& rgb) {
  const int channels = rgb.channels();
  CV_Assert(rgb.depth() == CV_8U && (channels == 1 || channels >= 3));
  if (channels == 1) return rgb.clone();
  cv::Mat gray(rgb.size(), CV_8UC1);
  for (int y = 0; y < rgb.rows; ++y) {
    const uint8_t* in = rgb.ptr<uint8_t>(y);
    uint8_t* out = gray.ptr<uint8_t>(y);
    if (channels == 3)
      luma_of_3(in, rgb.cols, out);
    else if (channels == 4)
      luma_of_4(in, rgb.cols, out);
    else
      for (int x = 0; x < rgb.cols; ++x) out[x] = luma(in + x * channels);
  }
  return gray;
}

}  // namespace landfix::features
