// `agreement`: how much the dates of the sources agree about orientation, on a coarse grid. For navigability and for
// weights.
//
// The value is a share, |sum of vectors| / sum of |vectors|, and not normalised by the number of dates: dates that have
// nothing to do with each other still give the length of a random walk, for vectors of one length 0.64 of two dates,
// 0.52 of three, 0.45 of four and 0.40 of five (values 163, 134, 115 and 103), and more where the lengths differ.
// Compare values of equal numbers of dates only, which the second channel tells, or (s - c) / (1 - c), where s is the
// share and c what chance gives for the number of dates.
#include <algorithm>
#include <iterator>

#include "builder/layers/dated.h"
#include "builder/layers/mean.h"
#include "builder/layers/registry.h"
#include "builder/layers/window.h"

namespace landfix::layers {
namespace {

class Agreement final : public RasterLayer {
 public:
  const LayerInfo& info() const override { return info_; }

  TileData compute(const SourceWindow& window, const tiles::TileIndex& tile) const override {
    const tiles::PixelRect rect = pixels_of(tile, window.rect.level);
    cv::Mat pixels = cv::Mat::zeros(tiles::kTilePixels, tiles::kTilePixels, CV_8UC2);
    std::vector<uint16_t> epochs;
    // In strips: the whole rectangle of every date at once would be a hundred megabytes.
    const int block = 1 << info_.base_offset;
    for (int row = 0; row < tiles::kTilePixels; row += kStripRows) {
      const tiles::PixelRect strip{rect.level, rect.column, rect.row + row * block, rect.width, kStripRows * block};
      const DatedStack stack = dated_orientation(window.images, strip, {});
      if (stack.dates.size() < 2) continue;
      cv::Mat part;
      features::agreement(stack.dates, block, part);
      part.copyTo(pixels.rowRange(row, row + kStripRows));
      std::vector<uint16_t> both;
      std::set_union(epochs.begin(), epochs.end(), stack.epochs.begin(), stack.epochs.end(), std::back_inserter(both));
      epochs.swap(both);
    }
    if (cv::countNonZero(pixels.reshape(1)) == 0) return {};
    return {.pixels = pixels, .epochs = std::move(epochs)};
  }

  TileData reduce(const std::array<TileData, 4>& children) const override { return mean_of_children(children); }

 private:
  static constexpr int kStripRows = 64;
  const LayerInfo info_ = {
      .name = "agreement",
      .description =
          "first channel: 1 to 255, agreement of the dates' orientations over boxes of 4x4 pixels, |sum of vectors| / "
          "sum of |vectors|; second: number of dates; means over 2x2 pixels at coarser levels",
      .format = {tiles::PixelType::kU8, 2, 0},
      .default_codec = tiles::Codec::kZstd,
      .base_offset = 2,
      .halo_px = features::kOrientationHaloPx,
      .min_epochs = 2,
  };
};

}  // namespace

const RasterLayer& agreement_layer() {
  static const Agreement layer;
  return layer;
}

}  // namespace landfix::layers
