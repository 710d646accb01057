// Roads: cut at tile borders without loss, coded small, and what follows from the graph.
#include "tiles/road.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "tests/tiles/random.h"

namespace landfix::tiles {
namespace {

using std::numbers::pi;
using tests::Random;

constexpr double kSide = 2048;

RoadGraph decoded(const RoadTile& tile) {
  RoadGraph graph;
  EXPECT_TRUE(decode_roads(tile.tile, encode_roads(tile.tile, tile.graph), graph));
  return graph;
}

double total_length(const RoadGraph& graph) {
  double sum = 0;
  for (const RoadEdge& edge : graph.edges) sum += length_of(graph, edge);
  return sum;
}

// A grid of streets `spacing_m` apart over `size_m`, bent by a wave of 10 m, from (0, 0).
RoadGraph streets(double size_m, double spacing_m, double vertex_m) {
  RoadGraph g;
  const int n = int(size_m / spacing_m);
  const auto wave = [](double x, double y) {
    return RoadPoint{x + 10 * std::sin(y / 170), y + 10 * std::sin(x / 130)};
  };
  for (int i = 0; i <= n; ++i)
    for (int k = 0; k <= n; ++k) {
      const RoadPoint p = wave(i * spacing_m + 30, k * spacing_m + 30);
      g.nodes.push_back({p.east_m, p.north_m});
    }
  const auto add = [&](int i, int k, int di, int dk) {
    RoadEdge e{uint32_t(i * (n + 1) + k),
               uint32_t((i + di) * (n + 1) + k + dk),
               4 + double((i + k) % 3),
               0.6 + 0.1 * ((i * 7 + k) % 5),
               0,
               {}};
    for (double t = vertex_m; t < spacing_m - 1; t += vertex_m)
      e.vertices.push_back(wave(i * spacing_m + 30 + di * t, k * spacing_m + 30 + dk * t));
    g.edges.push_back(e);
  };
  for (int i = 0; i <= n; ++i)
    for (int k = 0; k <= n; ++k) {
      if (i < n) add(i, k, 1, 0);
      if (k < n) add(i, k, 0, 1);
    }
  return g;
}

TEST(CutRoads, ALineAcrossThreeTilesMeetsItselfAtTheBorders) {
  RoadGraph g;
  g.nodes = {{100, 100}, {2 * kSide + 100, 300}};
  g.edges = {{0, 1, 6, 0.8, 0, {}}};
  const auto tiles = cut_roads(g);
  ASSERT_EQ(tiles.size(), 3u);
  double length = 0;
  std::map<std::pair<double, double>, int> borders;
  for (const RoadTile& t : tiles) {
    const RoadGraph part = decoded(t);
    ASSERT_EQ(part.edges.size(), 1u);
    length += total_length(part);
    for (const RoadNode& n : part.nodes) {
      if (n.kind != RoadNodeKind::kBorder) continue;
      ++borders[{n.east_m, n.north_m}];
      EXPECT_EQ(std::fmod(n.east_m, kSide), 0);
    }
  }
  EXPECT_NEAR(length, std::hypot(2 * kSide, 200), 0.5);
  ASSERT_EQ(borders.size(), 2u) << "each border is crossed at one place";
  for (const auto& [place, times] : borders) EXPECT_EQ(times, 2) << "which both tiles have";
}

TEST(CutRoads, ADiagonalCrossesBordersOfBothKindsInTheirOrder) {
  // Falls to the south-east over eleven borders, from negative coordinates.
  RoadGraph g;
  g.nodes = {{-5000, 9000}, {7000, -1700}};
  g.edges = {{0, 1, 6, 0.8, 0, {{1000, 3000}}}};
  double length = 0;
  size_t pieces = 0;
  for (const RoadTile& t : cut_roads(g)) {
    const RoadGraph part = decoded(t);
    pieces += part.edges.size(), length += total_length(part);
    for (const RoadNode& n : part.nodes) {
      const double along = n.north_m > 3000 ? (n.east_m + 5000) / 6000 : (n.east_m - 1000) / 6000;
      EXPECT_NEAR(n.north_m, n.north_m > 3000 ? 9000 - 6000 * along : 3000 - 4700 * along, 0.4) << "on the line";
    }
  }
  EXPECT_EQ(pieces, 12u);
  EXPECT_NEAR(length, std::hypot(6000, 6000) + std::hypot(6000, 4700), 1);
}

TEST(CutRoads, KeepsEveryCrossingAndTheWholeLength) {
  const RoadGraph g = streets(6000, 250, 25);
  double length = 0;
  size_t intersections = 0, pieces = 0;
  for (const RoadTile& t : cut_roads(g)) {
    const RoadGraph part = decoded(t);
    std::vector<RoadIntersection> found;
    ASSERT_TRUE(intersections_of(part, found));
    intersections += found.size(), length += total_length(part), pieces += part.edges.size();
  }
  const size_t all = 25 * 25, corners = 4;
  EXPECT_EQ(intersections, all - corners);
  EXPECT_NEAR(length, total_length(g), 1e-4 * total_length(g));
  EXPECT_GT(pieces, g.edges.size());
}

TEST(CutRoads, WhatLiesOnABorderMovesIntoOneTile) {
  // A crossing on the corner of four tiles, its arms along the borders.
  RoadGraph g;
  g.nodes = {{kSide, kSide}, {kSide, 0}, {kSide, 2 * kSide}, {0, kSide}, {2 * kSide, kSide}};
  for (uint32_t i = 1; i <= 4; ++i) g.edges.push_back({0, i, 5, 1, 0, {}});
  size_t crossings = 0;
  double length = 0;
  for (const RoadTile& t : cut_roads(g)) {
    const RoadGraph part = decoded(t);
    std::vector<RoadIntersection> found;
    ASSERT_TRUE(intersections_of(part, found));
    for (const RoadIntersection& i : found) {
      EXPECT_EQ(i.arms.size(), 4u);
      EXPECT_EQ(i.east_m, kSide + 0.25);
    }
    crossings += found.size(), length += total_length(part);
  }
  EXPECT_EQ(crossings, 1u);
  EXPECT_NEAR(length, 4 * kSide, 1);
}

TEST(CutRoads, LeavesOutWhatIsNoRoad) {
  RoadGraph g;
  g.nodes = {{10, 10}, {10.05, 10}, {500, 500}, {std::nan(""), 0}};
  g.edges = {{0, 1, 5, 1, 0, {}}, {0, 3, 5, 1, 0, {}}, {0, 9, 5, 1, 0, {}}};
  EXPECT_TRUE(cut_roads(g).empty()) << "without length, off the grid, to no node";
  EXPECT_TRUE(cut_roads({}).empty());
}

TEST(Roads, KindsFollowFromTheEdges) {
  RoadGraph g;
  g.nodes = {{100, 100}, {200, 100}, {300, 100}, {200, 200}, {200, 300}, {1000, 1000}};
  g.edges = {{0, 1, 5, 0.4, 0, {}},
             {1, 2, 5, 0.8, 0, {}},
             {1, 3, 7, 0.6, 0, {}},
             {3, 4, 4, 1, 0, {}},
             {5, 5, 3, 1, 2, {{1040, 1000}, {1040, 1040}}}};
  const RoadGraph out = decoded({{kVectorLevel, 0, 0}, g});
  std::map<std::pair<double, double>, RoadNodeKind> kinds;
  for (const RoadNode& n : out.nodes) kinds[{n.east_m, n.north_m}] = n.kind;
  EXPECT_EQ((kinds[{100, 100}]), RoadNodeKind::kEnd);
  EXPECT_EQ((kinds[{200, 100}]), RoadNodeKind::kIntersection);
  EXPECT_EQ((kinds[{200, 200}]), RoadNodeKind::kJoint);
  EXPECT_EQ((kinds[{1000, 1000}]), RoadNodeKind::kJoint) << "a ring's only node";
  std::vector<RoadIntersection> found;
  ASSERT_TRUE(intersections_of(out, found));
  ASSERT_EQ(found.size(), 1u);
  ASSERT_EQ(found[0].arms.size(), 3u);
  EXPECT_NEAR(found[0].arms[0].bearing_rad, 0, 1e-9);
  EXPECT_NEAR(found[0].arms[1].bearing_rad, pi / 2, 1e-9);
  EXPECT_NEAR(found[0].arms[2].bearing_rad, 3 * pi / 2, 1e-9);
  EXPECT_NEAR(out.edges[found[0].arms[0].edge].width_m, 7.13, 0.01) << "0.5 * 2^(23/6)";
  EXPECT_NEAR(found[0].confidence, 0.4, 1e-9) << "the third road is as doubtful as that";
}

TEST(Roads, AnIntersectionIsAsSureAsItsThirdSurestRoad) {
  RoadGraph g;
  g.nodes = {{100, 100}};
  const double confidences[] = {0.2, 1, 0.4, 0.8, 0.6};
  for (uint32_t i = 0; i < 5; ++i) {
    g.nodes.push_back({100 + 50 * std::cos(double(i)), 100 + 50 * std::sin(double(i))});
    g.edges.push_back({0, i + 1, 5, confidences[i], 0, {}});
  }
  std::vector<RoadIntersection> found;
  ASSERT_TRUE(intersections_of(decoded({{kVectorLevel, 0, 0}, g}), found));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].confidence, 0.6, 1e-9);
}

