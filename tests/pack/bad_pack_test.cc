// Damaged, truncated and hostile packs: each has its stated status, and none is believed.
#include <gtest/gtest.h>
#include <turbojpeg.h>
#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "tests/pack/patch.h"
#include "tests/pack/small_map.h"

namespace landfix::tests {
namespace {

using schema::Header;
using schema::TileRecord;
using tiles::Codec;
using Bytes = std::vector<uint8_t>;

const Bytes& good() {
  static const Bytes bytes = small_pack();
  return bytes;
}

Bytes flipped(size_t at) {
  Bytes bytes = good();
  bytes[at] ^= 0x10;
  return bytes;
}

Region whole(const OpenPack& pack) { return *pack->box(0, kWestM, kSouthM, kEastM, kNorthM, 1); }

// Where things lie in the good pack.
struct Sections {
  size_t manifest, manifest_end, table, directory, directory_end, tile, padding;
  Sections() {
    Patch p(good());
    manifest = p.header().manifest_offset;
    manifest_end = manifest + p.header().manifest_length;
    table = p.header().block_table_offset;
    directory = p.blocks()[0].offset;
    directory_end = directory;
    tile = SIZE_MAX;
    for (const auto& block : p.blocks()) {
      directory_end = std::max<size_t>(directory_end, block.offset + 64 * block.count);
      for (const TileRecord& t : p.tiles(block)) tile = std::min<size_t>(tile, t.offset);
    }
    padding = directory_end + 10;
  }
};

TEST(Truncated, IsSaidAtEverySection) {
  const Sections s;
  ASSERT_LT(s.padding, s.tile);
  const TemporaryFolder folder;
  const std::string path = folder.file("cut.lfpack");
  for (const size_t length : {size_t(8), size_t(100), size_t(4095), size_t(4096), s.manifest + 9, s.manifest_end,
                              s.table + 64, s.directory + 64, s.directory_end, s.padding, s.tile, s.tile + 1000,
                              good().size() - 65536, good().size() - 1}) {
    const std::span<const uint8_t> cut(good().data(), length);
    EXPECT_EQ(open_status({cut.begin(), cut.end()}), LF_TRUNCATED) << length;
    write_file(path, cut);
    EXPECT_EQ(Pack::open(path.c_str()).status(), LF_TRUNCATED) << length;
    EXPECT_EQ(Pack::open(path.c_str(), {.copy = true}).status(), LF_TRUNCATED) << length;
  }
  for (size_t length = 1; length < 8; ++length)
    EXPECT_EQ(open_status({good().begin(), good().begin() + int(length)}), LF_NOT_A_PACK);
  Bytes longer = good();
  longer.push_back(0);
  EXPECT_EQ(open_status(longer), LF_TRUNCATED);
}

TEST(FlippedByte, AnywhereInTheHeaderIsRefused) {
  for (size_t i = 0; i < 4096; ++i)
    ASSERT_EQ(open_status(flipped(i)), i < 8 ? LF_NOT_A_PACK : LF_DAMAGED) << "byte " << i;
}

TEST(FlippedByte, AnywhereInManifestAndBlockTableIsRefused) {
  const Sections s;
  for (size_t i = s.manifest; i < s.manifest_end; ++i) ASSERT_EQ(open_status(flipped(i)), LF_DAMAGED) << "byte " << i;
  for (size_t i = s.table; i < s.directory; ++i) ASSERT_EQ(open_status(flipped(i)), LF_DAMAGED) << "byte " << i;
}

TEST(FlippedByte, InTheDirectoryIsFoundOnFirstTouch) {
  const Sections s;
  for (size_t i = s.directory; i < s.directory_end; i += 7) {
    const OpenPack pack(flipped(i));
    ASSERT_EQ(pack.status(), LF_OK);
    EXPECT_EQ(pack->verify(false).status(), LF_DAMAGED) << i;
    const bool level_0 = i < s.directory + 64 * 5;  // the first block holds the five tiles of level 0
    EXPECT_EQ(read(*pack, whole(pack)).status, level_0 ? LF_DAMAGED : LF_OK) << i;
    EXPECT_EQ(pack->tile(0, 0, kWestX, kSouthY).status(), level_0 ? LF_DAMAGED : LF_OK) << i;
    EXPECT_EQ(pack->prepare(whole(pack)), level_0 ? LF_DAMAGED : LF_OK) << i;
  }
}

TEST(FlippedByte, InATileIsThatTilesError) {
  Patch p(good());
  const TileRecord tile = p.tiles(p.blocks()[0])[2];
  for (const size_t i : {size_t(0), size_t(1), size_t(40000), size_t(65535)}) {
    const OpenPack pack(flipped(tile.offset + i));
    ASSERT_EQ(pack.status(), LF_OK);
    EXPECT_EQ(read(*pack, whole(pack)).status, LF_DAMAGED);
    EXPECT_EQ(pack->prepare(whole(pack)), LF_DAMAGED);
    EXPECT_EQ(pack->prepare(whole(pack), LF_PREPARE_COPY), LF_DAMAGED);
    EXPECT_EQ(pack->verify(false).status(), LF_DAMAGED);
    int damaged = 0;
    for (const TileRecord& other : p.tiles(p.blocks()[0])) {
      const tiles::TileIndex t = tiles::tile_of_key(0, other.key);
      const Status status = pack->tile(0, 0, t.x, t.y).status();
      EXPECT_EQ(status, other.key == tile.key ? LF_DAMAGED : LF_OK);
      damaged += status == LF_DAMAGED;
    }
    EXPECT_EQ(damaged, 1);
  }
}

TEST(FlippedByte, InPaddingIsFoundByTheDeepCheck) {
  const Sections s;
  const OpenPack pack(flipped(s.padding));
  ASSERT_EQ(pack.status(), LF_OK);
  EXPECT_EQ(read(*pack, whole(pack)).status, LF_OK);
  EXPECT_EQ(*pack->verify(false), 9u);
  EXPECT_EQ(pack->verify(true).status(), LF_DAMAGED);
  EXPECT_EQ(*OpenPack(good())->verify(true), 9u);
}

// A change to a record, with every hash above it made right again.
template <typename Change>
Bytes hostile(Change change) {
  Patch p(good());
  change(p);
  p.rehash_blocks();
  return std::move(p.bytes());
}

template <typename Change>
Bytes hostile_header(Change change) {
  return hostile([&](Patch& p) { change(p.header()); });
}

TEST(HostileHeader, EveryFieldIsChecked) {
  const uint64_t far = UINT64_MAX - 7;
  EXPECT_EQ(open_status(hostile_header([](Header&) {})), LF_OK);
  EXPECT_EQ(open_status(hostile_header([](Header& h) { h.version_major = 2; })), LF_UNKNOWN_VERSION);
  EXPECT_EQ(open_status(hostile_header([](Header& h) { h.version_major = 0; })), LF_UNKNOWN_VERSION);
  EXPECT_EQ(open_status(hostile_header([](Header& h) { h.version_minor = 7; })), LF_OK);
  EXPECT_EQ(open_status(hostile_header([](Header& h) { h.page_size = 8192; })), LF_DAMAGED);
  EXPECT_EQ(open_status(hostile_header([](Header& h) { h.file_length += 1; })), LF_TRUNCATED);
  EXPECT_EQ(open_status(hostile_header([](Header& h) { h.file_length -= 1; })), LF_TRUNCATED);
  for (const uint64_t offset : {far, uint64_t(good().size()), uint64_t(good().size()) - 8, uint64_t(4097)}) {
    EXPECT_EQ(open_status(hostile_header([=](Header& h) { h.manifest_offset = offset; })), LF_DAMAGED) << offset;
    EXPECT_EQ(open_status(hostile_header([=](Header& h) { h.block_table_offset = offset; })), LF_DAMAGED) << offset;
  }
  for (const uint64_t length : {uint64_t(0), uint64_t(4), far, uint64_t(64 << 20) + 1, uint64_t(good().size())})
    EXPECT_EQ(open_status(hostile_header([=](Header& h) { h.manifest_length = length; })), LF_DAMAGED) << length;
  for (const uint64_t count : {uint64_t(0), uint64_t(1), far, uint64_t(1) << 58, uint64_t(good().size() / 64)})
    EXPECT_EQ(open_status(hostile_header([=](Header& h) { h.block_count = count; })), LF_DAMAGED) << count;
}

TEST(HostileHeader, EveryHashOfThePageIsChecked) {
  // A wrong hash of the manifest or the block table under a right root, and a wrong root under a right header hash.
  EXPECT_EQ(open_status(hostile_header([](Header&) {})), LF_OK);
  for (schema::Hash Header::*field : {&Header::manifest_hash, &Header::block_table_hash}) {
    Patch p(good());
    (p.header().*field).bytes[0] ^= 1;
    exporter::seal(p.header());
    EXPECT_EQ(open_status(p.bytes()), LF_DAMAGED);
  }
  Patch p(good());
  p.header().root.bytes[0] ^= 1;
  p.rehash_page();
  EXPECT_EQ(open_status(p.bytes()), LF_DAMAGED);
}

TEST(HostileHeader, ReservedBytesAreFoundByTheDeepCheck) {
  const auto deep = [](Bytes bytes) {
    const OpenPack pack(std::move(bytes));
    EXPECT_EQ(pack.status(), LF_OK);
    EXPECT_TRUE(pack->verify(false));
    return pack->verify(true).status();
  };
  EXPECT_EQ(deep(hostile_header([](Header& h) { h.reserved_root = 1; })), LF_DAMAGED);
  EXPECT_EQ(deep(hostile_header([](Header& h) { h.reserved_signature = 1; })), LF_DAMAGED);
  EXPECT_EQ(deep(hostile_header([](Header& h) { h.reserved[3799] = 1; })), LF_DAMAGED);
  EXPECT_EQ(deep(hostile([](Patch& p) { p.blocks()[1].reserved = 1; })), LF_DAMAGED);
  EXPECT_EQ(deep(hostile([](Patch& p) { p.tiles(p.blocks()[1])[0].reserved = 1; })), LF_DAMAGED);
  // A newer minor version may have given them a meaning.
  EXPECT_EQ(deep(hostile_header([](Header& h) { h.version_minor = 4, h.reserved[0] = 1; })), LF_OK);
  EXPECT_EQ(deep(hostile([](Patch& p) {
              p.header().version_minor = 4;
              p.blocks()[1].reserved = 1;
              p.tiles(p.blocks()[1])[0].reserved = 1;
            })),
            LF_OK);
}

TEST(HostileBlocks, WhatTheTableSaysIsCheckedOnOpening) {
  // Blocks 0 and 1 are levels 0 and 1. Ranges that run backwards are refused at once.
  EXPECT_EQ(open_status(hostile([](Patch& p) { std::swap(p.blocks()[0].first_key, p.blocks()[0].last_key); })),
            LF_DAMAGED);
}

Status read_status(Bytes bytes) {
  const OpenPack pack(std::move(bytes));
  EXPECT_EQ(pack.status(), LF_OK);
  const Region region = whole(pack);
  const Status status = read(*pack, region).status;
  EXPECT_EQ(pack->verify(false).status(), status);
  EXPECT_EQ(pack->verify(true).status(), status);
  EXPECT_EQ(pack->prepare(region), status);
  // The other level has nothing to do with it.
  EXPECT_EQ(pack->tile(0, 1, kWestX >> 1, kSouthY >> 1).status(), LF_OK);
  return status;
}

TEST(HostileBlocks, EveryFieldIsCheckedOnFirstTouch) {
  EXPECT_EQ(read_status(hostile([](Patch&) {})), LF_OK);
  for (const uint32_t count : {0u, 4u, 6u, 257u, UINT32_MAX})
    EXPECT_EQ(read_status(hostile([=](Patch& p) { p.blocks()[0].count = count; })), LF_DAMAGED) << count;
  for (const uint64_t offset : {UINT64_MAX - 7, uint64_t(good().size()) - 64, uint64_t(4100), uint64_t(0)})
    EXPECT_EQ(read_status(hostile([=](Patch& p) { p.blocks()[0].offset = offset; })), LF_DAMAGED) << offset;
  EXPECT_EQ(read_status(hostile([](Patch& p) { p.blocks()[0].first_key -= 1; })), LF_DAMAGED);
  EXPECT_EQ(read_status(hostile([](Patch& p) { p.blocks()[0].last_key += 1; })), LF_DAMAGED);
  EXPECT_EQ(read_status(hostile([](Patch& p) { std::swap(p.tiles(p.blocks()[0])[1], p.tiles(p.blocks()[0])[2]); })),
            LF_DAMAGED);
  EXPECT_EQ(read_status(hostile([](Patch& p) { p.tiles(p.blocks()[0])[1] = p.tiles(p.blocks()[0])[2]; })), LF_DAMAGED);
  // A key beyond the end of the curve: level 0 has 2^36 tiles.
  EXPECT_EQ(read_status(hostile([](Patch& p) {
              p.blocks()[0].last_key = uint64_t(1) << 36;
              p.tiles(p.blocks()[0])[4].key = uint64_t(1) << 36;
            })),
            LF_DAMAGED);
}

TEST(HostileTiles, EveryFieldIsCheckedOnFirstTouch) {
  const auto with = [](auto change) {
    return read_status(hostile([&](Patch& p) { change(p.tiles(p.blocks()[0])[3]); }));
  };
  EXPECT_EQ(with([](TileRecord& t) { t.offset = UINT64_MAX - 4095; }), LF_DAMAGED);  // offset + length overflows
  EXPECT_EQ(with([](TileRecord& t) { t.offset = good().size() / 4096 * 4096; }), LF_DAMAGED);
  EXPECT_EQ(with([](TileRecord& t) { t.offset += 4096; }), LF_DAMAGED);
  EXPECT_EQ(with([](TileRecord& t) { t.length = 65535; }), LF_DAMAGED);
  EXPECT_EQ(with([](TileRecord& t) { t.length = UINT32_MAX; }), LF_DAMAGED);
  EXPECT_EQ(with([](TileRecord& t) { t.hash.bytes[0] ^= 1; }), LF_DAMAGED);
  EXPECT_EQ(with([](TileRecord& t) { t.codec = 5; }), LF_UNKNOWN_VERSION);
  EXPECT_EQ(with([](TileRecord& t) { t.codec = 4; }), LF_DAMAGED);      // of vector layers alone
  EXPECT_EQ(with([](TileRecord& t) { t.epoch_set = 1; }), LF_DAMAGED);  // the pack names no epochs
  // Misaligned, although the bytes and their hash are right.
  EXPECT_EQ(read_status(hostile([](Patch& p) {
              TileRecord& t = p.tiles(p.blocks()[0])[3];
              const Bytes copy(p.data(t).begin(), p.data(t).end());
              const uint64_t offset = p.append(copy, 4096) + 8;
              p.append(Bytes(8));
              std::memmove(p.bytes().data() + offset, copy.data(), copy.size());
              p.tiles(p.blocks()[0])[3].offset = offset;
            })),
            LF_DAMAGED);
}

TEST(HostileTiles, AnUnknownCodecIsThatTilesErrorAlone) {
  const OpenPack pack(hostile([](Patch& p) { p.tiles(p.blocks()[0])[3].codec = 200; }));
  int refused = 0;
  for (const auto& [x, y] : {std::pair{0, 0}, {0, 1}, {1, 1}, {2, 0}, {2, 1}}) {
    const Status s = pack->tile(0, 0, kWestX + x, kSouthY + y).status();
    EXPECT_TRUE(s == LF_OK || s == LF_UNKNOWN_VERSION);
    refused += s != LF_OK;
  }
  EXPECT_EQ(refused, 1);
}

// The tile's data replaced, with its codec, and all hashes right.
Status prepare_status(Codec codec, const Bytes& data) {
  Patch p(small_pack(Codec::kZstd));
  const uint64_t offset = p.append(data);
  TileRecord& t = p.tiles(p.blocks()[0])[3];
  std::ranges::fill(p.data(t), uint8_t(0));  // what nobody refers to any more is padding
  t.offset = offset;
  t.length = uint32_t(data.size());
  t.codec = uint8_t(codec);
  p.rehash();
  const OpenPack pack(std::move(p.bytes()));
  EXPECT_EQ(pack.status(), LF_OK);
  const Region region = whole(pack);
  const Status status = pack->prepare(region);
  EXPECT_EQ(read(*pack, region).status, status == LF_OK ? LF_OK : LF_NOT_PREPARED);
  EXPECT_EQ(pack->verify(true).status() == LF_OK, status == LF_OK);
  return status;
}

Bytes jpeg_tile(int width, int height) {
  const Bytes pixels(size_t(width) * size_t(height), 100);
  tjhandle handle = tjInitCompress();
  uint8_t* jpeg = nullptr;
  unsigned long size = 0;
  tjCompress2(handle, pixels.data(), width, 0, height, TJPF_GRAY, &jpeg, &size, TJSAMP_GRAY, 90, 0);
  Bytes tile(4 + size, 0);
  std::copy_n(jpeg, size, tile.begin() + 4);
  tjFree(jpeg);
  tjDestroy(handle);
  return tile;
}

TEST(HostileTiles, DataThatDoesNotDecodeIsRefused) {
  EXPECT_EQ(prepare_status(Codec::kJpeg, jpeg_tile(256, 256)), LF_OK);
  EXPECT_EQ(prepare_status(Codec::kJpeg, jpeg_tile(128, 256)), LF_DAMAGED);
  EXPECT_EQ(prepare_status(Codec::kJpeg, jpeg_tile(1024, 1024)), LF_DAMAGED);
  EXPECT_EQ(prepare_status(Codec::kJpeg, Bytes(100, 0)), LF_DAMAGED);
  EXPECT_EQ(prepare_status(Codec::kZstd, Bytes(100, 0x28)), LF_DAMAGED);
  EXPECT_EQ(prepare_status(Codec::kZstd, {}), LF_DAMAGED);
  const Bytes zeros(size_t(64) << 20);
  Bytes bomb(ZSTD_compressBound(zeros.size()));
  bomb.resize(ZSTD_compress(bomb.data(), bomb.size(), zeros.data(), zeros.size(), 1));
  EXPECT_EQ(prepare_status(Codec::kZstd, bomb), LF_DAMAGED);
}

TEST(HostileTiles, HeightsNeedAFiniteScale) {
  DrawnLayer layer = small_gray();
  layer.name = "height";
  layer.format = {tiles::PixelType::kI16, 1, -32768};
  layer.value_step = 0.1f;
  const Bytes bytes = draw({.layers = {layer}});
  const auto with = [&](float offset, float step) {
    Patch p(bytes);
    for (TileRecord& t : p.tiles(p.blocks()[0])) t.value_offset = offset, t.value_step = step;
    p.rehash();
    const OpenPack pack(std::move(p.bytes()));
    EXPECT_EQ(pack.status(), LF_OK);
    return pack->height(kWestM + 100, kSouthM + 100).status();
  };
  EXPECT_EQ(with(0, 0.1f), LF_OK);
  EXPECT_EQ(with(0, 0), LF_DAMAGED);
  EXPECT_EQ(with(0, -1), LF_DAMAGED);
  EXPECT_EQ(with(0, std::nanf("")), LF_DAMAGED);
  EXPECT_EQ(with(std::nanf(""), 1), LF_DAMAGED);
  EXPECT_EQ(with(INFINITY, 1), LF_DAMAGED);
  EXPECT_EQ(with(0, 1e38f), LF_DAMAGED);  // a pixel times the step is beyond a float
}

}  // namespace
}  // namespace landfix::tests
