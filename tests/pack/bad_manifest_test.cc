// Manifests that are hashed right and wrong nevertheless, and those of a newer landfix.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "schemas/pack_generated.h"
#include "tests/pack/patch.h"
#include "tests/pack/small_map.h"

namespace landfix::tests {
namespace {

using flatbuffers::FlatBufferBuilder;
using flatbuffers::Offset;
using Bytes = std::vector<uint8_t>;

struct TestLevel {
  int8_t level;
  uint32_t first_block, block_count, tile_count;
};

struct TestLayer {
  std::string name = "gray";
  uint8_t kind = 0, pixel_type = 0, channels = 1;
  int16_t nodata = 0;
  std::vector<TestLevel> levels = {{0, 0, 1, 5}, {1, 1, 1, 4}};
  uint8_t content = 0;
  bool newer_field = false;  ///< a field that this version does not know
};

struct TestEpoch {
  std::string date;
  std::vector<uint16_t> sources;
};

// The manifest of the small map, every number of it free to change.
struct TestManifest {
  uint8_t zone = 32;
  double bounds[4] = {kWestM, kSouthM, kEastM, kNorthM};
  std::vector<TestLayer> layers = {{}};
  double plane_height_m = 0;
  float georegistration_error_m = -1;
  std::optional<size_t> sha256_bytes = 32;  ///< none: no source
  bool has_geoid = true;
  double geoid_west_m = 0, geoid_spacing_m = 1000;
  uint32_t geoid_columns = 2, geoid_rows = 3;
  std::vector<float> undulation_m = {1, 2, 3, 4, 5, 6};
  std::vector<TestEpoch> epochs = {{"2018-07-16", {0}}, {"2009-08-18", {}}, {"", {}}};
  std::vector<std::vector<uint16_t>> epoch_sets = {{0}, {0, 2}};
  bool newer_field = false;
  std::string identifier = "LFPM";

