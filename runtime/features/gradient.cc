#include "runtime/features/gradient.h"

#include <opencv2/imgproc.hpp>
#include <vector>

#include "runtime/features/vectorized.h"

namespace landfix::features {
namespace {

// Of rows of bytes that lie one below the other.
LANDFIX_VECTORIZED void binomial_column(const uint8_t* const rows[5], int width, uint16_t* out) {
  const uint8_t *a = rows[0], *b = rows[1], *c = rows[2], *d = rows[3], *e = rows[4];
  for (int x = 0; x < width; ++x) out[x] = uint16_t(a[x] + e[x] + 4 * (b[x] + d[x]) + 6 * c[x]);
}

// Sums of 256ths of a gray level become eighths, rounded. `out[x]` is the pixel x + 2.
LANDFIX_VECTORIZED void binomial_row(const uint16_t* in, int width, int16_t* out) {
  for (int x = 0; x + 4 < width; ++x)
    out[x] = int16_t((in[x] + in[x + 4] + 4 * (in[x + 1] + in[x + 3]) + 6 * in[x + 2] + 16) >> 5);
}

// `out[x]` is the pixel x + 1 of the three rows.
LANDFIX_VECTORIZED void sobel_row(const int16_t* north, const int16_t* middle, const int16_t* south, int width,
                                  int16_t* gx, int16_t* gy) {
  for (int x = 0; x + 2 < width; ++x) {
    gx[x] = int16_t(north[x + 2] + 2 * middle[x + 2] + south[x + 2] - north[x] - 2 * middle[x] - south[x]);
    gy[x] = int16_t(south[x] + 2 * south[x + 1] + south[x + 2] - north[x] - 2 * north[x + 1] - north[x + 2]);
  }
}

}  // namespace

cv::Mat checked_mask(const cv::Mat& image, const cv::Mat& valid) {
  if (valid.empty()) return cv::Mat(image.size(), CV_8UC1, cv::Scalar(255));
  CV_Assert(valid.type() == CV_8UC1 && valid.size() == image.size());
  return valid;
}

cv::Mat eroded(const cv::Mat& valid, int radius) {
  const int side = 2 * radius + 1;
  cv::Mat out;
  if (cv::countNonZero(valid) == int(valid.total())) {  // the common case
    out = cv::Mat::zeros(valid.size(), CV_8UC1);
    if (valid.cols >= side && valid.rows >= side)
      out(cv::Rect(radius, radius, valid.cols - 2 * radius, valid.rows - 2 * radius)).setTo(255);
    return out;
  }
  cv::erode(valid > 0, out, cv::Mat::ones(side, side, CV_8UC1), {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  return out;
}

void gradient(const cv::Mat& band, cv::Mat& gx, cv::Mat& gy) {
  CV_Assert(band.type() == CV_8UC1);
  gx.create(band.size(), CV_16SC1);
  gy.create(band.size(), CV_16SC1);
  gx.setTo(0);
  gy.setTo(0);
  const int width = band.cols;
  if (width <= 2 * kGradientRadiusPx || band.rows <= 2 * kGradientRadiusPx) return;
  std::vector<uint16_t> column(static_cast<size_t>(width));
  std::vector<int16_t> smooth[3];  // rows y, y + 1, y + 2 at y mod 3; begin at the column 2
  for (auto& row : smooth) row.resize(size_t(width) - 4);
  for (int y = 2; y + 2 < band.rows; ++y) {
    const uint8_t* rows[5];
    for (int i = 0; i < 5; ++i) rows[i] = band.ptr<uint8_t>(y - 2 + i);
    binomial_column(rows, width, column.data());
    binomial_row(column.data(), width, smooth[y % 3].data());
    if (y >= 4)
      sobel_row(smooth[(y - 2) % 3].data(), smooth[(y - 1) % 3].data(), smooth[y % 3].data(), width - 4,
                gx.ptr<int16_t>(y - 1) + 3, gy.ptr<int16_t>(y - 1) + 3);
  }
}

}  // namespace landfix::features
