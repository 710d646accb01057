#include "tests/pack/patch.h"

#include <sodium.h>

#include <algorithm>

namespace landfix::tests {
namespace {

using schema::BlockRecord;
using schema::Header;
using schema::TileRecord;

schema::Hash hash_of(std::span<const uint8_t> data) {
  schema::Hash h;
  crypto_generichash(h.bytes, sizeof h.bytes, data.data(), data.size(), nullptr, 0);
  return h;
}

template <typename T>
std::span<const uint8_t> bytes_of(std::span<T> records) {
  return {reinterpret_cast<const uint8_t*>(records.data()), records.size_bytes()};
}

std::span<uint8_t> extent(std::vector<uint8_t>& bytes, uint64_t offset, uint64_t length) {
  if (length > bytes.size() || offset > bytes.size() - length) return {};
  return std::span(bytes).subspan(offset, length);
}

}  // namespace

std::span<BlockRecord> Patch::blocks() {
  const Header& h = header();
  if (h.block_table_offset % 8 != 0 || h.block_count > bytes_.size() / sizeof(BlockRecord)) return {};
  const auto table = extent(bytes_, h.block_table_offset, h.block_count * sizeof(BlockRecord));
  return {reinterpret_cast<BlockRecord*>(table.data()), table.size() / sizeof(BlockRecord)};
}

std::span<TileRecord> Patch::tiles(const BlockRecord& block) {
  if (block.offset % 8 != 0) return {};
  const auto records = extent(bytes_, block.offset, uint64_t(block.count) * sizeof(TileRecord));
  return {reinterpret_cast<TileRecord*>(records.data()), records.size() / sizeof(TileRecord)};
}

std::span<uint8_t> Patch::data(const TileRecord& tile) { return extent(bytes_, tile.offset, tile.length); }

std::span<uint8_t> Patch::manifest() { return extent(bytes_, header().manifest_offset, header().manifest_length); }

uint64_t Patch::append(std::span<const uint8_t> more, uint64_t alignment) {
  const std::vector<uint8_t> copy(more.begin(), more.end());
  bytes_.resize((bytes_.size() + alignment - 1) / alignment * alignment);
  const uint64_t offset = bytes_.size();
  bytes_.insert(bytes_.end(), copy.begin(), copy.end());
  header().file_length = bytes_.size();
  return offset;
}

void Patch::replace_manifest(std::span<const uint8_t> manifest) {
  std::ranges::fill(this->manifest(), uint8_t(0));
  const uint64_t offset = append(manifest);
  header().manifest_offset = offset;
  header().manifest_length = manifest.size();
}

void Patch::rehash() {
  for (const BlockRecord& block : blocks())
    for (TileRecord& tile : tiles(block))
      if (tile.length == 0 || !data(tile).empty()) tile.hash = hash_of(data(tile));
  rehash_blocks();
}

void Patch::rehash_blocks() {
  for (BlockRecord& block : blocks())
    if (!tiles(block).empty()) block.hash = hash_of(bytes_of(tiles(block)));
  rehash_header();
}

void Patch::rehash_header() {
  Header& h = header();
  h.manifest_hash = hash_of(manifest());
  h.block_table_hash = hash_of(bytes_of(blocks()));
  h.root = hash_of(std::span(bytes_).first(offsetof(Header, root)));
  rehash_page();
}

void Patch::rehash_page() { header().header_hash = hash_of(std::span(bytes_).first(offsetof(Header, header_hash))); }

}  // namespace landfix::tests
