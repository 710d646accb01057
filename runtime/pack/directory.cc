// From a tile's key to its checked bytes (FORMAT.md sections 3.3 and 4.2).
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "runtime/pack/pack.h"
#include "runtime/pack/vectors.h"

namespace landfix::pack {

const Level* Layer::find_level(int wanted) const {
  for (uint32_t i = 0; i < level_count; ++i)
    if (levels[i].level == wanted) return &levels[i];
  return nullptr;
}

void AtomicBits::Free::operator()(std::atomic<uint64_t>* p) const { std::free(p); }

bool AtomicBits::allocate(size_t count) {
  // Zero pages of calloc cost nothing until a tile is touched.
  words_.reset(static_cast<std::atomic<uint64_t>*>(std::calloc(count / 64 + 1, sizeof(std::atomic<uint64_t>))));
  return words_ != nullptr;
}

bool TileCache::allocate(size_t count) {
  slots_ = static_cast<std::atomic<uint8_t*>*>(std::calloc(count + 1, sizeof(std::atomic<uint8_t*>)));
  count_ = slots_ ? count : 0;
  return slots_ != nullptr;
}

TileCache::~TileCache() {
  for (size_t i = 0; i < count_; ++i) std::free(slots_[i].load(std::memory_order_relaxed));
  std::free(slots_);
}

void TileCache::publish(size_t slot, uint8_t* pixels) {
  uint8_t* none = nullptr;
  if (!slots_[slot].compare_exchange_strong(none, pixels, std::memory_order_acq_rel)) std::free(pixels);
}

namespace {

lf_status check_block(const lf_pack& pack, const schema::BlockRecord& block, int level) {
  if (block.count == 0 || block.count > schema::kBlockTiles || block.offset % 8 != 0) return LF_DAMAGED;
  const uint64_t bytes = uint64_t(block.count) * sizeof(schema::TileRecord);
  if (!inside(block.offset, bytes, pack.mapping.size())) return LF_DAMAGED;
  const uint8_t* data = pack.mapping.data() + block.offset;
  if (hash_of(data, bytes) != block.hash) return LF_DAMAGED;
  const auto* records = reinterpret_cast<const schema::TileRecord*>(data);
  if (records[0].key != block.first_key || records[block.count - 1].key != block.last_key) return LF_DAMAGED;
  for (uint32_t i = 1; i < block.count; ++i)
    if (records[i - 1].key >= records[i].key) return LF_DAMAGED;
  const int key_bits = 2 * (tiles::kDomainLog2 - 8 - level);
  return block.last_key >> key_bits == 0 ? LF_OK : LF_DAMAGED;
}

// Whether every i16 pixel has a finite value.
bool has_finite_values(const schema::TileRecord& r) {
  return r.value_step > 0 && std::isfinite(r.value_offset + r.value_step * float(INT16_MIN)) &&
         std::isfinite(r.value_offset + r.value_step * float(INT16_MAX));
}

lf_status check_record(const lf_pack& pack, const Layer& layer, const schema::TileRecord& r) {
  if (r.length > schema::kMaxTileBytes || r.offset % schema::kSmallAlignment != 0 ||
      !inside(r.offset, r.length, pack.mapping.size()))
    return LF_DAMAGED;
  std::span<const uint16_t> epochs;
  if (const lf_status s = pack.epochs_of(r, epochs); s != LF_OK) return s;
  if (r.codec > uint8_t(tiles::Codec::kVector)) return LF_UNKNOWN_VERSION;
  if (layer.is_vector() != (r.codec == uint8_t(tiles::Codec::kVector))) return LF_DAMAGED;
  if (r.codec == uint8_t(tiles::Codec::kRaw) && (r.length != layer.format.bytes() || r.offset % schema::kPageSize != 0))
    return LF_DAMAGED;
  return layer.type != LF_I16 || has_finite_values(r) ? LF_OK : LF_DAMAGED;
}

}  // namespace
}  // namespace landfix::pack

using landfix::pack::Layer;
using landfix::pack::Level;
using landfix::schema::BlockRecord;
using landfix::schema::TileRecord;
using landfix::tiles::TileIndex;

lf_status lf_pack::block_records(uint32_t block, int level, std::span<const TileRecord>& records) const {
  const BlockRecord& b = blocks[block];
  if (!checked_blocks.test(block)) {
    if (const lf_status s = landfix::pack::check_block(*this, b, level); s != LF_OK) return s;
    checked_blocks.set(block);
  }
  records = {reinterpret_cast<const TileRecord*>(mapping.data() + b.offset), b.count};
  return LF_OK;
}

