#include "builder/terrain/texture.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "builder/error.h"

namespace landfix::terrain {
namespace {

constexpr int kSmallestLevelPx = 2;

/// Halves a level; an odd last row or column is completed by pixels without data.
features::GridImage halved(const features::GridImage& fine) {
  features::GridImage padded = fine;
  const int right = fine.pixels.cols % 2, bottom = fine.pixels.rows % 2;
  cv::copyMakeBorder(fine.pixels, padded.pixels, 0, bottom, 0, right, cv::BORDER_REPLICATE);
  cv::copyMakeBorder(fine.valid, padded.valid, 0, bottom, 0, right, cv::BORDER_CONSTANT, 0);
  features::GridImage coarse = padded;
  coarse.gsd_m = 2 * fine.gsd_m;
  const cv::Size size(padded.pixels.cols / 2, padded.pixels.rows / 2);
  cv::resize(padded.pixels, coarse.pixels, size, 0, 0, cv::INTER_AREA);
  cv::Mat share;  // 255 only where the mean of four is: all four hold data
  cv::resize(padded.valid, share, size, 0, 0, cv::INTER_AREA);
  cv::compare(share, 255, coarse.valid, cv::CMP_EQ);
  return coarse;
}

/// Bilinear value of one level; false where a texel with weight holds no data or lies outside.
bool bilinear(const features::GridImage& level, double east_m, double north_m, float* value) {
  const double column = level.column_of(east_m), row = level.row_of(north_m);
  const int width = level.pixels.cols, height = level.pixels.rows;
  // Half a texel beyond the outer centres still lies on the image: there the border texel counts alone.
  if (!(column >= -0.5 && row >= -0.5 && column <= width - 0.5 && row <= height - 0.5)) return false;
  const double x = std::clamp(column, 0.0, width - 1.0), y = std::clamp(row, 0.0, height - 1.0);
  const int x0 = std::min(int(x), std::max(0, width - 2)), y0 = std::min(int(y), std::max(0, height - 2));
  const int x1 = std::min(x0 + 1, width - 1), y1 = std::min(y0 + 1, height - 1);
  const uchar *mask0 = level.valid.ptr<uchar>(y0), *mask1 = level.valid.ptr<uchar>(y1);
  if (!(mask0[x0] & mask0[x1] & mask1[x0] & mask1[x1])) return false;
  const float fx = float(x - x0), fy = float(y - y0);
  const int channels = level.pixels.channels();
  const uchar *row0 = level.pixels.ptr<uchar>(y0), *row1 = level.pixels.ptr<uchar>(y1);
  for (int c = 0; c < channels; ++c) {
    const float top = (1 - fx) * row0[x0 * channels + c] + fx * row0[x1 * channels + c];
    const float bottom = (1 - fx) * row1[x0 * channels + c] + fx * row1[x1 * channels + c];
    value[c] = (1 - fy) * top + fy * bottom;
  }
  return true;
}

}  // namespace

Texture::Texture(const features::GridImage& ortho) {
  const int type = ortho.pixels.type();
  if (ortho.pixels.empty() || (type != CV_8UC1 && type != CV_8UC3)) {
    throw Error(ExitCode::kBadInput, "scene texture: expected a non-empty 8-bit image of 1 or 3 channels, found " +
                                         std::string(ortho.pixels.empty() ? "none" : cv::typeToString(type)));
  }
  levels_.push_back(ortho);
  if (ortho.valid.empty()) levels_.front().valid = cv::Mat(ortho.pixels.size(), CV_8UC1, cv::Scalar(255));
  while (std::min(levels_.back().pixels.cols, levels_.back().pixels.rows) > kSmallestLevelPx) {
    levels_.push_back(halved(levels_.back()));
  }
}

bool Texture::sample(double east_m, double north_m, double footprint_m, float* value) const {
  const double level = std::clamp(std::log2(footprint_m / base().gsd_m), 0.0, double(levels_.size() - 1));
  const size_t fine = size_t(level);
  const float share = float(level - double(fine));
  if (!bilinear(levels_[fine], east_m, north_m, value)) return false;
  if (share == 0) return true;
  float coarse[3];
  if (!bilinear(levels_[fine + 1], east_m, north_m, coarse)) return false;
  for (int c = 0; c < channels(); ++c) value[c] += share * (coarse[c] - value[c]);
  return true;
}

}  // namespace landfix::terrain
