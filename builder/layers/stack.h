// The epochs at coarser levels: each pixel the mean of 2x2, cut into tiles that wait in the journal for the jobs of the
// next level.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "builder/ingest/image_set.h"

namespace landfix::layers {

/// A tile of one epoch. Data: 256 rows of 256 pixels of all bands, then, where not all pixels are valid, 256 rows of
/// 256 bytes of mask (255 or 0).
struct EpochTile {
  size_t epoch = 0;  ///< index in ImageSet::epochs()
  tiles::TileIndex tile;
  std::vector<uint8_t> data;
};

/// What the epochs of a stack show in a tile one level coarser: means of 2x2 pixels, rounded half up, over those with
/// data; there is data where at least two of them have some. Children that are not `used` count as without data, and
/// epochs without data in the tile are left out.
std::vector<EpochTile> halved(const ingest::Stack& fine, const tiles::TileIndex& tile,
                              const std::function<bool(const tiles::TileIndex& child)>& used);

/// Data of an EpochTile of an epoch; nullopt: there is none.
using ReadEpochTile = std::function<std::optional<std::vector<uint8_t>>(size_t epoch, const tiles::TileIndex& tile)>;

/// Puts tiles together to what the epochs show in `rect`; `sources` of the epochs are left empty.
ingest::Stack stack_of_tiles(const tiles::PixelRect& rect, std::span<const ingest::EpochInfo> epochs,
                             const ReadEpochTile& read);

}  // namespace landfix::layers
