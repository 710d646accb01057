// What a raster layer is: a pure function from a window of the sources to a tile, and from four tiles to their parent.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "builder/ingest/image_set.h"
#include "builder/layers/window.h"
#include "runtime/features/grid_image.h"
#include "tiles/codec.h"
#include "tiles/grid.h"

namespace landfix::layers {

/// A job computes the tiles of all layers in a block of 4x4 tiles of its level: 1024x1024 pixels.
inline constexpr int kBlockLog2 = 2;

enum class Input : uint8_t {
  kImages,   ///< the stack of epochs; base level: that of the imagery
  kHeights,  ///< the elevation model; base level: the coarser of imagery and elevation
};

enum class LevelRule : uint8_t {
  kFromChildren,  ///< a coarser tile is `reduce` of its four children
  kFromSource,    ///< every level is `compute` of a window of that level: the epochs halved again and again, each pixel
                  ///< the mean of 2x2 (see stack.h); `base_offset` must be 0
};

struct LayerInfo {
  std::string name;
  std::string description;
  tiles::TileFormat format;
  tiles::Codec default_codec = tiles::Codec::kRaw;
  Input input = Input::kImages;
  LevelRule level_rule = LevelRule::kFromChildren;
  int base_offset = 0;  ///< levels between the window and the finest tiles made of it, 0 to kBlockLog2
  int halo_px = 0;      ///< pixels of the window that `compute` wants around a tile
  int min_epochs = 1;   ///< made only where the images show at least so many
  std::vector<std::pair<std::string, std::string>> parameters = {};  ///< what decides about it, for the manifest
};

/// The sources in a rectangle of pixels of one level: at least all data of the tile asked for, with the layer's halo.
struct SourceWindow {
  tiles::PixelRect rect;
  ingest::Stack images;         ///< of `rect`; without epochs where there are no images
  Newest gray;                  ///< of `images`, one channel, at the pixels of `rect`: several layers begin with it
  features::GridImage heights;  ///< of `rect`, CV_32FC1 metres above the ellipsoid; empty pixels: no elevation
};

/// 256x256 decoded pixels of the layer's format (CV_8UC(channels), CV_16SC1, or CV_8UC1 of 32 columns: bit planes one
/// below the other); empty where there is no data at all.
struct TileData {
  cv::Mat pixels;
  float value_offset = 0, value_step = 0;  ///< of i16 pixels: value = offset + step * pixel
  std::vector<uint16_t> epochs = {};       ///< indices in ImageSet::epochs() of what went into it, ascending
  bool empty() const { return pixels.empty(); }
};

/// Stateless and deterministic: the same window or children give the same bytes, on any thread.
class RasterLayer {
 public:
  virtual ~RasterLayer() = default;
  virtual const LayerInfo& info() const = 0;
  /// The tile, `base_offset` levels above `window.rect.level`. A pixel without data has nodata in all channels.
  virtual TileData compute(const SourceWindow& window, const tiles::TileIndex& tile) const = 0;
  /// The parent of four tiles: north-west, north-east, south-west, south-east; absent ones are empty. Only for
  /// kFromChildren.
  virtual TileData reduce(const std::array<TileData, 4>& children) const = 0;
};

}  // namespace landfix::layers
