// The pack writer against schemas/FORMAT.md, byte by byte, and what it leaves behind when it fails.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>

#include "builder/catalog/hash.h"
#include "builder/error.h"
#include "builder/export/pack_writer.h"
#include "schemas/pack_generated.h"

namespace landfix::exporter {
namespace {

namespace fs = std::filesystem;
using schema::BlockRecord;
using schema::Header;
using schema::TileRecord;

constexpr size_t kRawBytes = 256 * 256;

// A pack drawn in memory: tile data by the offset that its record carries.
struct Drawing {
  PackDescription description;
  std::map<uint64_t, std::vector<uint8_t>> data;

  TileRecord add(uint64_t key, tiles::Codec codec, std::vector<uint8_t> bytes) {
    TileRecord r{};
    r.key = key;
    r.offset = data.size();
    r.length = uint32_t(bytes.size());
    r.codec = uint8_t(codec);
    r.hash = catalog::hash_of(bytes);
    data[r.offset] = std::move(bytes);
    return r;
  }
  ReadTile reader() const {
    return [this](const TileRecord& tile, std::span<uint8_t> out) {
      const auto& bytes = data.at(tile.offset);
      ASSERT_EQ(out.size(), bytes.size());
      std::copy(bytes.begin(), bytes.end(), out.begin());
    };
  }
};

// Layer `gray`: 300 raw tiles of three greys at level 0 and one at level 2 (none at level 1); layer `overview`: two
// coded tiles.
Drawing draw() {
  Drawing d;
  d.description.zone = {36, true};
  d.description.bounds = {0, 0, 4096, 8192};
  d.description.plane_height_m = 412.5;
  d.description.builder = "landfix test";
  d.description.parameters = {{"gsd_m", "1"}};
  ingest::Source source;
  source.path = "/somewhere/secret/town.tif";
  source.name = "town.tif";
  source.sha256 = std::string(62, '0') + "a5";
  source.date = "2018-07-16";
  source.bands = {ingest::BandRole::kRed, ingest::BandRole::kNir};
  source.gsd_m = 0.6;
  d.description.sources = {{SourceRole::kImage, source}};
  d.description.geoid = ingest::GeoidGrid{"egm96", 0, 4000, 4000, 2, 2, {1, 2, 3, 4}};

  PackLayer gray{"gray", "test", {tiles::PixelType::kU8, 1, 0}, {{0, {}}, {1, {}}, {2, {}}}};
  for (uint64_t i = 0; i < 300; ++i)
    gray.levels[0].tiles.push_back(
        d.add(1000 + 2 * i, tiles::Codec::kRaw, std::vector<uint8_t>(kRawBytes, uint8_t(1 + i % 3))));
  gray.levels[2].tiles.push_back(d.add(7, tiles::Codec::kRaw, std::vector<uint8_t>(kRawBytes, 9)));
  PackLayer overview{"overview", "", {tiles::PixelType::kU8, 3, 0}, {{2, {}}}};
  overview.levels[0].tiles.push_back(d.add(7, tiles::Codec::kJpeg, {1, 2, 3}));
  overview.levels[0].tiles.push_back(d.add(8, tiles::Codec::kJpeg, {4, 5, 6, 7}));
  d.description.layers = {gray, overview};
  return d;
}

std::vector<uint8_t> bytes_of_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

template <typename T>
T record_at(const std::vector<uint8_t>& file, uint64_t offset) {
  T record;
  std::memcpy(&record, file.data() + offset, sizeof record);
  return record;
}

schema::Hash hash_of_part(const std::vector<uint8_t>& file, uint64_t offset, uint64_t length) {
  return catalog::hash_of(std::span(file).subspan(offset, length));
}

class PackWriterTest : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  size_t files() const { return size_t(std::distance(fs::directory_iterator(folder_), fs::directory_iterator())); }

