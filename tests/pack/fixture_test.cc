// The fixture beside the specification is what the code draws, and what the runtime reads.
#include "tests/pack/fixture.h"

#include <gtest/gtest.h>
#include <jconfig.h>
#include <zstd.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "tests/pack/draw.h"
#include "tests/pack/patch.h"
#include "tests/pack/small_map.h"

namespace landfix::tests {
namespace {

std::vector<uint8_t> version_1_0() { return read_file(LANDFIX_FIXTURES "/version_1_0.lfpack"); }
std::vector<uint8_t> fixture() { return read_file(LANDFIX_FIXTURES "/small.lfpack"); }

// The public key of the fixtures' README.
constexpr PublicKey kKey = {0xfc, 0xef, 0x46, 0x62, 0x4f, 0x86, 0x1d, 0xb7, 0xdf, 0x87, 0xfd,
                            0xe5, 0x7f, 0xe2, 0xa3, 0x5a, 0x5e, 0xb9, 0x22, 0x1b, 0x9c, 0xb5,
                            0x93, 0x1a, 0xb2, 0xe5, 0x3e, 0x7f, 0xdd, 0x50, 0x56, 0xf4};

TEST(Fixture, IsSmallSignedAndWhole) {
  EXPECT_LE(fixture().size(), 200000u);
  const OpenPack pack(fixture(), {.copy = false, .trusted_keys = {kKey}});
  ASSERT_EQ(pack.status(), LF_OK);
  EXPECT_EQ(*pack->verify(true), 14u);
}

TEST(Fixture, OfTheFirstVersionIsReadAsEver) {
  const OpenPack pack(version_1_0(), {.copy = false, .trusted_keys = {kKey}});
  ASSERT_EQ(pack.status(), LF_OK);
  EXPECT_EQ(pack->info().version_minor, 0);
  EXPECT_EQ(pack->info().layer_count, 3u);
  EXPECT_EQ(pack->info().epoch_count, 0u);
  EXPECT_EQ(*pack->verify(true), 6u);
  // The raw tile, which no compressor has touched, is the same in both versions.
  const OpenPack newest(fixture());
  const auto old_tile = pack->tile(0, 0, 1952, 19529), tile = newest->tile(0, 0, 1952, 19529);
  ASSERT_TRUE(old_tile);
  ASSERT_TRUE(tile);
  EXPECT_EQ(std::memcmp(old_tile->pixels, tile->pixels, 65536), 0);
}

TEST(Fixture, OfTheSecondVersionIsReadAsEver) {
  const OpenPack pack(read_file(LANDFIX_FIXTURES "/version_1_1.lfpack"), {.copy = false, .trusted_keys = {kKey}});
  ASSERT_EQ(pack.status(), LF_OK);
  EXPECT_EQ(pack->info().version_minor, 1);
  EXPECT_EQ(pack->info().layer_count, 4u);
  EXPECT_EQ(*pack->verify(true), 10u);
}

TEST(Fixture, OfTheThirdVersionIsReadAsEver) {
  const OpenPack pack(read_file(LANDFIX_FIXTURES "/version_1_2.lfpack"), {.copy = false, .trusted_keys = {kKey}});
  ASSERT_EQ(pack.status(), LF_OK);
  EXPECT_EQ(pack->info().version_minor, 2);
  EXPECT_EQ(pack->info().layer_count, 6u);
  EXPECT_EQ(*pack->verify(true), 14u);
}

TEST(Fixture, OrientationIsTheSameInEveryCodec) {
  // Tiles a (raw), b (Zstandard) and c (context, with ponds without data) against the values that were drawn.
  const OpenPack pack(fixture());
  const uint32_t layer = pack.layer("orientation");
  ASSERT_EQ(pack->layer(layer)->pixel_type, LF_BIT);
  const lf_info i = pack->info();
  const Region r = *pack->box(layer, i.west_m, i.south_m, i.west_m + 512, i.south_m + 512, 1);
  ASSERT_EQ(pack->prepare(r), LF_OK);
  std::vector<uint64_t> out(4 * 8 * 512);
  ASSERT_EQ(pack->read_bits(r, out, 8, 8 * 512), LF_OK);
  size_t without_data = 0, plus = 0, minus = 0;
  for (size_t w = 0; w < 8 * 512; ++w) {
    const uint64_t a_plus = out[w], a_minus = out[4096 + w], b_plus = out[8192 + w], b_minus = out[12288 + w];
    const uint64_t nodata = a_plus & a_minus & b_plus & b_minus;
    EXPECT_EQ(a_plus & a_minus, nodata) << "plus and minus together mean nodata, and in both channels";
    EXPECT_EQ(b_plus & b_minus, nodata);
    without_data += size_t(std::popcount(nodata));
    plus += size_t(std::popcount(a_plus & ~nodata)), minus += size_t(std::popcount(a_minus & ~nodata));
  }
  EXPECT_GT(without_data, 65536u) << "the hole, and the ponds";
  EXPECT_LT(without_data, 65536u * 5 / 4);
  EXPECT_GT(plus, 50000u);
  EXPECT_GT(minus, 50000u);
}

TEST(Fixture, EpochsOfItsTiles) {
  const OpenPack pack(fixture());
  ASSERT_EQ(pack->info().epoch_count, 2u);
  EXPECT_STREQ(pack->epoch(0)->date, "2021-06-30");
  EXPECT_EQ(pack->epoch(1)->sources[0], 1);
  std::array<uint16_t, 4> out{};
  EXPECT_EQ(*pack->tile_epochs(pack.layer("gray"), 0, 1952, 19529, out), 1u);
  EXPECT_EQ(*pack->tile_epochs(pack.layer("orientation"), 0, 1952, 19529, out), 2u);
  EXPECT_EQ(*pack->tile_epochs(pack.layer("height"), 2, 488, 4882, out), 0u);
}

TEST(Fixture, DrawnAgainItHasTheSameBytes) {
  // Compressed bytes are those of the compressors' versions; the tree's fixture was drawn with these.
  if (ZSTD_versionNumber() != 10504 || LIBJPEG_TURBO_VERSION_NUMBER != 2001005)
    GTEST_SKIP()
        << "drawn with zstd 1.5.4 and libjpeg-turbo 2.1.5; DrawnAgainItHasTheSameContent compares what is in it";
  EXPECT_TRUE(draw_fixture() == fixture())
      << "run landfix_draw_fixture draw schemas/fixtures/small.lfpack if the change was meant";
}

TEST(Fixture, DrawnAgainItHasTheSameContent) {
  const OpenPack tree(fixture()), drawn(draw_fixture());
  ASSERT_EQ(tree.status(), LF_OK);
  ASSERT_EQ(drawn.status(), LF_OK);
  const lf_info a = tree->info(), b = drawn->info();
  EXPECT_EQ(a.west_m, b.west_m);
  EXPECT_EQ(a.north_m, b.north_m);
  ASSERT_EQ(a.layer_count, b.layer_count);
  for (uint32_t l = 0; l < a.layer_count; ++l) {
    if (tree->layer(l)->pixel_type != LF_U8) continue;
    for (uint32_t k = 0; k < tree->layer(l)->level_count; ++k) {
      const Region r = *tree->box(l, a.west_m, a.south_m, a.east_m, a.north_m, tree->level(l, k)->gsd_m);
      ASSERT_EQ(tree->prepare(r), LF_OK);
      ASSERT_EQ(drawn->prepare(r), LF_OK);
      const size_t channels = tree->layer(l)->channels;
      const std::vector<uint8_t> x = read(*tree, r, channels).pixels, y = read(*drawn, r, channels).pixels;
      ASSERT_EQ(x.size(), y.size());
      for (size_t i = 0; i < x.size(); ++i)
        ASSERT_LE(std::abs(int(x[i]) - int(y[i])), 2) << "layer " << l << " pixel " << i;
    }
  }
}

TEST(Fixture, HeightsGeoidAndSources) {
  const OpenPack pack(fixture());
  const uint32_t layer = pack.layer("height");
  const lf_info i = pack->info();
  ASSERT_EQ(pack->prepare(*pack->box(layer, i.west_m, i.south_m, i.east_m, i.north_m, 4)), LF_OK);
  EXPECT_TRUE(pack->height(i.west_m + 100, i.south_m + 100)->from_layer);
  EXPECT_FALSE(pack->height(i.west_m + 1000, i.south_m + 100)->from_layer);  // without data east of column 240
  EXPECT_EQ(pack->height(i.west_m + 1000, i.south_m + 100)->height_m, 441.25);
  EXPECT_EQ(*pack->undulation(500000, 5000000), 47.5);  // the grid's middle node
  EXPECT_STREQ(pack->source(0)->capture_date, "2021-06-30");
  EXPECT_STREQ(pack->source(1)->capture_date, "2009-08-18");
  EXPECT_STREQ(pack->source(2)->vertical_datum, "egm96");
}

TEST(Fixture, EveryFlippedByteIsFoundByTheDeepCheck) {
  // One byte in every 97: 3800 reserved bytes, padding before the raw tile and all tile data among them.
  const std::vector<uint8_t> good = fixture();
  for (size_t i = 0; i < good.size(); i += 97) {
    std::vector<uint8_t> bytes = good;
    bytes[i] ^= 0x01;
    const OpenPack pack(std::move(bytes));
    if (pack.status() != LF_OK) continue;
    ASSERT_FALSE(pack->verify(true)) << "byte " << i;
  }
}

}  // namespace
}  // namespace landfix::tests