TEST(Roads, BearingsLookTenMetresAhead) {
  // The first metres go north, the road goes east.
  RoadGraph g;
  g.nodes = {{100, 100}, {200, 102}};
  g.edges = {{0, 1, 5, 1, 0, {{100, 102}}}};
  const auto arms = arms_of(g);
  ASSERT_EQ(arms[0].size(), 1u);
  EXPECT_NEAR(arms[0][0].bearing_rad, std::atan2(8, 2), 1e-9);
  EXPECT_NEAR(arms[1][0].bearing_rad, 1.5 * pi, 1e-9);
}

TEST(Roads, OfOneTileHaveTheSameBytesHoweverTheyAreWritten) {
  RoadGraph g = cut_roads(streets(1500, 300, 30)).at(0).graph;
  g.nodes.push_back({1800, 1800});  // a ring
  g.edges.push_back(
      {uint32_t(g.nodes.size() - 1), uint32_t(g.nodes.size() - 1), 3, 1, 0, {{1850, 1800}, {1800, 1850}}});
  const TileIndex tile{kVectorLevel, 0, 0};
  const auto bytes = encode_roads(tile, g);
  for (RoadEdge& e : g.edges) {
    std::swap(e.from, e.to);
    std::reverse(e.vertices.begin(), e.vertices.end());
  }
  std::reverse(g.edges.begin(), g.edges.end());
  EXPECT_EQ(encode_roads(tile, g), bytes);
}