  const fs::path folder_ = fs::path(testing::TempDir()) / ("export_test_" + std::to_string(::getpid()));
  const fs::path path_ = folder_ / "a.lfpack";
};

TEST_F(PackWriterTest, WritesHeaderAndSectionsAsSpecified) {
  const Drawing d = draw();
  const PackStatistics statistics = write_pack(path_, d.description, d.reader());
  const std::vector<uint8_t> file = bytes_of_file(path_);
  const auto header = record_at<Header>(file, 0);
  EXPECT_EQ(0, std::memcmp(header.magic, "\x89LFP\r\n\x1A\n", 8));
  EXPECT_EQ(header.version_major, 1);
  EXPECT_EQ(header.version_minor, 3);
  EXPECT_EQ(header.page_size, 4096u);
  EXPECT_EQ(header.file_length, file.size());
  EXPECT_EQ(statistics.file_bytes, file.size());
  EXPECT_EQ(header.manifest_offset, 4096u);
  EXPECT_EQ(header.block_table_offset, (4096 + header.manifest_length + 7) / 8 * 8);
  EXPECT_EQ(header.block_count, 4u);  // 300 tiles: 2 blocks; then one for each of the two levels that hold tiles
  EXPECT_EQ(header.manifest_hash, hash_of_part(file, 4096, header.manifest_length));
  EXPECT_EQ(header.block_table_hash, hash_of_part(file, header.block_table_offset, 4 * 64));
  EXPECT_EQ(header.root, hash_of_part(file, 0, 128));
  EXPECT_EQ(header.header_hash, hash_of_part(file, 0, 4064));
  EXPECT_TRUE(
      std::all_of(file.begin() + 160, file.begin() + 4064, [](uint8_t b) { return b == 0; }));  // unsigned, reserved
}

TEST_F(PackWriterTest, WritesDirectoriesInOrder) {
  const Drawing d = draw();
  write_pack(path_, d.description, d.reader());
  const std::vector<uint8_t> file = bytes_of_file(path_);
  const auto header = record_at<Header>(file, 0);
  const uint32_t counts[] = {256, 44, 1, 2};
  const uint64_t first_keys[] = {1000, 1512, 7, 7}, last_keys[] = {1510, 1598, 7, 8};
  uint64_t expected_offset = header.block_table_offset + 4 * 64;
  for (uint64_t b = 0; b < 4; ++b) {
    const auto block = record_at<BlockRecord>(file, header.block_table_offset + b * 64);
    EXPECT_EQ(block.count, counts[b]);
    EXPECT_EQ(block.first_key, first_keys[b]);
    EXPECT_EQ(block.last_key, last_keys[b]);
    EXPECT_EQ(block.offset, expected_offset);
    EXPECT_EQ(block.hash, hash_of_part(file, block.offset, 64 * block.count));
    expected_offset += 64 * block.count;
    for (uint32_t i = 0; i < block.count; ++i) {
      const auto tile = record_at<TileRecord>(file, block.offset + i * 64);
      EXPECT_EQ(tile.hash, hash_of_part(file, tile.offset, tile.length));
      EXPECT_EQ(tile.offset % (tile.codec == 0 ? 4096 : 8), 0u);
    }
  }
}

TEST_F(PackWriterTest, StoresEqualTilesOnce) {
  const Drawing d = draw();
  const PackStatistics statistics = write_pack(path_, d.description, d.reader());
  EXPECT_EQ(statistics.tiles, 303u);
  EXPECT_EQ(statistics.stored_tiles, 6u);  // 3 greys, the coarse tile, 2 coded ones
  const std::vector<uint8_t> file = bytes_of_file(path_);
  const uint64_t directory = record_at<Header>(file, 0).block_table_offset + 4 * 64;
  EXPECT_EQ(record_at<TileRecord>(file, directory).offset, record_at<TileRecord>(file, directory + 3 * 64).offset);
  EXPECT_NE(record_at<TileRecord>(file, directory).offset, record_at<TileRecord>(file, directory + 64).offset);
  // Directories (303 records), 4 raw tiles from the next page on, then 3 bytes, padding to 8, 4 bytes.
  const uint64_t raw_end = (directory + 303 * 64 + 4095) / 4096 * 4096 + 4 * kRawBytes;
  EXPECT_EQ(file.size(), raw_end + 8 + 4);
}

TEST_F(PackWriterTest, WritesTheManifest) {
  const Drawing d = draw();
  write_pack(path_, d.description, d.reader());
  const std::vector<uint8_t> file = bytes_of_file(path_);
  const auto header = record_at<Header>(file, 0);
  flatbuffers::Verifier verifier(file.data() + 4096, header.manifest_length);
  ASSERT_TRUE(schema::VerifyManifestBuffer(verifier));
  const schema::Manifest& m = *schema::GetManifest(file.data() + 4096);
  EXPECT_EQ(m.grid()->zone(), 36);
  EXPECT_EQ(m.bounds()->north_m(), 8192);
  EXPECT_EQ(m.plane_height_m(), 412.5);
  EXPECT_EQ(m.georegistration_error_m(), -1.0f);  // not stated
  ASSERT_EQ(m.layers()->size(), 2u);
  const auto& levels = *m.layers()->Get(0)->levels();
  ASSERT_EQ(levels.size(), 2u);  // level 1 has no tiles
  EXPECT_EQ(levels.Get(0)->first_block(), 0u);
  EXPECT_EQ(levels.Get(0)->block_count(), 2u);
  EXPECT_EQ(levels.Get(0)->tile_count(), 300u);
  EXPECT_EQ(levels.Get(1)->level(), 2);
  EXPECT_EQ(levels.Get(1)->first_block(), 2u);
  EXPECT_EQ(m.layers()->Get(1)->levels()->Get(0)->first_block(), 3u);
  EXPECT_EQ(m.layers()->Get(1)->channels(), 3);
  const schema::Source& source = *m.sources()->Get(0);
  EXPECT_EQ(source.name()->str(), "town.tif");
  EXPECT_EQ(source.sha256()->size(), 32u);
  EXPECT_EQ(source.sha256()->Get(31), 0xA5);
  EXPECT_EQ(source.capture_date()->str(), "2018-07-16");
  EXPECT_EQ(source.licence(), nullptr);
  EXPECT_EQ(source.bands()->Get(1)->str(), "nir");
  EXPECT_EQ(m.geoid()->undulation_m()->Get(3), 4.0f);
  EXPECT_EQ(m.parameters()->Get(0)->value()->str(), "1");
  const std::string secret = "secret";  // where the inputs lay is nobody's business
  EXPECT_EQ(std::search(file.begin(), file.end(), secret.begin(), secret.end()), file.end());
}

TEST_F(PackWriterTest, LeavesOutRasterLayersWithoutTiles) {
  Drawing d = draw();
  PackLayer contour{"contour", "", {tiles::PixelType::kU8, 1, 255}, {{0, {}}, {1, {}}}};
  PackLayer roads{"roads", "", {}, {{3, {}}}};
  roads.content = VectorContent::kRoads;
  d.description.layers.insert(d.description.layers.begin(), {contour, roads});
  write_pack(path_, d.description, d.reader());
  const std::vector<uint8_t> file = bytes_of_file(path_);
  const auto& layers = *schema::GetManifest(file.data() + 4096)->layers();
  ASSERT_EQ(layers.size(), 3u);  // a raster layer of no level is damage to every reader; no roads are an answer
  EXPECT_EQ(layers.Get(0)->name()->str(), "roads");
  EXPECT_EQ(layers.Get(1)->name()->str(), "gray");
  EXPECT_EQ(layers.Get(2)->levels()->Get(0)->first_block(), 3u);
}

// Tiles of three sets of epochs, in the order of `sets`; what a tile shows is the same whatever this order is.
Drawing dated(std::vector<catalog::EpochSet> sets) {
  Drawing d = draw();
  d.description.sources.resize(3, d.description.sources[0]);
  d.description.epochs = {{"2018-07-16", {0, 2}}, {"2009-08-18", {1}}, {"", {}}};
  const catalog::EpochSet wanted[] = {{1, 2}, {0}, {0, 1, 2}};
  const auto number_of = [&](const catalog::EpochSet& set) {
    return uint16_t(std::find(sets.begin(), sets.end(), set) - sets.begin() + 1);
  };
  for (PackLayer& layer : d.description.layers)
    for (PackLevel& level : layer.levels)
      for (TileRecord& tile : level.tiles)
        if (tile.key % 3) tile.epoch_set = number_of(wanted[tile.key % 5 % 3]);
  d.description.epoch_sets = std::move(sets);
  return d;
}

TEST_F(PackWriterTest, WritesEpochsAndTheSetsInUse) {
  // {1, 2} comes first in the file: tile 1000 names it; {0, 1} is named by nobody.
  const Drawing d = dated({{0, 1}, {0, 1, 2}, {1, 2}, {0}});
  write_pack(path_, d.description, d.reader());
  const std::vector<uint8_t> file = bytes_of_file(path_);
  const schema::Manifest& m = *schema::GetManifest(file.data() + 4096);
  ASSERT_EQ(m.epochs()->size(), 3u);
  EXPECT_EQ(m.epochs()->Get(0)->date()->str(), "2018-07-16");
  EXPECT_EQ(m.epochs()->Get(0)->sources()->Get(1), 2);
  EXPECT_EQ(m.epochs()->Get(2)->date(), nullptr);
  ASSERT_EQ(m.epoch_sets()->size(), 3u);
  EXPECT_EQ(m.epoch_sets()->Get(0)->epochs()->Get(0), 1);
  const uint64_t directory = record_at<Header>(file, 0).block_table_offset + 4 * 64;
  for (uint64_t i = 0; i < 303; ++i) {
    const auto tile = record_at<TileRecord>(file, directory + i * 64);
    if (tile.key % 3 == 0) {
      EXPECT_EQ(tile.epoch_set, 0) << "not stated";
      continue;
    }
    ASSERT_TRUE(tile.epoch_set >= 1 && tile.epoch_set <= 3);
    const auto& set = *m.epoch_sets()->Get(tile.epoch_set - 1u)->epochs();
    const catalog::EpochSet wanted[] = {{1, 2}, {0}, {0, 1, 2}};
    EXPECT_EQ(catalog::EpochSet(set.begin(), set.end()), wanted[tile.key % 5 % 3]) << tile.key;
  }
  EXPECT_EQ(record_at<TileRecord>(file, directory).epoch_set, 1) << "numbers count up in the order of the tiles";
}

TEST_F(PackWriterTest, GivesTheSameBytesWhateverOrderTheSetsWereFoundIn) {
  // Twice the same set, too: two jobs may have found it.
  const Drawing d = dated({{0, 1}, {0, 1, 2}, {1, 2}, {0}});
  Drawing other = dated({{0}, {1, 2}, {0, 1, 2}});
  other.description.epoch_sets.push_back({0});
  for (TileRecord& tile : other.description.layers[0].levels[0].tiles)
    if (tile.epoch_set == 1 && tile.key % 2 == 0) tile.epoch_set = 4;
  write_pack(path_, d.description, d.reader());
  write_pack(folder_ / "b.lfpack", other.description, other.reader());
  EXPECT_EQ(bytes_of_file(path_), bytes_of_file(folder_ / "b.lfpack"));
}

TEST_F(PackWriterTest, RefusesEpochsThatNoReaderWouldTake) {
  const std::pair<const char*, std::function<void(PackDescription&)>> changes[] = {
      {"a tile of a set that is not there", [](auto& d) { d.layers[0].levels[0].tiles[9].epoch_set = 5; }},
      {"a set of an epoch that is not there",
       [](auto& d) {
         d.epoch_sets[0] = {0, 3};
       }},
      {"an empty set", [](auto& d) { d.epoch_sets[0].clear(); }},
      {"a set that is not ascending",
       [](auto& d) {
         d.epoch_sets[0] = {1, 0};
       }},
      {"an epoch twice",
       [](auto& d) {
         d.epoch_sets[0] = {1, 1};
       }},
      {"a source that is not there", [](auto& d) { d.epochs[0].sources = {3}; }},
      {"sources that are not ascending",
       [](auto& d) {
         d.epochs[0].sources = {2, 0};
       }},
      {"oldest first", [](auto& d) { std::swap(d.epochs[0], d.epochs[1]); }},
      {"undated first", [](auto& d) { std::swap(d.epochs[1], d.epochs[2]); }},
      {"too many", [](auto& d) { d.epochs.resize(65536); }},
  };
  for (const auto& [name, change] : changes) {
    Drawing d = dated({{0, 1}, {0, 1, 2}, {1, 2}, {0}});
    change(d.description);
    EXPECT_THROW(write_pack(path_, d.description, d.reader()), Error) << name;
    EXPECT_EQ(files(), 0u) << name;
  }
}

TEST_F(PackWriterTest, GivesTheSameBytesAndReplacesAFile) {
  const Drawing d = draw();
  std::ofstream(path_) << "an old file";
  write_pack(path_, d.description, d.reader());
  write_pack(folder_ / "b.lfpack", d.description, d.reader());
  EXPECT_EQ(bytes_of_file(path_), bytes_of_file(folder_ / "b.lfpack"));
  EXPECT_EQ(files(), 2u);
}

TEST_F(PackWriterTest, LeavesNothingWhereReadingFails) {
  const Drawing d = draw();
  int calls = 0;
  const auto failing = [&](const TileRecord& tile, std::span<uint8_t> out) {
    if (++calls == 3) throw Error(ExitCode::kIo, "spool: gone");
    d.reader()(tile, out);
  };
  EXPECT_THROW(write_pack(path_, d.description, failing), Error);
  EXPECT_EQ(files(), 0u);
}

TEST_F(PackWriterTest, RefusesTilesOutOfOrder) {
  Drawing d = draw();
  std::swap(d.description.layers[0].levels[0].tiles[5], d.description.layers[0].levels[0].tiles[6]);
  EXPECT_THROW(write_pack(path_, d.description, d.reader()), Error);
  EXPECT_EQ(files(), 0u);
}

// A limit on the size of files stands for a full disk: the write fails in the middle, as it does there.
TEST_F(PackWriterTest, SaysHowMuchAFullDiskWouldHaveToHold) {
  const Drawing d = draw();
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto previous = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{100'000, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
  std::string message;
  try {
    write_pack(path_, d.description, d.reader());
  } catch (const Error& error) {
    if (error.code() == ExitCode::kIo) message = error.what();
  }
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, previous);
  EXPECT_NE(message.find("needs 0.3 MB"), std::string::npos) << message;  // 4 raw tiles, header, directories: 290 kB
  EXPECT_NE(message.find("free space"), std::string::npos) << message;
  EXPECT_EQ(files(), 0u);
}

}  // namespace
}  // namespace landfix::exporter
