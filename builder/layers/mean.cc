#include "builder/layers/mean.h"

#include <algorithm>

namespace landfix::layers {
namespace {

template <int kChannels>
cv::Mat box_mean_of(const cv::Mat& image, int side) {
  cv::Mat out(image.rows / side, image.cols / side, CV_8UC(kChannels));
  for (int y = 0; y < out.rows; ++y) {
    uint8_t* to = out.ptr<uint8_t>(y);
    for (int x = 0; x < out.cols; ++x, to += kChannels) {
      std::array<uint32_t, kChannels> sum{};
      uint32_t count = 0;
      for (int dy = 0; dy < side; ++dy) {
        const uint8_t* from = image.ptr<uint8_t>(y * side + dy) + x * side * kChannels;
        for (int dx = 0; dx < side; ++dx, from += kChannels) {
          uint32_t any = 0;
          for (int c = 0; c < kChannels; ++c) any |= from[c];
          if (!any) continue;
          ++count;
          for (int c = 0; c < kChannels; ++c) sum[size_t(c)] += from[c];
        }
      }
      const bool valid = 2 * count >= uint32_t(side * side);
      uint32_t any = 0;
      for (int c = 0; c < kChannels; ++c)
        any |= to[c] = valid ? uint8_t((sum[size_t(c)] + count / 2) / count) : uint8_t(0);
      if (valid && !any) std::fill_n(to, kChannels, uint8_t(1));
    }
  }
  return out;
}

}  // namespace

cv::Mat box_mean(const cv::Mat& image, int side) {
  CV_Assert(image.depth() == CV_8U && image.channels() <= 3);
  if (image.channels() == 1) return box_mean_of<1>(image, side);
  return image.channels() == 2 ? box_mean_of<2>(image, side) : box_mean_of<3>(image, side);
}

cv::Rect quadrant_region(int quadrant) {
  const int side = tiles::kTilePixels;
  return {(quadrant & 1) * side, quadrant / 2 * side, side, side};
}

TileData mean_of_children(const std::array<TileData, 4>& children) {
  cv::Mat mosaic;
  for (int q = 0; q < 4; ++q) {
    const cv::Mat& child = children[size_t(q)].pixels;
    if (child.empty()) continue;
    if (mosaic.empty()) mosaic = cv::Mat(2 * child.rows, 2 * child.cols, child.type(), cv::Scalar::all(0));
    child.copyTo(mosaic(quadrant_region(q)));
  }
  if (mosaic.empty()) return {};
  const cv::Mat pixels = box_mean(mosaic, 2);
  return cv::countNonZero(pixels.reshape(1)) ? TileData{.pixels = pixels} : TileData{};
}

}  // namespace landfix::layers
