// What extraction hands over becomes tiles for the catalog and the writer.
#include "builder/export/vector_layers.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "builder/catalog/hash.h"
#include "builder/error.h"

namespace landfix::exporter {
namespace {

constexpr double kSide = 2048;

std::vector<tiles::Landmark> row_of_landmarks(int count) {
  std::vector<tiles::Landmark> out(static_cast<size_t>(count));
  for (int i = 0; i < count; ++i) out[size_t(i)].east_m = 100.0 * i, out[size_t(i)].north_m = 5000;
  return out;
}

TEST(VectorLayers, HaveOneLevelAndTheirContent) {
  EXPECT_EQ(landmarks_layer().name, "landmarks");
  EXPECT_EQ(landmarks_layer().content, VectorContent::kLandmarks);
  EXPECT_EQ(roads_layer().content, VectorContent::kRoads);
  ASSERT_EQ(roads_layer().levels.size(), 1u);
  EXPECT_EQ(roads_layer().levels[0].level, 3);
}

TEST(VectorLayers, TilesOfLandmarksAreFinishedButForTheOffset) {
  std::vector<tiles::Landmark> landmarks = row_of_landmarks(50);  // over three tiles
  const auto epochs = [](const tiles::TileIndex& tile) { return catalog::EpochSet{uint16_t(tile.x)}; };
  const auto tiles = landmark_tiles(landmarks, epochs);
  ASSERT_EQ(tiles.size(), 3u);
  EXPECT_TRUE(std::ranges::is_sorted(tiles, {}, [](const catalog::FinishedTile& t) { return t.record.key; }));
  size_t found = 0;
  for (const catalog::FinishedTile& t : tiles) {
    const tiles::TileIndex index = tiles::tile_of_key(3, t.record.key);
    EXPECT_EQ(t.layer, "landmarks");
    EXPECT_EQ(t.level, 3);
    EXPECT_EQ(t.record.codec, 4);
    EXPECT_EQ(t.record.length, t.data.size());
    EXPECT_EQ(t.record.hash, catalog::hash_of(t.data));
    EXPECT_EQ(t.record.value_step, 0);
    EXPECT_EQ(t.epochs, catalog::EpochSet{uint16_t(index.x)});
    std::vector<tiles::Landmark> out;
    ASSERT_TRUE(tiles::decode_landmarks(index, t.data, out));
    found += out.size();
  }
  EXPECT_EQ(found, landmarks.size());
  std::ranges::reverse(landmarks);
  const auto again = landmark_tiles(landmarks, epochs);
  for (size_t i = 0; i < tiles.size(); ++i) EXPECT_EQ(again[i].data, tiles[i].data) << "whatever their order";
}

TEST(VectorLayers, WhatIsOffTheGridIsLeftOut) {
  std::vector<tiles::Landmark> landmarks = row_of_landmarks(3);
  landmarks[0].east_m = std::numeric_limits<double>::quiet_NaN();
  landmarks[1].north_m = 1e12;
  const auto tiles = landmark_tiles(landmarks);
  ASSERT_EQ(tiles.size(), 1u);
  EXPECT_TRUE(tiles[0].epochs.empty());
  EXPECT_TRUE(landmark_tiles({}).empty());
}

TEST(VectorLayers, OfTooManyLandmarksTheSurestAreKept) {
  std::vector<tiles::Landmark> landmarks(tiles::kMaxTileFeatures + 1000);
  for (size_t i = 0; i < landmarks.size(); ++i) {
    landmarks[i].east_m = 1 + 0.25 * double(i % 8000), landmarks[i].north_m = 1 + double(i / 8000);
    landmarks[i].confidence = i % 10 == 0 ? 0.2 : 0.8;
  }
  std::vector<std::string> warnings;
  const auto tiles = landmark_tiles(landmarks, {}, &warnings);
  ASSERT_EQ(tiles.size(), 1u);
  std::vector<tiles::Landmark> out;
  ASSERT_TRUE(tiles::decode_landmarks({3, 0, 0}, tiles[0].data, out));
  ASSERT_EQ(out.size(), tiles::kMaxTileFeatures);
  const auto doubtful = std::ranges::count_if(out, [](const tiles::Landmark& m) { return m.confidence < 0.5; });
  EXPECT_EQ(doubtful, 6654 - 1000) << "every tenth was, and a thousand of these had to go";
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("65536 of 66536 landmarks"), std::string::npos) << warnings[0];
}

TEST(VectorLayers, OfEvenlySureLandmarksTheDistinctAndLongStayAndTheRestFromAllOverTheTile) {
  std::vector<tiles::Landmark> landmarks(80000);
  for (size_t i = 0; i < landmarks.size(); ++i) {
    landmarks[i].east_m = 2 + 5 * double(i % 400), landmarks[i].north_m = 2 + 10 * double(i / 400);
    landmarks[i].confidence = 1, landmarks[i].length_m = landmarks[i].width_m = 6;
    if (i % 16 == 0) landmarks[i].distinctiveness_m = 512;
    if (i % 16 == 1) landmarks[i].length_m = 60;
  }
  const auto tiles = landmark_tiles(landmarks);
  std::vector<tiles::Landmark> out;
  ASSERT_TRUE(tiles::decode_landmarks({3, 0, 0}, tiles[0].data, out));
  EXPECT_EQ(std::ranges::count_if(out, [](const auto& m) { return m.distinctiveness_m == 512; }), 5000);
  EXPECT_EQ(std::ranges::count_if(out, [](const auto& m) { return m.length_m > 50; }), 5000);
  // 55536 of the 70000 others: 79 % of the 17500 or so in each quarter, give or take what chance would (4 sigma: 220).
  for (int quarter = 0; quarter < 4; ++quarter) {
    const auto here = std::ranges::count_if(out, [&](const tiles::Landmark& m) {
      return m.distinctiveness_m < 512 && m.length_m < 50 && (m.east_m > 1001) == (quarter % 2 == 1) &&
             (m.north_m > 1001) == (quarter / 2 == 1);
    });
    EXPECT_NEAR(double(here), 55536.0 / 4, 300) << quarter;
  }
}

TEST(VectorLayers, RoadsAreCutIntoTiles) {
  tiles::RoadGraph graph;
  graph.nodes = {{100, 100}, {kSide + 100, 100}};
  graph.edges = {{0, 1, 6, 1, 0, {}}};
  const auto tiles = road_tiles(graph);
  ASSERT_EQ(tiles.size(), 2u);
  EXPECT_EQ(tiles[0].layer, "roads");
  EXPECT_EQ(tiles[0].record.codec, 4);
  EXPECT_TRUE(road_tiles({}).empty());
}

TEST(VectorLayers, OfTooManyRoadsTheWidestAndLongestAreKept) {
  tiles::RoadGraph graph;
  for (int i = 0; i < 70000; ++i) {
    graph.nodes.push_back({1 + 0.25 * (i % 300), 1 + double(i / 300)});
    graph.nodes.push_back({1000 + 0.25 * (i % 300), 1 + double(i / 300)});
    graph.edges.push_back({uint32_t(2 * i), uint32_t(2 * i + 1), i % 10 == 0 ? 8.0 : 5.0, 1, 0, {}});
  }
  std::vector<std::string> warnings;
  const auto tiles = road_tiles(graph, {}, &warnings);
  ASSERT_EQ(tiles.size(), 1u);
  tiles::RoadGraph out;
  ASSERT_TRUE(tiles::decode_roads({3, 0, 0}, tiles[0].data, out));
  EXPECT_EQ(out.nodes.size(), tiles::kMaxTileFeatures) << "two for each stretch are what runs out first";
  EXPECT_EQ(out.edges.size(), tiles::kMaxTileFeatures / 2);
  EXPECT_EQ(std::ranges::count_if(out.edges, [](const auto& edge) { return edge.width_m > 7; }), 7000);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("32768 of 70000 stretches"), std::string::npos) << warnings[0];
}

}  // namespace
}  // namespace landfix::exporter
