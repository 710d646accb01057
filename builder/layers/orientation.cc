// `orientation`: doubled-angle gradient orientation, fused over all dates of the sources, five levels.
#include <fmt/format.h>

#include "builder/layers/dated.h"
#include "builder/layers/registry.h"
#include "builder/layers/window.h"
#include "runtime/features/orientation.h"
#include "runtime/features/orientation_code.h"

namespace landfix::layers {
namespace {

class Orientation final : public RasterLayer {
 public:
  const LayerInfo& info() const override { return info_; }

  TileData compute(const SourceWindow& window, const tiles::TileIndex& tile) const override {
    DatedStack stack = dated_orientation(window.images, pixels_of(tile, window.rect.level), kOptions);
    if (stack.dates.empty()) return {};
    const features::DatedOrientation fused = features::fuse(stack.dates);
    TileData out;
    cv::Mat levels;
    features::orientation_levels(fused.ab, levels);
    features::pack_orientation(levels, fused.valid, out.pixels);
    out.epochs = std::move(stack.epochs);
    return out;
  }

  TileData reduce(const std::array<TileData, 4>&) const override { return {}; }

 private:
  static constexpr features::OrientationOptions kOptions = {};
  const LayerInfo info_ = {
      .name = "orientation",
      .description =
          "doubled-angle orientation (a, b) of the gradient, summed over the bands and averaged over the dates with "
          "data, each of five levels, in five bit planes; every level from the sources at its GSD",
      .format = {tiles::PixelType::kBit, features::kOrientationPlanes, 1},
      .default_codec = tiles::Codec::kRaw,
      .level_rule = LevelRule::kFromSource,
      .halo_px = features::kOrientationHaloPx,
      .parameters = {{"weak", fmt::format("{}", features::kWeakOrientation)},
                     {"strong", fmt::format("{}", features::kStrongOrientation)},
                     {"half_weight", fmt::format("{}", kOptions.half_weight)}},
  };
};

}  // namespace

const RasterLayer& orientation_layer() {
  static const Orientation layer;
  return layer;
}

}  // namespace landfix::layers
