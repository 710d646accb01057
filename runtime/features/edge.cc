#include "runtime/features/edge.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "runtime/features/gradient.h"
#include "runtime/features/vectorized.h"

namespace landfix::features {
namespace {

constexpr int kLargest = 254;

// `out[x]` is the pixel x + 1 of the three rows.
LANDFIX_VECTORIZED void magnitude_row(const uint8_t* north, const uint8_t* middle, const uint8_t* south, int width,
                                      uint8_t* out) {
  for (int x = 0; x + 2 < width; ++x) {
    const int gx = north[x + 2] + 2 * middle[x + 2] + south[x + 2] - north[x] - 2 * middle[x] - south[x];
    const int gy = south[x] + 2 * south[x + 1] + south[x + 2] - north[x] - 2 * north[x + 1] - north[x + 2];
    // Rounding of a square root is exact by IEEE 754.
    const int half = int(std::sqrt(float(gx * gx + gy * gy)) * 0.5f + 0.5f);
    out[x] = uint8_t(1 + std::min(half, kLargest));
  }
}

}  // namespace

void edge(const cv::Mat& gray, const cv::Mat& valid, cv::Mat& magnitude) {
  CV_Assert(gray.type() == CV_8UC1);
  const cv::Mat known = eroded(checked_mask(gray, valid), kEdgeHaloPx);
  cv::Mat median;
  cv::medianBlur(gray, median, 3);
  cv::Mat out = cv::Mat::zeros(gray.size(), CV_8UC1);
  for (int y = 1; y + 1 < gray.rows; ++y)
    magnitude_row(median.ptr<uint8_t>(y - 1), median.ptr<uint8_t>(y), median.ptr<uint8_t>(y + 1), gray.cols,
                  out.ptr<uint8_t>(y) + 1);
  cv::bitwise_and(out, known, magnitude);
}

}  // namespace landfix::features
