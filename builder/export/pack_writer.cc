#include "builder/export/pack_writer.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstring>
#include <memory>
#include <system_error>
#include <unordered_map>

#include "builder/catalog/file.h"
#include "builder/catalog/hash.h"
#include "builder/error.h"
#include "builder/export/epoch_sets.h"

namespace landfix::exporter {
namespace {

namespace fs = std::filesystem;
using catalog::File;
using catalog::hash_of;
using schema::BlockRecord;
using schema::TileRecord;

template <typename T>
std::span<const uint8_t> bytes_of(const std::vector<T>& records) {
  return {reinterpret_cast<const uint8_t*>(records.data()), records.size() * sizeof(T)};
}

uint64_t align(uint64_t offset, uint64_t alignment) { return (offset + alignment - 1) / alignment * alignment; }

struct HashOfHash {
  size_t operator()(const schema::Hash& hash) const {
    size_t value;
    std::memcpy(&value, hash.bytes, sizeof value);
    return value;
  }
};

// Everything of the file but the tile data, laid out.
struct Layout {
  std::vector<uint8_t> manifest;
  std::vector<BlockRecord> blocks;
  std::vector<TileRecord> records;          // as in the directory blocks, one after the other
  std::vector<const TileRecord*> to_write;  // those of the description whose data is stored, in the order of the file
  std::vector<uint64_t> positions;          // where
  uint64_t table_offset = 0, directory_offset = 0, file_bytes = 0;
};

// One level: its records with the pack's numbers of their sets of epochs, and the blocks over them. Hashes and offsets
// of blocks follow once tile offsets are known.
void add_level(const PackLayer& layer, const PackLevel& level, const EpochSets& epoch_sets, Layout& layout) {
  const std::vector<TileRecord>& tiles = level.tiles;
  for (size_t i = 0; i < tiles.size(); ++i) {
    if (i > 0 && tiles[i - 1].key >= tiles[i].key)
      throw Error(ExitCode::kInternal, fmt::format("layer {} level {}: tiles out of order", layer.name, level.level));
    if (tiles[i].length > schema::kMaxTileBytes)
      throw Error(ExitCode::kInternal,
                  fmt::format("layer {} level {}: a tile of {} bytes", layer.name, level.level, tiles[i].length));
    if (i % schema::kBlockTiles == 0) layout.blocks.push_back({});
    BlockRecord& block = layout.blocks.back();
    if (block.count++ == 0) block.first_key = tiles[i].key;
    block.last_key = tiles[i].key;
    layout.records.push_back(tiles[i]);
    layout.records.back().epoch_set = epoch_sets.number[tiles[i].epoch_set];
  }
}

// Gives every tile its place; equal data is stored once.
void place_tiles(const PackDescription& description, uint64_t data_offset, Layout& layout) {
  std::unordered_map<schema::Hash, uint64_t, HashOfHash> stored[2];  // by need of page alignment
  uint64_t end = data_offset;
  size_t index = 0;
  for (const PackLayer& layer : description.layers)
    for (const PackLevel& level : layer.levels)
      for (const TileRecord& tile : level.tiles) {
        const bool raw = tile.codec == uint8_t(tiles::Codec::kRaw);
        const auto [known, is_new] = stored[raw].try_emplace(tile.hash, 0);
        if (is_new) {
          known->second = align(end, raw ? schema::kPageSize : schema::kSmallAlignment);
          end = known->second + tile.length;
          layout.to_write.push_back(&tile);
          layout.positions.push_back(known->second);
        }
        layout.records[index++].offset = known->second;
      }
  layout.file_bytes = end;
}

Layout lay_out(const PackDescription& description) {
  Layout layout;
  const EpochSets epoch_sets = number_epoch_sets(description);
  layout.manifest = encode_manifest(description, epoch_sets.sets);
  if (layout.manifest.size() > schema::kMaxManifestBytes)
    throw Error(ExitCode::kInternal, fmt::format("a manifest of {} bytes", layout.manifest.size()));
  for (const PackLayer& layer : description.layers)
    for (const PackLevel& level : layer.levels) add_level(layer, level, epoch_sets, layout);
  layout.table_offset = align(schema::kPageSize + layout.manifest.size(), schema::kSmallAlignment);
  layout.directory_offset = layout.table_offset + layout.blocks.size() * sizeof(BlockRecord);
  place_tiles(description, layout.directory_offset + layout.records.size() * sizeof(TileRecord), layout);
  uint64_t first = 0;
  for (BlockRecord& block : layout.blocks) {
    block.offset = layout.directory_offset + first * sizeof(TileRecord);
    block.hash =
        hash_of(bytes_of(layout.records).subspan(first * sizeof(TileRecord), block.count * sizeof(TileRecord)));
    first += block.count;
  }
  return layout;
}

schema::Header header_of(const Layout& layout) {
  schema::Header header{};
  std::memcpy(header.magic, schema::kMagic, sizeof header.magic);
  header.version_major = schema::kVersionMajor;
  header.version_minor = schema::kVersionMinor;
  header.page_size = schema::kPageSize;
  header.file_length = layout.file_bytes;
  header.manifest_offset = schema::kPageSize;
  header.manifest_length = layout.manifest.size();
  header.block_table_offset = layout.table_offset;
  header.block_count = layout.blocks.size();
  header.manifest_hash = hash_of(layout.manifest);
  header.block_table_hash = hash_of(bytes_of(layout.blocks));
  seal(header);
  return header;
}

// Appends with zeros up to the position asked for, in large writes.
class Appender {
 public:
  explicit Appender(File& file) : file_(file) { buffer_.reserve(kFlushBytes * 2); }

