// `contour`: distance to the nearest thinned contour of what the newest epoch with data shows. For chamfer matching and
// Hough heading alignment.
#include "runtime/features/contour.h"

#include <fmt/format.h>

#include "builder/layers/registry.h"
#include "builder/layers/window.h"

namespace landfix::layers {
namespace {

class Contour final : public RasterLayer {
 public:
  const LayerInfo& info() const override { return info_; }

  TileData compute(const SourceWindow& window, const tiles::TileIndex& tile) const override {
    const tiles::PixelRect rect = pixels_of(tile, window.rect.level), wide = grown(rect, info_.halo_px);
    const Newest shown = cut(window.gray, window.rect, wide);
    if (shown.pixels.empty()) return {};
    cv::Mat mask = cv::Mat::zeros(shown.pixels.size(), CV_8UC1), known = mask.clone(), epoch_mask, epoch_known;
    // One by one: where two dates meet is no contour of the ground.
    for_each_epoch(shown, [&](const cv::Mat& mine) {
      features::contours(shown.pixels, mine, kOptions, epoch_mask, epoch_known);
      mask |= epoch_mask;
      known |= epoch_known;
    });
    cv::Mat distance;
    features::contour_distance(mask, known, kOptions, distance);
    const cv::Rect region = region_of(rect, wide);
    if (cv::countNonZero(distance(region)) == 0) return {};
    return {.pixels = distance(region).clone(), .epochs = epochs_in(shown, region)};
  }

  TileData reduce(const std::array<TileData, 4>&) const override { return {}; }

 private:
  static constexpr features::ContourOptions kOptions = {};
  const LayerInfo info_ = {
      .name = "contour",
      .description =
          "1 + the distance in pixels (0, 1, 2, 4, 6, 8 or more) to the nearest contour: thinned Sobel gradient of "
          "gray (newest date with data), in chains that are not short; every level from the sources at its GSD",
      .format = {tiles::PixelType::kU8, 1, 0},
      .default_codec = tiles::Codec::kZstd,
      .level_rule = LevelRule::kFromSource,
      .halo_px = features::contour_halo_px(kOptions),
      .parameters = {{"contrast", fmt::format("{}", kOptions.contrast)},
                     {"window_radius_px", fmt::format("{}", kOptions.window_radius_px)},
                     {"floor", fmt::format("{}", kOptions.floor)},
                     {"min_length_px", fmt::format("{}", kOptions.min_length_px)},
                     {"truncation_px", fmt::format("{}", kOptions.truncation_px)}},
  };
};

}  // namespace

const RasterLayer& contour_layer() {
  static const Contour layer;
  return layer;
}

}  // namespace landfix::layers
