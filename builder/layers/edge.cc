// `edge`: gradient magnitude of what the newest epoch with data shows. For correlation of edge images [Conte 2009,
// section 7.3].
#include "runtime/features/edge.h"

#include "builder/layers/registry.h"
#include "builder/layers/window.h"

namespace landfix::layers {
namespace {

class Edge final : public RasterLayer {
 public:
  const LayerInfo& info() const override { return info_; }

  TileData compute(const SourceWindow& window, const tiles::TileIndex& tile) const override {
    const tiles::PixelRect rect = pixels_of(tile, window.rect.level), wide = grown(rect, info_.halo_px);
    const Newest shown = cut(window.gray, window.rect, wide);
    if (shown.pixels.empty()) return {};
    cv::Mat all = cv::Mat::zeros(shown.pixels.size(), CV_8UC1), of_epoch;
    // One by one: where two dates meet is no edge of the ground.
    for_each_epoch(shown, [&](const cv::Mat& mine) {
      features::edge(shown.pixels, mine, of_epoch);
      all += of_epoch;
    });
    const cv::Rect region = region_of(rect, wide);
    if (cv::countNonZero(all(region)) == 0) return {};
    return {.pixels = all(region).clone(), .epochs = epochs_in(shown, region)};
  }

  TileData reduce(const std::array<TileData, 4>&) const override { return {}; }

 private:
  const LayerInfo info_ = {
      .name = "edge",
      .description =
          "1 + half the Sobel magnitude, at most 255, of gray (newest date with data) after a median of 3x3 pixels; no "
          "data where these 5x5 pixels are not all of one date; every level from the sources at its GSD",
      .format = {tiles::PixelType::kU8, 1, 0},
      .default_codec = tiles::Codec::kZstd,
      .level_rule = LevelRule::kFromSource,
      .halo_px = features::kEdgeHaloPx,
  };
};

}  // namespace

const RasterLayer& edge_layer() {
  static const Edge layer;
  return layer;
}

}  // namespace landfix::layers