  Bytes bytes() const;
};

Offset<schema::Layer> encode(FlatBufferBuilder& b, const TestLayer& l) {
  std::vector<Offset<schema::Level>> levels;
  for (const TestLevel& v : l.levels)
    levels.push_back(schema::CreateLevel(b, v.level, v.first_block, v.block_count, v.tile_count));
  const auto level_vector = b.CreateVector(levels);
  const auto name = b.CreateString(l.name);
  schema::LayerBuilder layer(b);
  layer.add_name(name);
  layer.add_kind(schema::LayerKind(l.kind));
  layer.add_pixel_type(schema::PixelType(l.pixel_type));
  layer.add_channels(l.channels);
  layer.add_nodata(l.nodata);
  layer.add_levels(level_vector);
  layer.add_content(schema::VectorContent(l.content));
  if (l.newer_field) b.AddElement<uint64_t>(flatbuffers::FieldIndexToOffset(12), 77, 0);
  return layer.Finish();
}

Offset<schema::Epoch> encode(FlatBufferBuilder& b, const TestEpoch& e) {
  const auto date = b.CreateString(e.date);
  return schema::CreateEpoch(b, date, b.CreateVector(e.sources));
}

Bytes TestManifest::bytes() const {
  FlatBufferBuilder b;
  std::vector<Offset<schema::Epoch>> epoch_offsets;
  for (const TestEpoch& e : epochs) epoch_offsets.push_back(encode(b, e));
  const auto epoch_vector = b.CreateVector(epoch_offsets);
  std::vector<Offset<schema::EpochSet>> set_offsets;
  for (const auto& set : epoch_sets) set_offsets.push_back(schema::CreateEpochSet(b, b.CreateVector(set)));
  const auto set_vector = b.CreateVector(set_offsets);
  std::vector<Offset<schema::Layer>> layer_offsets;
  for (const TestLayer& l : layers) layer_offsets.push_back(encode(b, l));
  const auto layer_vector = b.CreateVector(layer_offsets);
  std::vector<Offset<schema::Source>> sources;
  if (sha256_bytes) {
    const auto name = b.CreateString("photo.tif");
    const auto digest = b.CreateVector(Bytes(*sha256_bytes));
    sources.push_back(schema::CreateSource(b, name, schema::SourceRole::Image, digest));
  }
  const auto source_vector = b.CreateVector(sources);
  const auto model = b.CreateString("egm96");
  const auto nodes = b.CreateVector(undulation_m);
  const auto geoid = schema::CreateGeoid(b, model, geoid_west_m, 0, geoid_spacing_m, geoid_columns, geoid_rows, nodes);
  const auto grid = schema::CreateGrid(b, zone, true);
  const schema::Bounds box(bounds[0], bounds[1], bounds[2], bounds[3]);
  const auto later = b.CreateString("what a later landfix has to say");
  schema::ManifestBuilder m(b);
  m.add_grid(grid);
  m.add_bounds(&box);
  m.add_layers(layer_vector);
  m.add_sources(source_vector);
  if (has_geoid) m.add_geoid(geoid);
  m.add_plane_height_m(plane_height_m);
  m.add_georegistration_error_m(georegistration_error_m);
  m.add_epochs(epoch_vector);
  m.add_epoch_sets(set_vector);
  if (newer_field) b.AddOffset(flatbuffers::FieldIndexToOffset(20), later);
  b.Finish(m.Finish(), identifier.c_str());
  return {b.GetBufferPointer(), b.GetBufferPointer() + b.GetSize()};
}

Bytes with_manifest(const Bytes& manifest, uint16_t version_minor = schema::kVersionMinor) {
  static const Bytes small = small_pack();
  Patch p(small);
  p.replace_manifest(manifest);
  p.header().version_minor = version_minor;
  p.rehash_header();
  return std::move(p.bytes());
}

Status status_with(const std::function<void(TestManifest&)>& change) {
  TestManifest m;
  change(m);
  return open_status(with_manifest(m.bytes()));
}

TEST(HostileManifest, AnotherOneOfTheSameMapOpens) {
  const OpenPack pack(with_manifest(TestManifest{}.bytes()));
  ASSERT_EQ(pack.status(), LF_OK);
  EXPECT_EQ(*pack->verify(true), 9u);
  EXPECT_EQ(pack->info().epoch_count, 3u);
  EXPECT_EQ(status_with([](TestManifest& m) { m.has_geoid = false; }), LF_OK);
  EXPECT_EQ(status_with([](TestManifest& m) { m.epochs.clear(), m.epoch_sets.clear(); }), LF_OK);
  EXPECT_EQ(status_with([](TestManifest& m) { m.epochs[1].date = m.epochs[0].date; }), LF_OK);  // other bands, say
  for (const int16_t nodata : {0, 1})
    EXPECT_EQ(status_with([=](TestManifest& m) { m.layers[0].pixel_type = 2, m.layers[0].nodata = nodata; }), LF_OK);
}

TEST(HostileManifest, RangesAreChecked) {
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  const std::pair<const char*, std::function<void(TestManifest&)>> changes[] = {
      {"zone 61", [](TestManifest& m) { m.zone = 61; }},
      {"bounds not a number", [=](TestManifest& m) { m.bounds[0] = nan; }},
      {"bounds infinite", [=](TestManifest& m) { m.bounds[2] = infinity; }},
      {"bounds outside the grid", [](TestManifest& m) { m.bounds[3] = 4e7; }},
      {"west of east", [](TestManifest& m) { std::swap(m.bounds[0], m.bounds[2]); }},
      {"south of north", [](TestManifest& m) { std::swap(m.bounds[1], m.bounds[3]); }},
      {"plane", [=](TestManifest& m) { m.plane_height_m = nan; }},
      {"georegistration", [](TestManifest& m) { m.georegistration_error_m = std::nanf(""); }},
      {"digest of 31 bytes", [](TestManifest& m) { m.sha256_bytes = 31; }},
      {"geoid one column", [](TestManifest& m) { m.geoid_columns = 1, m.geoid_rows = 6; }},
      {"geoid one node short", [](TestManifest& m) { m.undulation_m.pop_back(); }},
      {"geoid counts overflow",
       [](TestManifest& m) { m.geoid_columns = m.geoid_rows = 65536, m.undulation_m.clear(); }},
      {"geoid spacing 0", [](TestManifest& m) { m.geoid_spacing_m = 0; }},
      {"geoid spacing", [=](TestManifest& m) { m.geoid_spacing_m = nan; }},
      {"geoid west", [=](TestManifest& m) { m.geoid_west_m = infinity; }},
      {"geoid node", [](TestManifest& m) { m.undulation_m[4] = std::nanf(""); }},
      {"identifier", [](TestManifest& m) { m.identifier = "LFPX"; }},
      {"65 layers", [](TestManifest& m) { m.layers.assign(65, {.name = "x", .kind = 1}); }},
      {"two layers of one name",
       [](TestManifest& m) {
         m.layers = {{.levels = {{0, 0, 1, 5}}}, {.levels = {{1, 1, 1, 4}}}};
       }},
      {"no levels", [](TestManifest& m) { m.layers[0].levels.clear(); }},
      {"level 14", [](TestManifest& m) { m.layers[0].levels[1].level = 14; }},
      {"level -11", [](TestManifest& m) { m.layers[0].levels[0].level = -11; }},
      {"levels not finest first", [](TestManifest& m) { std::swap(m.layers[0].levels[0], m.layers[0].levels[1]); }},
      {"a level twice", [](TestManifest& m) { m.layers[0].levels[1].level = 0; }},
      {"run beyond the table", [](TestManifest& m) { m.layers[0].levels[1].block_count = 2; }},
      {"run far beyond the table",
       [](TestManifest& m) {
         m.layers[0].levels[1] = {1, UINT32_MAX, UINT32_MAX, 4};
       }},
      {"overlapping runs", [](TestManifest& m) { m.layers[0].levels[1].first_block = 0; }},
      {"run over two levels' blocks",
       [](TestManifest& m) {
         m.layers[0].levels = {{0, 0, 2, 9}};
       }},
      {"overlapping runs of two layers",
       [](TestManifest& m) {
         m.layers = {{.levels = {{0, 0, 1, 5}}}, {.name = "b", .levels = {{0, 0, 1, 5}}}};
       }},
      {"u8 nodata 256", [](TestManifest& m) { m.layers[0].nodata = 256; }},
      {"u8 nodata -1", [](TestManifest& m) { m.layers[0].nodata = -1; }},
      {"bit nodata 2", [](TestManifest& m) { m.layers[0].pixel_type = 2, m.layers[0].nodata = 2; }},
      {"landmarks without a level", [](TestManifest& m) { m.layers[0] = {.kind = 1, .levels = {}, .content = 1}; }},
      {"landmarks at level 2",
       [](TestManifest& m) {
         m.layers[0] = {.kind = 1, .levels = {{2, 0, 1, 5}}, .content = 1};
       }},
      {"roads at two levels",
       [](TestManifest& m) {
         m.layers[0] = {.kind = 1, .levels = {{3, 0, 1, 5}, {4, 1, 1, 4}}, .content = 2};
       }},
      {"bit nodata -1", [](TestManifest& m) { m.layers[0].pixel_type = 2, m.layers[0].nodata = -1; }},
      {"epochs oldest first", [](TestManifest& m) { std::swap(m.epochs[0], m.epochs[1]); }},
      {"undated before dated", [](TestManifest& m) { std::swap(m.epochs[1], m.epochs[2]); }},
      {"epoch of a source that is not there", [](TestManifest& m) { m.epochs[1].sources = {1}; }},
      {"epoch of a source twice",
       [](TestManifest& m) {
         m.epochs[1].sources = {0, 0};
       }},
      {"set of an epoch that is not there",
       [](TestManifest& m) {
         m.epoch_sets[1] = {0, 3};
       }},
      {"set of no epoch", [](TestManifest& m) { m.epoch_sets[1].clear(); }},
      {"set of an epoch twice",
       [](TestManifest& m) {
         m.epoch_sets[1] = {1, 1};
       }},
      {"set not ascending",
       [](TestManifest& m) {
         m.epoch_sets[1] = {2, 0};
       }},
      {"sets without epochs", [](TestManifest& m) { m.epochs.clear(); }},
      {"65536 epochs", [](TestManifest& m) { m.epochs.assign(65536, {}); }},
      {"65536 sets", [](TestManifest& m) { m.epoch_sets.assign(65536, {0}); }},
  };
  for (const auto& [name, change] : changes) EXPECT_EQ(status_with(change), LF_DAMAGED) << name;
}

TEST(HostileManifest, BytesThatAreNoFlatBuffer) {
  Bytes manifest = TestManifest{}.bytes();
  EXPECT_EQ(open_status(with_manifest({})), LF_DAMAGED);
  EXPECT_EQ(open_status(with_manifest(Bytes(100, 0))), LF_DAMAGED);
  EXPECT_EQ(open_status(with_manifest(Bytes(100, 0xFF))), LF_DAMAGED);
  EXPECT_EQ(open_status(with_manifest({manifest.begin(), manifest.begin() + 40})), LF_DAMAGED);
  // Every byte set to every extreme, hashed right: some open (a changed number is a number), none crashes.
  int opened = 0;
  for (size_t i = 0; i < manifest.size(); ++i)
    for (const uint8_t value : {uint8_t(0), uint8_t(0x7F), uint8_t(0x80), uint8_t(0xFF)}) {
      Bytes changed = manifest;
      changed[i] = value;
      const OpenPack pack(with_manifest(changed));
      ASSERT_TRUE(pack.status() == LF_OK || pack.status() == LF_DAMAGED) << i;
      if (pack.status() != LF_OK) continue;
      ++opened;
      // The verdict may be any; reaching every record must be safe.
      (void)pack->verify(false);
      (void)pack->source(0);
      (void)pack->undulation(100, 100);
    }
  EXPECT_GT(opened, 100);
}

TEST(HostileManifest, TileCountsAndStrayBlocksAreFoundByVerifying) {
  TestManifest count;
  count.layers[0].levels[1].tile_count = 5;
  const OpenPack wrong(with_manifest(count.bytes()));
  ASSERT_EQ(wrong.status(), LF_OK);
  EXPECT_EQ(wrong->verify(false).status(), LF_DAMAGED);
  TestManifest stray;
  stray.layers[0].levels.pop_back();  // block 1 belongs to nobody
  const OpenPack pack(with_manifest(stray.bytes()));
  ASSERT_EQ(pack.status(), LF_OK);
  EXPECT_EQ(*pack->verify(false), 5u);
  EXPECT_EQ(pack->verify(true).status(), LF_DAMAGED);
  // Even one that leaves no stray bytes behind: its records are those of block 0, what was its own is zero.
  Patch p(with_manifest(stray.bytes()));
  for (const schema::TileRecord& tile : p.tiles(p.blocks()[1])) std::ranges::fill(p.data(tile), uint8_t(0));
  std::ranges::fill(p.tiles(p.blocks()[1]), schema::TileRecord{});
  p.blocks()[1] = p.blocks()[0];
  p.rehash();
  const OpenPack hidden(std::move(p.bytes()));
  ASSERT_EQ(hidden.status(), LF_OK);
  EXPECT_EQ(*hidden->verify(false), 5u);
  EXPECT_EQ(hidden->verify(true).status(), LF_DAMAGED);
}

TEST(NewerMinor, UnknownLayersAndFieldsAreSkipped) {
  TestManifest m;
  m.newer_field = true;
  m.layers[0].levels = {{0, 0, 1, 5}};
  m.layers[0].newer_field = true;
  m.layers.push_back({.name = "swarm", .kind = 7, .levels = {{1, 1, 1, 4}}});
  m.layers.push_back({.name = "float", .pixel_type = 9, .levels = {}});
  m.layers.push_back({.name = "complex", .pixel_type = 1, .channels = 2, .levels = {{3, 99, 1, 1}}});
  m.layers.push_back({.name = "roads", .kind = 1, .levels = {}});
  m.layers.push_back({.name = "borders", .kind = 1, .levels = {}, .content = 3});
  m.layers.push_back({.name = "nothing", .channels = 0, .levels = {}});
  m.layers.push_back({.name = "no bits", .pixel_type = 2, .channels = 0, .levels = {}});
  m.layers.push_back({.name = "many bits", .pixel_type = 2, .channels = 17, .levels = {}});
  for (const uint16_t minor : {0, 1, 2, 3, 4, 65535}) {
    const OpenPack pack(with_manifest(m.bytes(), minor));
    ASSERT_EQ(pack.status(), LF_OK) << minor;
    EXPECT_EQ(pack->info().version_minor, minor);
    EXPECT_EQ(pack->info().layer_count, 1u);
    EXPECT_EQ(pack->find_layer("swarm").status(), LF_NO_SUCH_LAYER);
    EXPECT_EQ(pack->find_layer("complex").status(), LF_NO_SUCH_LAYER);
    const Read got = read(*pack, *pack->box(0, kWestM, kSouthM, kEastM, kNorthM, 1));
    ASSERT_EQ(got.status, LF_OK);
    EXPECT_EQ(got.pixels[0], pattern({'a', 0, 0, 0, 0}));
    // What an unknown layer uses is no stray data in a newer version; this version knows all its layers.
    EXPECT_EQ(pack->verify(true).status(), minor <= 3 ? LF_DAMAGED : LF_OK) << minor;
  }
}

}  // namespace
}  // namespace landfix::tests
