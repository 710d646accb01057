// Compressed layers: refused until prepared, then the same pixels as drawn.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/pack/small_map.h"

namespace landfix::tests {
namespace {

using tiles::Codec;

Region whole(const OpenPack& pack) { return *pack->box(0, kWestM, kSouthM, kEastM, kNorthM, 1); }

TEST(Prepare, CompressedLayersAreRefusedBefore) {
  for (const Codec codec : {Codec::kJpeg, Codec::kZstd}) {
    const OpenPack pack(small_pack(codec));
    const Region r = whole(pack);
    EXPECT_EQ(read(*pack, r).status, LF_NOT_PREPARED);
    EXPECT_EQ(pack->tile(0, 0, kWestX, kSouthY).status(), LF_NOT_PREPARED);
    uint64_t cursor = 0;
    Tile tile;
    EXPECT_EQ(lf_next_tile(pack.c_pack(), &r, nullptr, &cursor, &tile), LF_NOT_PREPARED);
    ASSERT_EQ(pack->prepare(r), LF_OK);
    EXPECT_EQ(read(*pack, r).status, LF_OK);
    EXPECT_EQ(pack->tile(0, 1, kWestX >> 1, kSouthY >> 1).status(), LF_NOT_PREPARED)
        << "another level was not asked for";
  }
}

TEST(Prepare, ZstandardIsExact) {
  const OpenPack raw(small_pack()), packed(small_pack(Codec::kZstd));
  ASSERT_EQ(packed->prepare(whole(packed)), LF_OK);
  EXPECT_EQ(read(*packed, whole(packed)).pixels, read(*raw, whole(raw)).pixels);
}

TEST(Prepare, JpegIsCloseAndItsMaskExact) {
  Drawing drawing{.layers = {small_gray(Codec::kJpeg)}};
  drawing.layers[0].pixel = [](const PixelOf& p) {
    if (p.letter == 'E' && (p.column & 255) >= 128) return 0;
    return 128 + int(60 * std::sin(double(p.column) / 20) + 60 * std::cos(double(p.row) / 30));
  };
  Drawing exact = drawing;
  exact.layers[0].codec = [](char) { return Codec::kRaw; };
  const OpenPack jpeg(draw(drawing)), raw(draw(exact));
  ASSERT_EQ(jpeg->prepare(whole(jpeg)), LF_OK);
  const std::vector<uint8_t> a = read(*jpeg, whole(jpeg)).pixels, b = read(*raw, whole(raw)).pixels;
  ASSERT_EQ(a.size(), b.size());
  double worst = 0, sum = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i] == 0, b[i] == 0) << i;
    worst = std::max(worst, std::abs(double(a[i]) - b[i]));
    sum += std::abs(double(a[i]) - b[i]);
  }
  EXPECT_LT(sum / double(a.size()), 1.0);  // quality 90 on smooth hills
  EXPECT_LT(worst, 40);                    // next to E's sharp edge
}

TEST(Prepare, OfRawTilesNeedsNoneAndCopiesOnWish) {
  const OpenPack pack(small_pack());
  const Region r = whole(pack);
  const auto inside = [&](const void* p) {
    return p >= pack.bytes().data() && p < pack.bytes().data() + pack.bytes().size();
  };
  const Read before = read(*pack, r);
  ASSERT_EQ(pack->prepare(r), LF_OK);
  EXPECT_TRUE(inside(pack->tile(0, 0, kWestX, kSouthY)->pixels));
  ASSERT_EQ(pack->prepare(r, LF_PREPARE_COPY), LF_OK);
  EXPECT_FALSE(inside(pack->tile(0, 0, kWestX, kSouthY)->pixels));
  EXPECT_EQ(read(*pack, r).pixels, before.pixels);
  const void* once = pack->tile(0, 0, kWestX, kSouthY)->pixels;
  ASSERT_EQ(pack->prepare(r, LF_PREPARE_COPY), LF_OK);
  EXPECT_EQ(pack->tile(0, 0, kWestX, kSouthY)->pixels, once) << "prepared tiles stay where they are";
}

TEST(Prepare, OfAMappedFileToo) {
  const TemporaryFolder folder;
  const std::string path = folder.file("small.lfpack");
  write_file(path, small_pack());
  const auto pack = Pack::open(path.c_str());
  ASSERT_TRUE(pack);
  const Region r = *pack->box(0, kWestM, kSouthM, kEastM, kNorthM, 1);
  EXPECT_EQ(pack->prepare(r), LF_OK);
  EXPECT_EQ(read(*pack, r).status, LF_OK);
}

TEST(Overview, ChannelsAreInterleaved) {
  DrawnLayer layer = small_gray(Codec::kZstd);
  layer.name = "overview";
  layer.format.channels = 3;
  const OpenPack pack(draw({.layers = {layer}}));
  const Region r = whole(pack);
  ASSERT_EQ(pack->prepare(r), LF_OK);
  const Read got = read(*pack, r, 3);
  ASSERT_EQ(got.status, LF_OK);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(got.pixels[size_t(3 * (2 * 768 + 1) + c)], pattern({'a', 0, 1, 2, c}));
  EXPECT_EQ(pack->tile(0, 0, kWestX, kSouthY)->row_bytes, 768u);
  EXPECT_EQ(read(*pack, r, 1).status, LF_BUFFER_TOO_SMALL);
}

TEST(Read, EqualTilesAreStoredOnce) {
  DrawnLayer layer = small_gray();
  layer.levels = {{0, kWestX, kSouthY, "aaa\naba"}};
  const OpenPack pack(draw({.layers = {layer}}));
  EXPECT_LT(pack.bytes().size(), 3 * 65536u);
  EXPECT_EQ(pack->tile(0, 0, kWestX, kSouthY)->pixels, pack->tile(0, 0, kWestX + 2, kSouthY + 1)->pixels);
  EXPECT_NE(pack->tile(0, 0, kWestX, kSouthY)->pixels, pack->tile(0, 0, kWestX + 1, kSouthY)->pixels);
}

TEST(Read, FindsEveryTileOfManyBlocks) {
  // 40 x 40 tiles of one value each: 7 directory blocks of 256 records.
  DrawnLayer layer = small_gray(Codec::kZstd);
  std::string map;
  for (int y = 0; y < 40; ++y) map += std::string(40, 'a') + (y < 39 ? "\n" : "");
  layer.levels = {{0, -20, -20, map}};
  layer.pixel = [](const PixelOf& p) {
    const tiles::TileIndex t = tiles::tile_of_pixel(p.level, p.column, p.row);
    return 1 + (t.x * 7 + t.y * 31 + 1000) % 255;
  };
  const OpenPack pack(draw({.layers = {layer}}));
  ASSERT_EQ(pack.status(), LF_OK);
  EXPECT_EQ(*pack->verify(true), 1600u);
  for (int32_t y = -21; y <= 20; ++y)
    for (int32_t x = -21; x <= 20; ++x) {
      const bool there = x >= -20 && x < 20 && y >= -20 && y < 20;
      if (there) {
        ASSERT_EQ(pack->prepare(*pack->box(0, x * 256.0, y * 256.0, x * 256.0 + 256, y * 256.0 + 256, 1)), LF_OK);
      }
      const auto tile = pack->tile(0, 0, x, y);
      ASSERT_EQ(tile.status(), there ? LF_OK : LF_OUTSIDE_MAP) << x << " " << y;
      if (there) {
        ASSERT_EQ(*static_cast<const uint8_t*>(tile->pixels), 1 + (x * 7 + y * 31 + 1000) % 255) << x << " " << y;
      }
    }
}

}  // namespace
}  // namespace landfix::tests
