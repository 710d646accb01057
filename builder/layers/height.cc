// `height`: metres above the WGS84 ellipsoid, 16 bits with offset and step of their own for every tile.
#include <algorithm>
#include <cmath>
#include <limits>

#include "builder/layers/registry.h"
#include "builder/layers/window.h"

namespace landfix::layers {
namespace {

constexpr int16_t kNodata = -32768;
constexpr int kLargest = 32767;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// The finest step of the series 1, 2, 5 × 10^k from 0.01 m up with which the tile's range fits into 16 bits: 0.01 m up
// to 655 m of range, 0.1 m up to 6553 m.
float step_for(double half_range_m) {
  for (double decade = 0.01;; decade *= 10)
    for (const double factor : {1.0, 2.0, 5.0})
      if (const auto step = float(decade * factor); half_range_m <= double(step) * kLargest) return step;
}

// Packs CV_64FC1 metres, NaN where there are none. The offset is a whole metre, so that flat ground packs alike
// everywhere.
TileData pack(const cv::Mat& metres) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double h : cv::Mat_<double>(metres)) {
    if (std::isnan(h)) continue;
    low = std::min(low, h);
    high = std::max(high, h);
  }
  if (low > high) return {};
  TileData tile;
  tile.value_offset = float(std::round((low + high) / 2));
  tile.value_step = step_for(std::max(high - tile.value_offset, tile.value_offset - low));
  tile.pixels = cv::Mat(metres.size(), CV_16SC1);
  for (int y = 0; y < metres.rows; ++y)
    for (int x = 0; x < metres.cols; ++x) {
      const double h = metres.at<double>(y, x);
      tile.pixels.at<int16_t>(y, x) =
          std::isnan(h) ? kNodata : int16_t(std::lround((h - double(tile.value_offset)) / double(tile.value_step)));
    }
  return tile;
}

double metres_at(const TileData& tile, int x, int y) {
  if (tile.empty()) return kNone;
  const int16_t pixel = tile.pixels.at<int16_t>(y, x);
  return pixel == kNodata ? kNone : double(tile.value_offset) + double(tile.value_step) * pixel;
}

class Height final : public RasterLayer {
 public:
  const LayerInfo& info() const override { return info_; }

  TileData compute(const SourceWindow& window, const tiles::TileIndex& tile) const override {
    const tiles::PixelRect rect = pixels_of(tile, window.rect.level), common = intersection(rect, window.rect);
    if (window.heights.pixels.empty() || common.width == 0) return {};
    const cv::Rect from = region_of(common, window.rect), to = region_of(common, rect);
    cv::Mat metres(int(rect.height), int(rect.width), CV_64FC1, cv::Scalar::all(kNone));
    for (int y = 0; y < from.height; ++y)
      for (int x = 0; x < from.width; ++x) {
        const cv::Point p(from.x + x, from.y + y);
        if (!window.heights.valid.empty() && !window.heights.valid.at<uint8_t>(p)) continue;
        const float h = window.heights.pixels.at<float>(p);
        if (std::isfinite(h)) metres.at<double>(to.y + y, to.x + x) = h;
      }
    return pack(metres);
  }

  TileData reduce(const std::array<TileData, 4>& children) const override {
    const int side = tiles::kTilePixels;
    cv::Mat metres(side, side, CV_64FC1);
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const TileData& child = children[size_t((y >= side / 2) * 2 + (x >= side / 2))];
        const int cx = x * 2 % side, cy = y * 2 % side;
        double sum = 0;
        int count = 0;
        for (const double h : {metres_at(child, cx, cy), metres_at(child, cx + 1, cy), metres_at(child, cx, cy + 1),
                               metres_at(child, cx + 1, cy + 1)})
          if (!std::isnan(h)) sum += h, ++count;
        metres.at<double>(y, x) = count >= 2 ? sum / count : kNone;
      }
    return pack(metres);
  }

 private:
  const LayerInfo info_ = {
      .name = "height",
      .description =
          "metres above the WGS84 ellipsoid, steps of 0.01 m where a tile's range is below 655 m; coarser levels are "
          "means of "
          "2x2 pixels, at least 2 of them with data",
      .format = {tiles::PixelType::kI16, 1, kNodata},
      .default_codec = tiles::Codec::kRaw,
      .input = Input::kHeights,
  };
};

}  // namespace

const RasterLayer& height_layer() {
  static const Height layer;
  return layer;
}

}  // namespace landfix::layers