TEST(Roads, TakeLessThanAHundredBytesForAKilometre) {
  // 8 km/km2 of bent streets with a vertex every 25 m; with landmarks 4 kB/km2 are allowed.
  const RoadGraph g = streets(8000, 250, 25);
  size_t bytes = 0;
  for (const RoadTile& t : cut_roads(g)) bytes += (encode_roads(t.tile, t.graph).size() + 7) / 8 * 8 + 64;
  const double kilometres = total_length(g) / 1000;
  EXPECT_LT(double(bytes) / kilometres, 100);
  EXPECT_GT(double(bytes) / kilometres, 20);
  RecordProperty("bytes_per_km", std::to_string(double(bytes) / kilometres));
}

TEST(Roads, WhatNoTileHoldsIsRefused) {
  const TileIndex tile{kVectorLevel, 0, 0};
  RoadGraph g;
  g.nodes = {{10, 10}, {20, 20}};
  EXPECT_TRUE(encode_roads(tile, g).empty()) << "no edge";
  g.edges = {{0, 1, 5, 1, 0, {}}};
  EXPECT_FALSE(encode_roads(tile, g).empty());
  RoadGraph bad = g;
  bad.edges[0].to = 2;
  EXPECT_TRUE(encode_roads(tile, bad).empty());
  bad = g, bad.nodes.push_back({30, 30});
  EXPECT_TRUE(encode_roads(tile, bad).empty()) << "a node without an edge";
  bad = g, bad.nodes[1].east_m = 2048.5;
  EXPECT_TRUE(encode_roads(tile, bad).empty());
  bad = g, bad.edges[0].vertices = {{-1, 5}};
  EXPECT_TRUE(encode_roads(tile, bad).empty());
}

TEST(Roads, DamagedBytesAreRefusedOrAreAnotherGraph) {
  const RoadTile tile = cut_roads(streets(1500, 300, 60)).at(0);
  const auto good = encode_roads(tile.tile, tile.graph);
  RoadGraph out;
  for (size_t length = 0; length < good.size(); ++length)
    EXPECT_FALSE(decode_roads(tile.tile, std::span(good).first(length), out)) << length;
  size_t taken = 0;
  for (size_t i = 0; i < good.size(); ++i)
    for (int bit = 0; bit < 8; ++bit) {
      auto bytes = good;
      bytes[i] ^= uint8_t(1 << bit);
      if (!decode_roads(tile.tile, bytes, out)) continue;
      ++taken;
      for (const RoadEdge& e : out.edges) ASSERT_TRUE(e.from < out.nodes.size() && e.to < out.nodes.size());
      for (const RoadNode& n : out.nodes) ASSERT_TRUE(n.east_m >= 0 && n.east_m <= kSide && n.north_m <= kSide);
    }
  EXPECT_LT(taken, good.size() / 10);
  Random random(5);
  for (int round = 0; round < 300; ++round) {
    std::vector<uint8_t> bytes(size_t(random.integer(0, 400)));
    for (uint8_t& b : bytes) b = random.byte();
    if (!decode_roads(tile.tile, bytes, out)) continue;
    EXPECT_LE(out.edges.size(), kMaxTileFeatures);
  }
  EXPECT_FALSE(decode_roads(tile.tile, std::vector<uint8_t>(1 << 20, 0xFF), out));
  EXPECT_FALSE(decode_roads(tile.tile, std::vector<uint8_t>(1 << 20, 0), out));
}

}  // namespace
}  // namespace landfix::tiles
