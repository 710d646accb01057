// `overview`: colours for people, from four times the imagery's GSD up.
#include "builder/layers/mean.h"
#include "builder/layers/registry.h"
#include "builder/layers/window.h"

namespace landfix::layers {
namespace {

class Overview final : public RasterLayer {
 public:
  const LayerInfo& info() const override { return info_; }

  TileData compute(const SourceWindow& window, const tiles::TileIndex& tile) const override {
    Newest fine = newest(window.images, pixels_of(tile, window.rect.level), 3);
    if (fine.pixels.empty()) return {};
    const cv::Mat pixels = box_mean(fine.pixels, 1 << info_.base_offset);
    if (cv::countNonZero(pixels.reshape(1)) == 0) return {};
    return {.pixels = pixels, .epochs = std::move(fine.epochs)};
  }

  TileData reduce(const std::array<TileData, 4>& children) const override { return mean_of_children(children); }

 private:
  const LayerInfo info_ = {
      .name = "overview",
      .description =
          "red, green, blue of the newest date with data (near infrared, red, green where there is no blue), means "
          "over boxes "
          "of pixels, at least half of them with data",
      .format = {tiles::PixelType::kU8, 3, 0},
      .default_codec = tiles::Codec::kJpeg,
      .base_offset = 2,
  };
};

}  // namespace

const RasterLayer& overview_layer() {
  static const Overview layer;
  return layer;
}

}  // namespace landfix::layers
