// The whole of a pack, byte by byte (FORMAT.md section 4.3).
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <new>

#include "runtime/pack/queries.h"
#include "runtime/pack/vectors.h"
#include "tiles/vector_tile.h"

namespace landfix::pack {
namespace {

using schema::TileRecord;

// Collects what is used of the file and finds bytes between that are not zero. Grows by malloc: memory may run out
// without exceptions.
class Extents {
 public:
  ~Extents() { std::free(items_); }
  bool add(uint64_t offset, uint64_t length) {
    if (count_ == capacity_) {
      const size_t more = std::max<size_t>(1024, capacity_ * 2);
      auto* grown = static_cast<Extent*>(std::realloc(items_, more * sizeof(Extent)));
      if (grown == nullptr) return false;
      items_ = grown, capacity_ = more;
    }
    items_[count_++] = {offset, offset + length};
    return true;
  }
  bool padding_is_zero(const uint8_t* data, uint64_t size) {
    std::sort(items_, items_ + count_, [](const Extent& a, const Extent& b) { return a.begin < b.begin; });
    uint64_t at = 0;
    for (size_t i = 0; i < count_; ++i) {
      for (; at < items_[i].begin; ++at)
        if (data[at] != 0) return false;
      at = std::max(at, items_[i].end);
    }
    return at == size;
  }

 private:
  struct Extent {
    uint64_t begin, end;
  };
  Extent* items_ = nullptr;
  size_t count_ = 0, capacity_ = 0;
};

bool is_zero(const void* data, size_t size) {
  const auto* bytes = static_cast<const uint8_t*>(data);
  return std::all_of(bytes, bytes + size, [](uint8_t b) { return b == 0; });
}

// A newer minor version may hold layers and use reserved bytes that this library knows nothing of.
bool knows_every_byte(const lf_pack& pack) { return pack.header.version_minor <= schema::kVersionMinor; }

lf_status verify_tile(const lf_pack& pack, const Layer& layer, size_t slot, const TileRecord& r, bool deep,
                      uint8_t* scratch) {
  if (const lf_status s = pack.check_tile(layer, slot, r); s != LF_OK) return s;
  if (!deep) return LF_OK;
  if (r.reserved != 0 && knows_every_byte(pack)) return LF_DAMAGED;
  if (layer.is_vector()) {
    uint8_t* features = nullptr;
    const lf_status s = decode_features(pack, layer, tiles::tile_of_key(tiles::kVectorLevel, r.key), r, features);
    std::free(features);
    return s;
  }
  const uint8_t* data = pack.mapping.data() + r.offset;
  return tiles::decode(tiles::Codec(r.codec), layer.format, {data, r.length}, {scratch, layer.format.bytes()})
             ? LF_OK
             : LF_DAMAGED;
}

lf_status verify_level(const lf_pack& pack, const Layer& layer, const Level& level, bool deep, uint8_t* scratch,
                       Extents& used, uint64_t& tiles) {
  uint64_t in_level = 0;
  for (uint32_t i = 0; i < level.block_count; ++i) {
    const uint32_t block = level.first_block + i;
    std::span<const TileRecord> records;
    if (const lf_status s = pack.block_records(block, level.level, records); s != LF_OK) return s;
    if (!used.add(pack.blocks[block].offset, records.size_bytes())) return LF_OUT_OF_MEMORY;
    if (deep && pack.blocks[block].reserved != 0 && knows_every_byte(pack)) return LF_DAMAGED;
    for (size_t k = 0; k < records.size(); ++k) {
      const size_t slot = size_t(block) * schema::kBlockTiles + k;
      if (const lf_status s = verify_tile(pack, layer, slot, records[k], deep, scratch); s != LF_OK) return s;
      if (!used.add(records[k].offset, records[k].length)) return LF_OUT_OF_MEMORY;
    }
    in_level += records.size();
  }
  tiles += in_level;
  return in_level == level.tile_count ? LF_OK : LF_DAMAGED;
}

bool reserved_is_zero(const schema::Header& h) {
  return h.reserved_root == 0 && h.reserved_signature == 0 && is_zero(h.reserved, sizeof h.reserved);
}

}  // namespace

lf_status verify(const lf_pack& pack, bool deep, uint64_t& tiles) {
  Extents used;
  const schema::Header& h = pack.header;
  if (!used.add(0, sizeof h) || !used.add(h.manifest_offset, h.manifest_length) ||
      !used.add(h.block_table_offset, pack.blocks.size_bytes()))
    return LF_OUT_OF_MEMORY;
  tiles = 0;
  uint64_t known_blocks = 0;
  for (uint32_t i = 0; i < pack.layer_count; ++i) {
    const Layer& layer = pack.layers[i];
    const std::unique_ptr<uint8_t[]> scratch(new (std::nothrow) uint8_t[layer.format.bytes()]);
    if (!scratch) return LF_OUT_OF_MEMORY;
    for (uint32_t k = 0; k < layer.level_count; ++k) {
      if (const lf_status s = verify_level(pack, layer, layer.levels[k], deep, scratch.get(), used, tiles); s != LF_OK)
        return s;
      known_blocks += layer.levels[k].block_count;
    }
  }
  if (!deep || !knows_every_byte(pack)) return LF_OK;
  if (known_blocks != pack.blocks.size() || !reserved_is_zero(h)) return LF_DAMAGED;
  return used.padding_is_zero(pack.mapping.data(), pack.mapping.size()) ? LF_OK : LF_DAMAGED;
}

}  // namespace landfix::pack