lf_status lf_pack::find_tile(const Level& level, const TileIndex& tile, size_t& slot, const TileRecord*& record) const {
  if (!landfix::tiles::in_domain(tile)) return LF_OUTSIDE_MAP;
  const uint64_t key = landfix::tiles::hilbert_key(tile);
  const auto run = blocks.subspan(level.first_block, level.block_count);
  const auto block =
      std::lower_bound(run.begin(), run.end(), key, [](const BlockRecord& b, uint64_t k) { return b.last_key < k; });
  if (block == run.end() || block->first_key > key) return LF_OUTSIDE_MAP;
  const auto index = uint32_t(block - blocks.begin());
  std::span<const TileRecord> records;
  if (const lf_status s = block_records(index, level.level, records); s != LF_OK) return s;
  const auto found =
      std::lower_bound(records.begin(), records.end(), key, [](const TileRecord& r, uint64_t k) { return r.key < k; });
  if (found == records.end() || found->key != key) return LF_OUTSIDE_MAP;
  slot = size_t(index) * landfix::schema::kBlockTiles + size_t(found - records.begin());
  record = &*found;
  return LF_OK;
}

lf_status lf_pack::epochs_of(const TileRecord& r, std::span<const uint16_t>& epochs) const {
  epochs = {};
  if (r.epoch_set == 0) return LF_OK;
  const auto* sets = manifest->epoch_sets();
  if (sets == nullptr || r.epoch_set > sets->size()) return LF_DAMAGED;
  const auto* set = sets->Get(r.epoch_set - 1u)->epochs();
  epochs = {set->data(), set->size()};
  return LF_OK;
}

lf_status lf_pack::check_tile(const Layer& layer, size_t slot, const TileRecord& r) const {
  if (checked_tiles.test(slot)) return LF_OK;
  if (const lf_status s = landfix::pack::check_record(*this, layer, r); s != LF_OK) return s;
  if (landfix::pack::hash_of(mapping.data() + r.offset, r.length) != r.hash) return LF_DAMAGED;
  checked_tiles.set(slot);
  return LF_OK;
}

lf_status lf_pack::tile_pixels(const Layer& layer, size_t slot, const TileRecord& r, const uint8_t*& pixels) const {
  pixels = cache.get(slot);
  if (pixels != nullptr) return LF_OK;
  if (const lf_status s = check_tile(layer, slot, r); s != LF_OK) return s;
  if (r.codec != uint8_t(landfix::tiles::Codec::kRaw)) return LF_NOT_PREPARED;
  pixels = mapping.data() + r.offset;
  return LF_OK;
}

lf_status lf_pack::pixels_of(const Layer& layer, const Level& level, const TileIndex& tile, const uint8_t*& pixels,
                             const TileRecord*& record) const {
  size_t slot;
  if (const lf_status s = find_tile(level, tile, slot, record); s != LF_OK) return s;
  return tile_pixels(layer, slot, *record, pixels);
}

lf_status lf_pack::prepare_tile(const Layer& layer, const Level& level, const TileIndex& tile, bool copy) const {
  size_t slot;
  const TileRecord* r;
  if (const lf_status s = find_tile(level, tile, slot, r); s != LF_OK) return s == LF_OUTSIDE_MAP ? LF_OK : s;
  if (cache.get(slot) != nullptr) return LF_OK;
  if (const lf_status s = check_tile(layer, slot, *r); s != LF_OK) return s;
  if (layer.is_vector()) {
    uint8_t* features;
    if (const lf_status s = landfix::pack::decode_features(*this, layer, tile, *r, features); s != LF_OK) return s;
    cache.publish(slot, features);
    return LF_OK;
  }
  const bool raw = r->codec == uint8_t(landfix::tiles::Codec::kRaw);
  if (raw && !copy) {
    mapping.will_need(r->offset, r->length);
    return LF_OK;
  }
  const size_t bytes = layer.format.bytes();
  auto* pixels = static_cast<uint8_t*>(std::malloc(bytes));
  if (pixels == nullptr) return LF_OUT_OF_MEMORY;
  if (!landfix::tiles::decode(landfix::tiles::Codec(r->codec), layer.format, {mapping.data() + r->offset, r->length},
                              {pixels, bytes})) {
    std::free(pixels);
    return LF_DAMAGED;
  }
  cache.publish(slot, pixels);
  return LF_OK;
}
