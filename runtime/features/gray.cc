#include "runtime/features/gray.h"

namespace landfix::features {

cv::Mat gray_from_rgb(const cv::Mat& rgb) {
  const int channels = rgb.channels();
  CV_Assert(rgb.depth() == CV_8U && (channels == 1 || channels >= 3));
  if (channels == 1) return rgb.clone();
  cv::Mat gray(rgb.size(), CV_8UC1);
  for (int y = 0; y < rgb.rows; ++y) {
    const uint8_t* in = rgb.ptr<uint8_t>(y);
    uint8_t* out = gray.ptr<uint8_t>(y);
    for (int x = 0; x < rgb.cols; ++x, in += channels)
      out[x] = uint8_t((299u * in[0] + 587u * in[1] + 114u * in[2] + 500u) / 1000u);
  }
  return gray;
}

}  // namespace landfix::features
