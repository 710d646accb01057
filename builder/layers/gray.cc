// `gray`: what the newest epoch with data shows, as luma within 1 to 255. For normalized cross-correlation [Conte 2009,
// section 5.7].
#include "builder/layers/mean.h"
#include "builder/layers/registry.h"
#include "builder/layers/window.h"

namespace landfix::layers {
namespace {

class Gray final : public RasterLayer {
 public:
  const LayerInfo& info() const override { return info_; }

  TileData compute(const SourceWindow& window, const tiles::TileIndex& tile) const override {
    const Newest shown = cut(window.gray, window.rect, pixels_of(tile, window.rect.level));
    if (shown.pixels.empty()) return {};
    return {.pixels = shown.pixels.clone(), .epochs = epochs_in(shown, {{}, shown.pixels.size()})};
  }

  TileData reduce(const std::array<TileData, 4>& children) const override { return mean_of_children(children); }

 private:
  const LayerInfo info_ = {
      .name = "gray",
      .description =
          "luma (299 R + 587 G + 114 B + 500) / 1000 of the newest date with data, 1 to 255; coarser levels are means "
          "of 2x2 "
          "pixels, at least 2 of them with data",
      .format = {tiles::PixelType::kU8, 1, 0},
      .default_codec = tiles::Codec::kRaw,
  };
};

}  // namespace

const RasterLayer& gray_layer() {
  static const Gray layer;
  return layer;
}

}  // namespace landfix::layers
