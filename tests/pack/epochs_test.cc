// Which capture dates went into a tile and into a region.
#include <gtest/gtest.h>

#include <array>

#include "tests/pack/patch.h"
#include "tests/pack/small_map.h"

namespace landfix::tests {
namespace {

// The small map with three epochs and an undated one. a and b show the two newest, c the oldest two, d is made from an
// undated image alone, E does not say.
Drawing dated() {
  Drawing drawing{.layers = {small_gray()}};
  exporter::PackDescription& d = drawing.description;
  d.bounds = {kWestM, kSouthM, kEastM, kNorthM};
  for (const char* name : {"2009.tif", "undated.tif", "2018.tif", "2014.tif", "2014 too.tif"}) {
    d.sources.emplace_back();
    d.sources.back().source.name = name;
  }
  d.epochs = {{"2018-07-16", {2}}, {"2014-07-20", {3, 4}}, {"2009-08-18", {0}}, {"", {1}}};
  drawing.layers[0].epochs = [](char letter) -> catalog::EpochSet {
    switch (letter) {
      case 'a':
      case 'b':
        return {0, 1};
      case 'c':
        return {1, 2};
      case 'd':
        return {3};
    }
    return {};
  };
  return drawing;
}

std::vector<uint16_t> epochs_of(const OpenPack& pack, int32_t x, int32_t y) {
  std::array<uint16_t, 8> out{};
  const auto count = pack->tile_epochs(0, 0, kWestX + x, kSouthY + y, out);
  EXPECT_TRUE(count) << count.text();
  return {out.begin(), out.begin() + *count};
}

TEST(Epochs, AreListedNewestFirst) {
  const OpenPack pack(draw(dated()));
  ASSERT_EQ(pack->info().epoch_count, 4u);
  EXPECT_STREQ(pack->epoch(0)->date, "2018-07-16");
  EXPECT_STREQ(pack->epoch(2)->date, "2009-08-18");
  EXPECT_STREQ(pack->epoch(3)->date, "");
  const lf_epoch_info e = *pack->epoch(1);
  ASSERT_EQ(e.source_count, 2u);
  EXPECT_STREQ(pack->source(e.sources[0])->name, "2014.tif");
  EXPECT_STREQ(pack->source(e.sources[1])->name, "2014 too.tif");
  EXPECT_EQ(pack->epoch(4).status(), LF_INVALID_ARGUMENT);
}

TEST(Epochs, OfATile) {
  const OpenPack pack(draw(dated()));
  using List = std::vector<uint16_t>;
  EXPECT_EQ(epochs_of(pack, 0, 1), (List{0, 1}));  // a
  EXPECT_EQ(epochs_of(pack, 1, 1), (List{0, 1}));  // b
  EXPECT_EQ(epochs_of(pack, 2, 1), (List{1, 2}));  // c
  EXPECT_EQ(epochs_of(pack, 0, 0), (List{3}));     // d
  EXPECT_EQ(epochs_of(pack, 2, 0), (List{}));      // E
  EXPECT_EQ(*pack->verify(true), 9u);
}

TEST(Epochs, OfATileThatIsNotThereOrIntoALittleSpace) {
  const OpenPack pack(draw(dated()));
  std::array<uint16_t, 8> out{};
  EXPECT_EQ(pack->tile_epochs(0, 0, kWestX + 1, kSouthY, out).status(), LF_OUTSIDE_MAP);
  EXPECT_EQ(pack->tile_epochs(0, 5, kWestX, kSouthY, out).status(), LF_INVALID_ARGUMENT);
  EXPECT_EQ(pack->tile_epochs(1, 0, kWestX, kSouthY, out).status(), LF_INVALID_ARGUMENT);
  uint32_t count = 77;
  out = {9, 9};
  EXPECT_EQ(lf_tile_epochs(pack.c_pack(), 0, 0, kWestX, kSouthY + 1, out.data(), 1, &count), LF_BUFFER_TOO_SMALL);
  EXPECT_EQ(count, 2u) << "how much space it takes";
  EXPECT_EQ(out[0], 9) << "nothing is written";
  EXPECT_EQ(lf_tile_epochs(pack.c_pack(), 0, 0, kWestX, kSouthY + 1, nullptr, 0, &count), LF_BUFFER_TOO_SMALL);
  EXPECT_EQ(lf_tile_epochs(pack.c_pack(), 0, 0, kWestX + 2, kSouthY, nullptr, 0, &count), LF_OK);
  EXPECT_EQ(count, 0u);
}

TEST(Epochs, OfARegionAreItsNewestAndItsOldest) {
  const OpenPack pack(draw(dated()));
  const auto range = [&](double west, double south, double east, double north) {
    const auto r = pack->epochs(*pack->box(0, kWestM + west, kSouthM + south, kWestM + east, kSouthM + north, 1));
    EXPECT_TRUE(r) << r.text();
    return std::array{r->newest, r->oldest, r->tiles, r->dated_tiles};
  };
  using Range = std::array<uint32_t, 4>;
  EXPECT_EQ(range(0, 0, 768, 512), (Range{0, 3, 5, 4}));
  EXPECT_EQ(range(10, 300, 20, 310), (Range{0, 1, 1, 1}));    // a
  EXPECT_EQ(range(500, 300, 520, 310), (Range{0, 2, 2, 2}));  // b and c
  EXPECT_EQ(range(520, 300, 530, 310), (Range{1, 2, 1, 1}));  // c
  EXPECT_EQ(range(500, 10, 530, 20), (Range{0, 0, 1, 0}));    // the hole and E, which does not say
  EXPECT_EQ(range(200, 10, 300, 20), (Range{3, 3, 1, 1}));    // d and the hole: undated
  EXPECT_EQ(pack->epochs(*pack->box(0, kWestM + 300, kSouthM + 10, kWestM + 400, kSouthM + 20, 1)).status(),
            LF_OUTSIDE_MAP);
  Region bad = *pack->box(0, kWestM, kSouthM, kEastM, kNorthM, 1);
  bad.width = 0;
  EXPECT_EQ(pack->epochs(bad).status(), LF_INVALID_ARGUMENT);
}

TEST(Epochs, APackWithoutThemSaysSo) {
  const OpenPack pack(small_pack());
  EXPECT_EQ(pack->info().epoch_count, 0u);
  EXPECT_EQ(pack->epoch(0).status(), LF_INVALID_ARGUMENT);
  EXPECT_TRUE(epochs_of(pack, 0, 0).empty());
  const auto range = pack->epochs(*pack->box(0, kWestM, kSouthM, kEastM, kNorthM, 1));
  ASSERT_TRUE(range);
  EXPECT_EQ(range->tiles, 5u);
  EXPECT_EQ(range->dated_tiles, 0u);
}

TEST(Epochs, EqualTilesOfOtherDatesShareTheirDataOnly) {
  Drawing drawing = dated();
  drawing.layers[0].levels = {{0, kWestX, kSouthY, "ad"}};
  drawing.layers[0].pixel = [](const PixelOf&) { return 5; };
  drawing.description.bounds = {};
  const OpenPack pack(draw(drawing));
  EXPECT_EQ(pack->tile(0, 0, kWestX, kSouthY)->pixels, pack->tile(0, 0, kWestX + 1, kSouthY)->pixels);
  EXPECT_EQ(epochs_of(pack, 0, 0), (std::vector<uint16_t>{0, 1}));
  EXPECT_EQ(epochs_of(pack, 1, 0), (std::vector<uint16_t>{3}));
}

TEST(HostileEpochs, ATileWhoseSetIsNotThereIsDamagedAlone) {
  Patch p(draw(dated()));
  for (schema::TileRecord& tile : p.tiles(p.blocks()[0])) {
    const tiles::TileIndex t = tiles::tile_of_key(0, tile.key);
    if (t.x == kWestX && t.y == kSouthY) tile.epoch_set = 4;  // d; there are three sets
  }
  p.rehash_blocks();
  const OpenPack pack(std::move(p.bytes()));
  ASSERT_EQ(pack.status(), LF_OK);
  std::array<uint16_t, 8> out{};
  EXPECT_EQ(pack->tile_epochs(0, 0, kWestX, kSouthY, out).status(), LF_DAMAGED);
  EXPECT_EQ(pack->tile(0, 0, kWestX, kSouthY).status(), LF_DAMAGED);
  const Region whole = *pack->box(0, kWestM, kSouthM, kEastM, kNorthM, 1);
  EXPECT_EQ(pack->epochs(whole).status(), LF_DAMAGED);
  EXPECT_EQ(read(*pack, whole).status, LF_DAMAGED);
  EXPECT_EQ(pack->verify(false).status(), LF_DAMAGED);
  EXPECT_EQ(epochs_of(pack, 0, 1).size(), 2u);
  EXPECT_TRUE(pack->tile(0, 0, kWestX, kSouthY + 1));
}

}  // namespace
}  // namespace landfix::tests
