// Bit layers: regions of planes against a reader that goes pixel by pixel, and what is refused.
#include <gtest/gtest.h>

#include <bit>
#include <cstring>

#include "tests/pack/patch.h"
#include "tests/pack/small_map.h"
#include "tests/tiles/random.h"

namespace landfix::tests {
namespace {

using tiles::Codec;
constexpr uint64_t kUntouched = 0xA5C3'A5C3'A5C3'A5C3;

OpenPack open_bits(Codec codec = Codec::kRaw) {
  Drawing drawing{.layers = {small_bits(codec)}};
  drawing.description.bounds = {kWestM, kSouthM, kEastM, kNorthM};
  return OpenPack(draw(drawing));
}

// One bit of the small map: nodata where there is no tile.
bool bit_of_map(int64_t column, int64_t row, int plane) {
  const char letter = small_letter(column, row);
  return letter == '.' || bit_pattern({letter, 0, column, row, plane}) != 0;
}

// Every word of the buffer is as the contract says: pixels, zeros behind them, nothing else touched.
void expect_map(const Region& r, const std::vector<uint64_t>& out, size_t row_words, size_t plane_words) {
  const size_t line = (r.width + 63) / 64;
  std::vector<uint64_t> expected(out.size(), kUntouched);
  for (size_t p = 0; p < 4; ++p)
    for (size_t y = 0; y < r.height; ++y)
      for (size_t w = 0; w < line; ++w) {
        uint64_t word = 0;
        for (size_t x = 64 * w; x < std::min<size_t>(64 * w + 64, r.width); ++x)
          word |= uint64_t(bit_of_map(r.first_column + int64_t(x), r.first_row + int64_t(y), int(p))) << x % 64;
        expected[p * plane_words + y * row_words + w] = word;
      }
  for (size_t i = 0; i < out.size(); ++i)
    ASSERT_EQ(out[i], expected[i]) << "plane " << i / plane_words << " row " << i % plane_words / row_words << " word "
                                   << i % plane_words % row_words;
}

TEST(Bits, RandomRegionsAreAsDrawnPixelByPixel) {
  const OpenPack raw = open_bits(), packed = open_bits(tiles::Codec::kContext), zstd = open_bits(Codec::kZstd);
  for (const OpenPack* pack : {&packed, &zstd})
    ASSERT_EQ((*pack)->prepare(*(*pack)->box(0, kWestM, kSouthM, kEastM, kNorthM, 1)), LF_OK);
  Random random(5);
  for (int i = 0; i < 300; ++i) {
    // Reaching up to 100 m over the map's edges; some narrower than a word, some wider than three tiles.
    const double west = kWestM + double(random.integer(-100, 760)), south = kSouthM + double(random.integer(-100, 505));
    const double width = double(random.integer(1, i % 2 ? 70 : 900)), height = double(random.integer(1, 40));
    const auto region = raw->box(0, west, south, west + width, south + height, 1);
    if (region.status() == LF_OUTSIDE_MAP) continue;
    ASSERT_TRUE(region);
    const size_t line = (region->width + 63) / 64, row_words = line + size_t(random.integer(0, 2)),
                 plane_words = row_words * region->height + size_t(random.integer(0, 5));
    std::vector<uint64_t> out(4 * plane_words, kUntouched);
    for (const OpenPack* pack : {&raw, &packed, &zstd}) {
      std::ranges::fill(out, kUntouched);
      ASSERT_EQ((*pack)->read_bits(*region, out, row_words, plane_words), LF_OK);
      expect_map(*region, out, row_words, plane_words);
      if (HasFatalFailure()) return;
    }
  }
}

TEST(Bits, EveryShiftAgainstATile) {
  // Regions that begin and end at every column of two words, across the corner of four tiles.
  const OpenPack pack = open_bits();
  for (int shift = 0; shift < 128; ++shift) {
    const auto region = pack->box(0, kWestM + 128 + shift, kSouthM + 255, kWestM + 128 + shift + 150, kSouthM + 257, 1);
    ASSERT_TRUE(region);
    std::vector<uint64_t> out(4 * 2 * 3, kUntouched);
    ASSERT_EQ(pack->read_bits(*region, out, 3, 6), LF_OK);
    expect_map(*region, out, 3, 6);
    if (HasFatalFailure()) return;
  }
}

TEST(Bits, WiderThanAStripOfTilesAndWithNodata0) {
  // 19 tiles in a row with holes: wider than what is read in one go. Nodata 0: holes are 0.
  const std::string map = "abcdefgh.ijklmn.opq";
  DrawnLayer layer = small_bits();
  layer.format = {tiles::PixelType::kBit, 2, 0};
  layer.levels = {{0, kWestX, kSouthY, map}};
  const OpenPack pack(draw({.layers = {layer}}));
  const auto r = pack->box(0, kWestM + 3, kSouthM + 100, kWestM + 19 * 256 - 5, kSouthM + 103, 1);
  ASSERT_TRUE(r);
  const size_t line = (r->width + 63) / 64;
  std::vector<uint64_t> out(2 * 3 * line);
  ASSERT_EQ(pack->read_bits(*r, out, line, 3 * line), LF_OK);
  for (int p = 0; p < 2; ++p)
    for (int64_t y = 0; y < 3; ++y)
      for (int64_t x = 0; x < r->width; ++x) {
        const int64_t column = r->first_column + x, row = r->first_row + y;
        const char letter = map[size_t(column / 256 - kWestX)];
        const bool expected = letter != '.' && bit_pattern({letter, 0, column, row, p});
        const uint64_t word = out[(size_t(p) * 3 + size_t(y)) * line + size_t(x) / 64];
        ASSERT_EQ(word >> (x % 64) & 1, expected) << letter << " " << p << " " << x << " " << y;
      }
}

TEST(Bits, SixteenPlanes) {
  DrawnLayer layer = small_bits(tiles::Codec::kContext);
  layer.format = {tiles::PixelType::kBit, 16, 0};
  layer.levels = {{0, kWestX, kSouthY, "a"}};
  layer.pixel = [](const PixelOf& p) { return int((p.column * 3 + p.row * 5 + p.channel * p.channel) % 7 < 2); };
  const OpenPack pack(draw({.layers = {layer}}));
  ASSERT_EQ(pack.status(), LF_OK);
  EXPECT_EQ(*pack->verify(true), 1u);
  const Region r = *pack->box(0, kWestM, kSouthM, kWestM + 64, kSouthM + 1, 1);
  ASSERT_EQ(pack->prepare(r), LF_OK);
  uint64_t out[16];
  ASSERT_EQ(pack->read_bits(r, out, 1, 1), LF_OK);
  for (int p = 0; p < 16; ++p)
    for (int x = 0; x < 64; ++x)
      ASSERT_EQ(int(out[p] >> x & 1), layer.pixel({'a', 0, r.first_column + x, r.first_row, p})) << p << " " << x;
}

TEST(Bits, ViewOfATileIsItsPlanes) {
  const OpenPack pack = open_bits();
  const auto tile = pack->tile(0, 0, kWestX, kSouthY + 1);
  ASSERT_TRUE(tile);
  EXPECT_EQ(tile->row_bytes, 32u);
  EXPECT_EQ(reinterpret_cast<uintptr_t>(tile->pixels) % 8, 0u);
  EXPECT_GE(tile->pixels, static_cast<const void*>(pack.bytes().data())) << "a raw tile is not copied";
  EXPECT_LT(tile->pixels, static_cast<const void*>(pack.bytes().data() + pack.bytes().size()));
  const auto* bytes = static_cast<const uint8_t*>(tile->pixels);
  for (int p = 0; p < 4; ++p)
    for (int y = 0; y < 256; y += 15)
      for (int x = 0; x < 256; ++x)
        ASSERT_EQ(bytes[8192 * p + 32 * y + x / 8] >> (x % 8) & 1, bit_pattern({'a', 0, x, y, p})) << p << " " << x;
  // Its little-endian words are those of lf_read_bits.
  std::vector<uint64_t> out(4 * 1024);
  ASSERT_EQ(pack->read_bits(*pack->box(0, kWestM, kSouthM + 256, kWestM + 256, kNorthM, 1), out, 4, 1024), LF_OK);
  EXPECT_EQ(std::memcmp(out.data(), bytes, 32768), 0);
}

TEST(Bits, CompressedTilesArePreparedFirst) {
  for (const Codec codec : {Codec::kZstd, tiles::Codec::kContext}) {
    const OpenPack pack = open_bits(codec);
    const Region r = *pack->box(0, kWestM, kSouthM, kEastM, kNorthM, 1);
    std::vector<uint64_t> out(4 * 12 * 512);
    EXPECT_EQ(pack->read_bits(r, out, 12, 12 * 512), LF_NOT_PREPARED);
    EXPECT_EQ(pack->tile(0, 0, kWestX, kSouthY).status(), LF_NOT_PREPARED);
    EXPECT_EQ(*pack->verify(true), 9u);
    ASSERT_EQ(pack->prepare(r), LF_OK);
    EXPECT_EQ(pack->read_bits(r, out, 12, 12 * 512), LF_OK);
    EXPECT_EQ(pack->tile(0, 0, kWestX, kSouthY)->row_bytes, 32u);
  }
}

TEST(Bits, EveryTypeHasItsOwnCall) {
  DrawnLayer height = small_gray();
  height.name = "height";
  height.format = {tiles::PixelType::kI16, 1, -32768};
  height.value_step = 0.1f;
  const OpenPack pack(draw({.layers = {small_bits(), small_gray(), height}}));
  std::vector<uint64_t> words(1 << 16);
  std::vector<uint8_t> bytes(1 << 19);
  std::vector<float> floats(1 << 19);
  const auto statuses = [&](const char* name) {
    const Region r = *pack->box(pack.layer(name), kWestM, kSouthM, kEastM, kNorthM, 1);
    return std::array{pack->read_bits(r, words, 12, 12 * 512), pack->read(r, bytes, 768),
                      pack->read_heights(r, floats, 768 * 4)};
  };
  EXPECT_EQ(statuses("orientation"), (std::array{LF_OK, LF_WRONG_TYPE, LF_WRONG_TYPE}));
  EXPECT_EQ(statuses("gray"), (std::array{LF_WRONG_TYPE, LF_OK, LF_WRONG_TYPE}));
  EXPECT_EQ(statuses("height"), (std::array{LF_WRONG_TYPE, LF_WRONG_TYPE, LF_OK}));
  EXPECT_EQ(pack->layer(pack.layer("orientation"))->pixel_type, LF_BIT);
  EXPECT_EQ(pack->layer(pack.layer("orientation"))->channels, 4);
  EXPECT_EQ(pack->layer(pack.layer("orientation"))->nodata, 1);
}

TEST(Bits, RefusesSmallBuffers) {
  const OpenPack pack = open_bits();
  const Region r = *pack->box(0, kWestM, kSouthM, kWestM + 130, kSouthM + 10, 1);  // 3 words a row, 10 rows
  std::vector<uint64_t> out(1000);
  const auto status = [&](size_t row_words, size_t plane_words, size_t out_words) {
    return lf_read_bits(pack.c_pack(), &r, out.data(), row_words, plane_words, out_words);
  };
  EXPECT_EQ(status(3, 30, 120), LF_OK);
  EXPECT_EQ(status(3, 30, 119), LF_BUFFER_TOO_SMALL);
  EXPECT_EQ(status(2, 30, 120), LF_BUFFER_TOO_SMALL);
  EXPECT_EQ(status(0, 30, 120), LF_BUFFER_TOO_SMALL);
  EXPECT_EQ(status(3, 29, 120), LF_BUFFER_TOO_SMALL) << "planes would overlap";
  EXPECT_EQ(status(3, 0, 120), LF_BUFFER_TOO_SMALL);
  EXPECT_EQ(status(4, 39, 4 * 39), LF_OK) << "the last row of a plane need not be whole";
  EXPECT_EQ(status(4, 38, 4 * 39), LF_BUFFER_TOO_SMALL);
  EXPECT_EQ(status(SIZE_MAX, 30, 120), LF_BUFFER_TOO_SMALL);
  EXPECT_EQ(status(3, SIZE_MAX, 120), LF_BUFFER_TOO_SMALL);
  EXPECT_EQ(status(3, 30, 0), LF_BUFFER_TOO_SMALL);
  EXPECT_EQ(status(3, 30, 29), LF_BUFFER_TOO_SMALL);
  // One plane needs no distance to the next.
  DrawnLayer one = small_bits();
  one.format.channels = 1;
  const OpenPack single(draw({.layers = {one}}));
  EXPECT_EQ(lf_read_bits(single.c_pack(), &r, out.data(), 3, 0, 30), LF_OK);
  EXPECT_EQ(lf_read_bits(single.c_pack(), &r, out.data(), 3, 0, 29), LF_BUFFER_TOO_SMALL);
}

TEST(Bits, RefusesRegionsThatNobodyGaveOut) {
  const OpenPack pack = open_bits();
  const Region good = *pack->box(0, kWestM, kSouthM, kEastM, kNorthM, 1);
  std::vector<uint64_t> out(1 << 16);
  for (const auto change :
       {+[](Region& r) { r.layer = 1; }, +[](Region& r) { r.level = 9; }, +[](Region& r) { r.width = 0; },
        +[](Region& r) { r.height = 0; }, +[](Region& r) { r.first_row = INT64_MIN; }}) {
    Region r = good;
    change(r);
    EXPECT_EQ(lf_read_bits(pack.c_pack(), &r, out.data(), 16, 8192, out.size()), LF_INVALID_ARGUMENT);
  }
}

TEST(HostileBits, RecordsOfAWrongLengthAreDamage) {
  const auto with = [](Codec codec, auto change) {
    Patch p(open_bits(codec).bytes());
    change(p.tiles(p.blocks()[0])[0]);
    p.rehash();
    const OpenPack pack(std::move(p.bytes()));
    EXPECT_EQ(pack.status(), LF_OK);
    EXPECT_EQ(pack->verify(true).status(), LF_DAMAGED);
    return pack->prepare(*pack->box(0, kWestM, kSouthM, kEastM, kNorthM, 1));
  };
  using schema::TileRecord;
  EXPECT_EQ(with(Codec::kRaw, [](TileRecord& t) { t.length = 8192; }), LF_DAMAGED);   // one plane of four
  EXPECT_EQ(with(Codec::kRaw, [](TileRecord& t) { t.length = 65536; }), LF_DAMAGED);  // a tile of gray
  EXPECT_EQ(with(Codec::kRaw, [](TileRecord& t) { t.offset += 8; }), LF_DAMAGED);
  EXPECT_EQ(with(Codec::kZstd, [](TileRecord& t) { t.length -= 1; }), LF_DAMAGED);
  EXPECT_EQ(with(tiles::Codec::kContext, [](TileRecord& t) { t.length -= 1; }), LF_DAMAGED);
  EXPECT_EQ(with(tiles::Codec::kContext, [](TileRecord& t) { t.codec = uint8_t(Codec::kJpeg); }), LF_DAMAGED);
  EXPECT_EQ(with(tiles::Codec::kContext, [](TileRecord& t) { t.codec = uint8_t(Codec::kZstd); }), LF_DAMAGED);
}

}  // namespace
}  // namespace landfix::tests
