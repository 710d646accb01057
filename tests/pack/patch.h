// A pack's bytes with its records to hand, to change and hash anew: how packs are made that are hostile and yet
// consistent.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "schemas/pack_layout.h"

namespace landfix::tests {

class Patch {
 public:
  /// `bytes` is at least a header page long.
  explicit Patch(std::vector<uint8_t> bytes) : bytes_(std::move(bytes)) {}

  std::vector<uint8_t>& bytes() { return bytes_; }
  schema::Header& header() { return *reinterpret_cast<schema::Header*>(bytes_.data()); }
  /// The records of the file, for as far as the extents lie inside of it.
  std::span<schema::BlockRecord> blocks();
  std::span<schema::TileRecord> tiles(const schema::BlockRecord& block);
  std::span<uint8_t> data(const schema::TileRecord& tile);
  std::span<uint8_t> manifest();

  /// Appends bytes at a multiple of `alignment`, lets the header's file length follow, and returns their offset.
  uint64_t append(std::span<const uint8_t> more, uint64_t alignment = 8);
  /// Appends another manifest, lets the header point at it, and leaves zeros where the old one was.
  void replace_manifest(std::span<const uint8_t> manifest);

  /// Hashes of the tiles, then of what covers them, up to the header. What lies outside of the file is left alone.
  void rehash();
  /// From the block records up: tile hashes stay.
  void rehash_blocks();
  /// Manifest, block table, root and header: block hashes stay.
  void rehash_header();
  /// The header hash alone.
  void rehash_page();

 private:
  std::vector<uint8_t> bytes_;
};

/// A pack with its hashes made anew.
inline std::vector<uint8_t> rehashed(Patch patch) {
  patch.rehash();
  return std::move(patch.bytes());
}

}  // namespace landfix::tests
