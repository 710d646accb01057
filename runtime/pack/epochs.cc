// How old the map is: which capture dates went into the tiles of a place.
#include <algorithm>

#include "runtime/pack/queries.h"

namespace landfix::pack {

lf_status tile_epochs(const lf_pack& pack, uint32_t layer_index, const tiles::TileIndex& index,
                      std::span<const uint16_t>& epochs) {
  if (layer_index >= pack.layer_count) return LF_INVALID_ARGUMENT;
  const Level* level = pack.layers[layer_index].find_level(index.level);
  if (level == nullptr) return LF_INVALID_ARGUMENT;
  size_t slot;
  const schema::TileRecord* record;
  if (const lf_status s = pack.find_tile(*level, index, slot, record); s != LF_OK) return s;
  return pack.epochs_of(*record, epochs);
}

lf_status region_epochs(const lf_pack& pack, const lf_region& region, lf_epoch_range& out) {
  const Layer* layer;
  const Level* level;
  if (const lf_status s = pack.resolve(region, layer, level); s != LF_OK) return s;
  lf_epoch_range range{UINT32_MAX, 0, 0, 0};
  const tiles::TileRange places = tiles::tiles_of(rect_of(region));
  for (int32_t y = places.y_max; y >= places.y_min; --y)
    for (int32_t x = places.x_min; x <= places.x_max; ++x) {
      std::span<const uint16_t> epochs;
      const lf_status s = tile_epochs(pack, region.layer, {level->level, x, y}, epochs);
      if (s == LF_OUTSIDE_MAP) continue;
      if (s != LF_OK) return s;
      ++range.tiles;
      if (epochs.empty()) continue;
      ++range.dated_tiles;
      range.newest = std::min<uint32_t>(range.newest, epochs.front());
      range.oldest = std::max<uint32_t>(range.oldest, epochs.back());
    }
  if (range.tiles == 0) return LF_OUTSIDE_MAP;
  if (range.dated_tiles == 0) range.newest = 0;
  out = range;
  return LF_OK;
}

}  // namespace landfix::pack
