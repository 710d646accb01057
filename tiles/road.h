// Roads: a planar graph of centrelines, cut at tile borders, and how a tile of it is coded. schemas/FORMAT.md section
// 3.6.2 is the specification.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "tiles/vector_tile.h"

namespace landfix::tiles {

/// What a node is follows from its place and its edges; tiles do not code it.
enum class RoadNodeKind : uint8_t {
  kEnd = 0,           ///< one edge
  kIntersection = 1,  ///< three edges or more
  kBorder = 2,        ///< on the tile's border: the road goes on at the same position in the tile beyond
  kJoint = 3          ///< two edges, or a ring's only node: the road goes on as another edge
};

struct RoadPoint {
  double east_m = 0, north_m = 0;
};

struct RoadNode {
  double east_m = 0, north_m = 0;
  RoadNodeKind kind = RoadNodeKind::kEnd;
};

struct RoadEdge {
  uint32_t from = 0, to = 0;  ///< indices of nodes; equal for a ring
  double width_m = 0;
  double confidence = 0;            ///< probability, 0 to 1, that there is a road
  uint16_t source = 0;              ///< as Landmark::source
  std::vector<RoadPoint> vertices;  ///< between the two nodes, in order
};

struct RoadGraph {
  std::vector<RoadNode> nodes;
  std::vector<RoadEdge> edges;
};

struct RoadTile {
  TileIndex tile;
  RoadGraph graph;
};

inline constexpr uint32_t kMaxTileVertices = 1u << 18;

/// Cuts a graph of any extent at the borders of tiles, with every position on the lattice. The kinds of its nodes are
/// found from their degrees, whatever they say; nodes without edges, edges without length and edges off the grid are
/// left out. What lies on a border is moved by one step into the tile to its north or east, so that borders hold border
/// nodes alone. In the order of the tiles' Hilbert keys.
std::vector<RoadTile> cut_roads(const RoadGraph& graph);

/// Codes the graph of a tile as cut_roads() gives it: the same bytes for the same graph. Empty where there is no edge,
/// more than kMaxTileFeatures nodes or edges or kMaxTileVertices vertices, an index of no node, or a position outside
/// of the tile and its border.
std::vector<uint8_t> encode_roads(const TileIndex& tile, const RoadGraph& graph);

/// The inverse; nodes are in Morton order, edges by their first node. Never reads outside of `data`, and the graph has
/// at most as many parts as encode_roads() takes; false where these are not the bytes that the graph is coded as, or
/// memory ran out.
bool decode_roads(const TileIndex& tile, std::span<const uint8_t> data, RoadGraph& graph) noexcept;

/// An edge as it leaves a node.
struct RoadArm {
  uint32_t edge = 0;
  /// Direction in which it leaves, clockwise from grid north in [0, 2 pi): to the place kBearingReach_m along it.
  double bearing_rad = 0;
};
inline constexpr double kBearingReach_m = 10;

/// The arms of every node, by ascending bearing; a ring is two arms of its node.
std::vector<std::vector<RoadArm>> arms_of(const RoadGraph& graph);

struct RoadIntersection {
  double east_m = 0, north_m = 0;
  double confidence = 0;      ///< that at least three roads meet: the third greatest of the arms'
  std::vector<RoadArm> arms;  ///< three or more, by ascending bearing
};

/// The nodes where three edges or more meet, in the order of the nodes; false where memory ran out.
bool intersections_of(const RoadGraph& graph, std::vector<RoadIntersection>& intersections) noexcept;

/// An edge from its first node along its vertices to its last.
std::vector<RoadPoint> line_of(const RoadGraph& graph, const RoadEdge& edge);

/// Length of an edge along its vertices.
double length_of(const RoadGraph& graph, const RoadEdge& edge);

}  // namespace landfix::tiles