  void write(uint64_t position, std::span<const uint8_t> data) {
    const std::span<uint8_t> room = make_room(position, data.size());
    std::copy(data.begin(), data.end(), room.begin());
    if (buffer_.size() >= kFlushBytes) flush();
  }
  // The caller fills the room before the next call.
  std::span<uint8_t> make_room(uint64_t position, size_t bytes) {
    if (buffer_.size() >= kFlushBytes) flush();
    const size_t begin = size_t(position - flushed_);
    buffer_.resize(begin + bytes);
    return std::span(buffer_).subspan(begin);
  }
  void flush() {
    file_.write_at(flushed_, buffer_);
    flushed_ += buffer_.size();
    buffer_.clear();
  }

 private:
  static constexpr size_t kFlushBytes = size_t(4) << 20;
  File& file_;
  std::vector<uint8_t> buffer_;
  uint64_t flushed_ = 0;
};

void write_all(const Layout& layout, File& file, const ReadTile& read, const std::function<void(uint64_t)>& advance) {
  const schema::Header header = header_of(layout);
  Appender out(file);
  out.write(0, {reinterpret_cast<const uint8_t*>(&header), sizeof header});
  out.write(schema::kPageSize, layout.manifest);
  out.write(layout.table_offset, bytes_of(layout.blocks));
  out.write(layout.directory_offset, bytes_of(layout.records));
  for (size_t i = 0; i < layout.to_write.size(); ++i) {
    const TileRecord& tile = *layout.to_write[i];
    read(tile, out.make_room(layout.positions[i], tile.length));
    if (advance) advance(tile.length);
  }
  out.flush();
  file.sync();
}

// Removes the temporary file unless it was renamed.
class Temporary {
 public:
  explicit Temporary(fs::path path) : path_(std::move(path)) {}
  ~Temporary() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove(path_, ignored);
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  void rename_to(const fs::path& target) {
    std::error_code error;
    fs::rename(path_, target, error);
    if (error) throw Error(ExitCode::kIo, fmt::format("{}: cannot write: {}", target.string(), error.message()));
    path_.clear();
  }

 private:
  fs::path path_;
};

void require_space(const fs::path& path, uint64_t bytes) {
  std::error_code error;
  const fs::space_info space = fs::space(catalog::folder_of(path), error);
  if (!error && space.available < bytes)
    throw Error(
        ExitCode::kIo,
        fmt::format("{}: the pack needs {:.1f} MB, the disk has {:.1f} MB free; free space there or write elsewhere",
                    path.string(), double(bytes) / 1e6, double(space.available) / 1e6));
}

}  // namespace

void seal(schema::Header& header) {
  const auto* bytes = reinterpret_cast<const uint8_t*>(&header);
  header.root = hash_of({bytes, offsetof(schema::Header, root)});
  header.header_hash = hash_of({bytes, offsetof(schema::Header, header_hash)});
}

PackStatistics write_pack(const fs::path& path, const PackDescription& description, const ReadTile& read,
                          const std::function<void(uint64_t)>& advance) {
  const Layout layout = lay_out(description);
  require_space(path, layout.file_bytes);
  const fs::path part = path.string() + ".part";
  {
    auto file = std::make_unique<File>(part, File::Open::kTruncate);
    Temporary temporary(part);
    try {
      write_all(layout, *file, read, advance);
    } catch (const Error& error) {
      if (error.code() != ExitCode::kIo) throw;
      throw Error(ExitCode::kIo,
                  fmt::format("{} (the pack needs {:.1f} MB)", error.what(), double(layout.file_bytes) / 1e6));
    }
    file.reset();
    temporary.rename_to(path);
  }
  catalog::sync_folder(catalog::folder_of(path));
  return {layout.file_bytes, layout.records.size(), layout.to_write.size()};
}

}  // namespace landfix::exporter
