// Inside of lf_pack: what opening leaves behind, and the checked way from a tile's key to its pixels.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <span>

#include "landfix/landfix.h"
#include "runtime/pack/mapping.h"
#include "schemas/pack_generated.h"
#include "schemas/pack_layout.h"
#include "tiles/codec.h"
#include "tiles/grid.h"

namespace landfix::pack {

inline constexpr uint32_t kMaxLayers = 64, kMaxLevels = tiles::kMaxLevel - tiles::kMinLevel + 1;

schema::Hash hash_of(const void* data, size_t size);

/// What a signature is made over (FORMAT.md section 3.1).
inline constexpr size_t kContextBytes = sizeof(schema::kSignatureContext) - 1;
using SignedMessage = std::array<uint8_t, kContextBytes + sizeof(schema::Hash)>;
SignedMessage signed_message(const schema::Hash& root);

/// Whether [offset, offset + length) lies inside [0, size), without overflow.
inline bool inside(uint64_t offset, uint64_t length, uint64_t size) {
  return length <= size && offset <= size - length;
}

struct Level {
  int level = 0;
  uint32_t first_block = 0, block_count = 0, tile_count = 0;
};

struct Layer {
  const char* name = "";
  const char* description = "";
  lf_pixel_type type = LF_U8;
  tiles::TileFormat format;  ///< of raster layers
  Level levels[kMaxLevels];
  uint32_t level_count = 0;

  const Level* find_level(int level) const;
  bool is_vector() const { return type == LF_LANDMARKS || type == LF_ROADS; }
};

/// Bits that many threads set once.
class AtomicBits {
 public:
  bool allocate(size_t count);
  bool test(size_t i) const { return words_[i / 64].load(std::memory_order_acquire) >> (i % 64) & 1; }
  void set(size_t i) { words_[i / 64].fetch_or(uint64_t(1) << (i % 64), std::memory_order_release); }

 private:
  struct Free {
    void operator()(std::atomic<uint64_t>* p) const;
  };
  std::unique_ptr<std::atomic<uint64_t>[], Free> words_;
};

/// Decoded or copied tiles by slot, of vector layers as runtime/pack/vectors.h lays them out; each is published once
/// and lives as long as the pack.
class TileCache {
 public:
  ~TileCache();
  bool allocate(size_t count);
  const uint8_t* get(size_t slot) const { return slots_[slot].load(std::memory_order_acquire); }
  /// Takes `pixels` (from std::malloc); frees it where another thread was first.
  void publish(size_t slot, uint8_t* pixels);

 private:
  std::atomic<uint8_t*>* slots_ = nullptr;
  size_t count_ = 0;
};

}  // namespace landfix::pack

/// Slots number the tile records of a pack: block * 256 + place in the block. A slot belongs to one level of one layer.
struct lf_pack {
  landfix::pack::Mapping mapping;
  landfix::schema::Header header{};
  const landfix::schema::Manifest* manifest = nullptr;
  std::span<const landfix::schema::BlockRecord> blocks;
  std::unique_ptr<landfix::pack::Layer[]> layers;
  uint32_t layer_count = 0;
  const landfix::pack::Layer* height_layer = nullptr;  ///< null where the pack has no heights
  std::unique_ptr<uint32_t[]> vector_sources;          ///< the sources of role vector, as indices of all sources
  uint32_t vector_source_count = 0;
  mutable landfix::pack::AtomicBits checked_blocks, checked_tiles;
  mutable landfix::pack::TileCache cache;

  /// Checks the bytes in `mapping` and fills everything else; `keys` may be empty.
  lf_status load(std::span<const uint8_t[32]> keys);

  /// The tile records of a block, after its first-touch checks.
  lf_status block_records(uint32_t block, int level, std::span<const landfix::schema::TileRecord>& records) const;
  /// Slot and record of a tile; LF_OUTSIDE_MAP where the level has none.
  lf_status find_tile(const landfix::pack::Level& level, const landfix::tiles::TileIndex& tile, size_t& slot,
                      const landfix::schema::TileRecord*& record) const;
  /// The epochs of a tile, in the manifest; empty: not stated.
  lf_status epochs_of(const landfix::schema::TileRecord& record, std::span<const uint16_t>& epochs) const;
  /// First-touch checks of a tile: extent, format, epochs, hash.
  lf_status check_tile(const landfix::pack::Layer& layer, size_t slot, const landfix::schema::TileRecord& record) const;
  /// Checked pixels of a tile: in the mapping, or as lf_prepare left them.
  lf_status tile_pixels(const landfix::pack::Layer& layer, size_t slot, const landfix::schema::TileRecord& record,
                        const uint8_t*& pixels) const;
  /// find_tile and tile_pixels in one; `record` may be wanted for its value offset and step.
  lf_status pixels_of(const landfix::pack::Layer& layer, const landfix::pack::Level& level,
                      const landfix::tiles::TileIndex& tile, const uint8_t*& pixels,
                      const landfix::schema::TileRecord*& record) const;
  /// Verifies, and decodes or copies to memory where the codec or `copy` asks for it.
  lf_status prepare_tile(const landfix::pack::Layer& layer, const landfix::pack::Level& level,
                         const landfix::tiles::TileIndex& tile, bool copy) const;
  /// The layer and level of a region, after checking every number of it.
  lf_status resolve(const lf_region& region, const landfix::pack::Layer*& layer,
                    const landfix::pack::Level*& level) const;
};
