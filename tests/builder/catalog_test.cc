// The journal of a build: what it keeps, when it starts over, who may hold it.
#include "builder/catalog/catalog.h"

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <unistd.h>

#include <fstream>

#include "builder/catalog/hash.h"
#include "builder/error.h"
#include "builder/hex.h"

namespace landfix::catalog {
namespace {

namespace fs = std::filesystem;

class CatalogTest : public testing::Test {
 protected:
  void SetUp() override { fs::remove_all(folder_); }
  void TearDown() override { fs::remove_all(folder_); }

  static FinishedTile tile(uint64_t key, std::vector<uint8_t> data) {
    FinishedTile t{"gray", 0, {}, std::move(data)};
    t.record.key = key;
    t.record.length = uint32_t(t.data.size());
    t.record.value_step = 0.01f;
    t.record.hash = hash_of(t.data);
    return t;
  }
  void fill(Catalog& catalog) const {
    std::vector<FinishedTile> tiles = {tile(9, {1, 2, 3}), tile(4, {4, 5})};
    catalog.commit({"source", 0, 1}, tiles);
    catalog.commit({"source", 0, 2}, {});
  }

  const fs::path folder_ = fs::path(testing::TempDir()) / ("catalog_test_" + std::to_string(::getpid()));
};

TEST_F(CatalogTest, GivesTilesByKeyWithTheirData) {
  Catalog catalog(folder_, "a");
  fill(catalog);
  const auto tiles = catalog.tiles("gray", 0);
  ASSERT_EQ(tiles.size(), 2u);
  EXPECT_EQ(tiles[0].key, 4u);
  EXPECT_EQ(tiles[1].key, 9u);
  EXPECT_EQ(tiles[1].value_step, 0.01f);
  std::vector<uint8_t> data(3);
  catalog.read(tiles[1], data);
  EXPECT_EQ(data, (std::vector<uint8_t>{1, 2, 3}));
  EXPECT_TRUE(catalog.tiles("gray", 1).empty());
  EXPECT_TRUE(catalog.tiles("height", 0).empty());
}

TEST_F(CatalogTest, ContinuesWhereTheFingerprintIsEqual) {
  {
    Catalog catalog(folder_, "a");
    fill(catalog);
  }
  Catalog catalog(folder_, "a");
  EXPECT_EQ(catalog.jobs_found(), 2u);
  EXPECT_EQ(catalog.note(), "");
  EXPECT_TRUE(catalog.is_done({"source", 0, 2}));
  EXPECT_FALSE(catalog.is_done({"source", 1, 2}));
  EXPECT_EQ(catalog.tiles("gray", 0).size(), 2u);
}

FinishedTile dated(FinishedTile tile, EpochSet epochs) {
  tile.epochs = std::move(epochs);
  return tile;
}

TEST_F(CatalogTest, KeepsTheEpochsOfTiles) {
  {
    Catalog catalog(folder_, "a");
    std::vector<FinishedTile> first = {dated(tile(9, {1}), {0, 2}), dated(tile(4, {2}), {}),
                                       dated(tile(5, {3}), {0, 2})};
    catalog.commit({"source", 0, 1}, first);
    std::vector<FinishedTile> second = {dated(tile(12, {4}), {500}), dated(tile(13, {5}), {0, 2})};
    catalog.commit({"source", 0, 2}, second);
  }
  Catalog catalog(folder_, "a");
  EXPECT_EQ(catalog.epoch_sets(), (std::vector<EpochSet>{{0, 2}, {500}})) << "each set once";
  std::vector<EpochSet> found;
  for (const schema::TileRecord& record : catalog.tiles("gray", 0)) found.push_back(catalog.epochs_of(record));
  EXPECT_EQ(found, (std::vector<EpochSet>{{}, {0, 2}, {0, 2}, {500}, {0, 2}}));
  // What comes later continues the numbers.
  std::vector<FinishedTile> more = {dated(tile(14, {6}), {1}), dated(tile(15, {7}), {500})};
  catalog.commit({"source", 0, 3}, more);
  EXPECT_EQ(more[0].record.epoch_set, 3);
  EXPECT_EQ(more[1].record.epoch_set, 2);
}

TEST_F(CatalogTest, StartingOverForgetsEpochs) {
  {
    Catalog catalog(folder_, "a");
    std::vector<FinishedTile> tiles = {dated(tile(9, {1}), {7})};
    catalog.commit({"source", 0, 1}, tiles);
  }
  Catalog catalog(folder_, "b");
  EXPECT_TRUE(catalog.epoch_sets().empty());
}

TEST_F(CatalogTest, RefusesMoreSetsOfEpochsThanAPackCanName) {
  Catalog catalog(folder_, "a");
  std::vector<FinishedTile> tiles;
  for (uint16_t i = 0; i < 256; ++i) tiles.push_back(dated(tile(i, {1}), {i}));
  for (uint64_t job = 0; job < 255; ++job) {
    for (FinishedTile& t : tiles) t.record.key += 256, t.epochs[0] = uint16_t(t.epochs[0] + 256);
    catalog.commit({"source", 0, job}, tiles);
  }
  EXPECT_EQ(catalog.epoch_sets().size(), 65280u);
  std::vector<FinishedTile> last;
  for (uint16_t i = 0; i < 255; ++i) last.push_back(dated(tile(i, {1}), {i}));
  catalog.commit({"source", 0, 300}, last);  // 65535 sets
  std::vector<FinishedTile> one_more = {dated(tile(70000, {1}), {0, 1})};
  try {
    catalog.commit({"source", 0, 301}, one_more);
    FAIL() << "65536 sets do not fit 16 bits";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kBadInput);
  }
  EXPECT_FALSE(catalog.is_done({"source", 0, 301}));
  one_more[0].epochs = {3};
  catalog.commit({"source", 0, 301}, one_more);
  EXPECT_TRUE(catalog.is_done({"source", 0, 301}));
}

TEST_F(CatalogTest, StartsOverWhereATileNamesEpochsThatAreNotThere) {
  {
    Catalog catalog(folder_, "a");
    std::vector<FinishedTile> tiles = {dated(tile(9, {1}), {7})};
    catalog.commit({"source", 0, 1}, tiles);
  }
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open((folder_ / "catalog.sqlite").c_str(), &database), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(database, "DELETE FROM epoch_set", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(database);
  Catalog catalog(folder_, "a");
  EXPECT_EQ(catalog.jobs_found(), 0u);
  EXPECT_NE(catalog.note().find("damaged"), std::string::npos);
}

TEST_F(CatalogTest, StartsOverForOtherInputs) {
  {
    Catalog catalog(folder_, "a");
    fill(catalog);
  }
  Catalog catalog(folder_, "b");
  EXPECT_EQ(catalog.jobs_found(), 0u);
  EXPECT_NE(catalog.note(), "");
  EXPECT_TRUE(catalog.tiles("gray", 0).empty());
}

TEST_F(CatalogTest, StartsOverWhereASpooledByteIsNotWhatWasWritten) {
  {
    Catalog catalog(folder_, "a");
    fill(catalog);
  }
  {
    std::fstream spool(folder_ / "tiles.spool", std::ios::in | std::ios::out | std::ios::binary);
    spool.seekp(1);
    spool.put(char(77));
  }
  Catalog catalog(folder_, "a");
  EXPECT_EQ(catalog.jobs_found(), 0u);
  EXPECT_NE(catalog.note().find("damaged"), std::string::npos);
}

TEST_F(CatalogTest, StartsOverWhereTheSpoolIsTooShort) {
  {
    Catalog catalog(folder_, "a");
    fill(catalog);
  }
  fs::resize_file(folder_ / "tiles.spool", 4);
  EXPECT_EQ(Catalog(folder_, "a").jobs_found(), 0u);
}

TEST_F(CatalogTest, StartsOverWhereTheJournalIsNotADatabase) {
  fs::create_directories(folder_);
  std::ofstream(folder_ / "catalog.sqlite") << std::string(5000, 'x');
  Catalog catalog(folder_, "a");
  EXPECT_NE(catalog.note().find("damaged"), std::string::npos);
  fill(catalog);
  EXPECT_EQ(catalog.tiles("gray", 0).size(), 2u);
}

// A kill between the spool's write and the journal's leaves bytes that no record points to: they are overwritten.
TEST_F(CatalogTest, OverwritesWhatWasSpooledButNotRecorded) {
  {
    Catalog catalog(folder_, "a");
    fill(catalog);
  }
  std::ofstream(folder_ / "tiles.spool", std::ios::app | std::ios::binary) << "never recorded";
  Catalog catalog(folder_, "a");
  EXPECT_EQ(catalog.jobs_found(), 2u);
  std::vector<FinishedTile> more = {tile(12, {6})};
  catalog.commit({"source", 0, 3}, more);
  EXPECT_EQ(catalog.tiles("gray", 0)[2].offset, 5u);  // after 3 + 2 bytes
}

TEST_F(CatalogTest, IsHeldByOneBuildAtATime) {
  Catalog catalog(folder_, "a");
  fill(catalog);
  try {
    Catalog second(folder_, "a");
    FAIL() << "a second build got hold of the journal";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kIo);
    EXPECT_NE(std::string(error.what()).find("another build"), std::string::npos) << error.what();
  }
  EXPECT_EQ(catalog.tiles("gray", 0).size(), 2u);
}

TEST_F(CatalogTest, DisappearsWhenTheBuildHasSucceeded) {
  Catalog catalog(folder_, "a");
  catalog.remove();
  EXPECT_FALSE(fs::exists(folder_));
}

TEST_F(CatalogTest, SaysWhereItCannotWrite) {
  std::ofstream(folder_.string()) << "a file where the folder should be";
  try {
    Catalog catalog(folder_, "a");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kIo);
    EXPECT_NE(std::string(error.what()).find(folder_.string()), std::string::npos);
  }
}

// RFC 7693's vector is for 64 bytes; this one is from Python's hashlib.blake2b(b"abc", digest_size=32).
TEST(Hash, IsBlake2bOf32Bytes) {
  const std::string text = "abc";
  const schema::Hash hash = hash_of({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
  EXPECT_EQ(hex(hash.bytes), "bddd813c634239723171ef3fee98579b94964e3bb1cb3e427262c8c068d52319");
}

}  // namespace
}  // namespace landfix::catalog
