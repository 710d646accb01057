// Cutting a graph of roads at the borders of tiles.
#include <algorithm>
#include <cmath>
#include <map>

#include "tiles/road.h"

namespace landfix::tiles {
namespace {

struct Position {
  double x = 0, y = 0;  // steps
};

Position between(const LatticePoint& a, const LatticePoint& b, double t) {
  return {double(a.east) + t * double(b.east - a.east), double(a.north) + t * double(b.north - a.north)};
}

TileIndex tile_at(const Position& p) {
  return {kVectorLevel, int32_t(std::floor(p.x / double(kTileSteps))), int32_t(std::floor(p.y / double(kTileSteps)))};
}

int64_t off_the_border(int64_t steps) { return (steps & (kTileSteps - 1)) == 0 ? steps + 1 : steps; }

std::optional<LatticePoint> inner_point(double east_m, double north_m) {
  const auto at = lattice_point(east_m, north_m);
  if (!at) return std::nullopt;
  return LatticePoint{off_the_border(at->east), off_the_border(at->north)};
}

RoadPoint metres(const LatticePoint& p) { return {p.east_m(), p.north_m()}; }

// The fractions of the way from `a` to `b` at which lines of tile borders are crossed, on one axis.
void add_crossings(int64_t a, int64_t b, std::vector<double>& crossings) {
  const int64_t low = std::min(a, b), high = std::max(a, b);
  const int64_t first = (low / kTileSteps - 1) * kTileSteps;
  for (int64_t line = first; line < high; line += kTileSteps)
    if (line > low) crossings.push_back(double(line - a) / double(b - a));
}

// Leaves out nodes without edges: where a corner of a tile is cut by less than a step.
void prune(RoadGraph& graph) {
  constexpr uint32_t kUnused = UINT32_MAX;
  std::vector<uint32_t> place(graph.nodes.size(), kUnused);
  for (const RoadEdge& edge : graph.edges) place[edge.from] = place[edge.to] = 0;
  std::vector<RoadNode> nodes;
  for (size_t i = 0; i < graph.nodes.size(); ++i) {
    if (place[i] == kUnused) continue;
    place[i] = uint32_t(nodes.size());
    nodes.push_back(graph.nodes[i]);
  }
  graph.nodes = std::move(nodes);
  for (RoadEdge& edge : graph.edges) edge.from = place[edge.from], edge.to = place[edge.to];
}

class Cutter {
 public:
  explicit Cutter(const RoadGraph& graph) : graph_(graph), degree_(graph.nodes.size()) {
    for (const RoadEdge& edge : graph.edges) {
      if (!line_of(edge)) continue;
      ++degree_[edge.from], ++degree_[edge.to];
    }
  }

  std::vector<RoadTile> cut() {
    for (const RoadEdge& edge : graph_.edges)
      if (const auto line = line_of(edge)) cut_edge(edge, *line);
    std::vector<RoadTile> out;
    for (auto& [key, part] : parts_) {
      prune(part.graph);
      if (!part.graph.edges.empty()) out.push_back({tile_of_key(kVectorLevel, key), std::move(part.graph)});
    }
    return out;
  }

 private:
  struct Part {
    RoadGraph graph;
    std::map<uint32_t, uint32_t> place;  // of the whole graph's nodes
  };

  // An edge on the lattice, without points that repeat the one before; nullopt where it has no length or place.
  std::optional<std::vector<LatticePoint>> line_of(const RoadEdge& edge) const {
    if (edge.from >= graph_.nodes.size() || edge.to >= graph_.nodes.size()) return std::nullopt;
    std::vector<LatticePoint> line;
    const auto add = [&](double east_m, double north_m) {
      const auto at = inner_point(east_m, north_m);
      if (at && (line.empty() || line.back() != *at)) line.push_back(*at);
      return at.has_value();
    };
    bool sound = add(graph_.nodes[edge.from].east_m, graph_.nodes[edge.from].north_m);
    for (const RoadPoint& vertex : edge.vertices) sound = sound && add(vertex.east_m, vertex.north_m);
    sound = sound && add(graph_.nodes[edge.to].east_m, graph_.nodes[edge.to].north_m);
    if (!sound || line.size() < 2) return std::nullopt;
    return line;
  }

  RoadNodeKind kind_of(uint32_t node) const {
    return degree_[node] == 1   ? RoadNodeKind::kEnd
           : degree_[node] == 2 ? RoadNodeKind::kJoint
                                : RoadNodeKind::kIntersection;
  }

  Part& part_of(const TileIndex& tile) { return parts_[hilbert_key(tile)]; }

  uint32_t add_node(Part& part, uint32_t node, const LatticePoint& at) {
    const auto [found, is_new] = part.place.try_emplace(node, uint32_t(part.graph.nodes.size()));
    if (is_new) part.graph.nodes.push_back({at.east_m(), at.north_m(), kind_of(node)});
    return found->second;
  }
  static uint32_t add_border(Part& part, const LatticePoint& at) {
    part.graph.nodes.push_back({at.east_m(), at.north_m(), RoadNodeKind::kBorder});
    return uint32_t(part.graph.nodes.size() - 1);
  }

  void cut_edge(const RoadEdge& edge, const std::vector<LatticePoint>& line) {
    TileIndex tile = vector_tile_of(line.front());
    RoadEdge piece{add_node(part_of(tile), edge.from, line.front()), 0, edge.width_m, edge.confidence, edge.source, {}};
    LatticePoint begin = line.front();
    const auto finish = [&](const LatticePoint& at, uint32_t to) {
      piece.to = to;
      if (!piece.vertices.empty() || begin != at) part_of(tile).graph.edges.push_back(piece);
      piece.vertices.clear();
    };
    for (size_t i = 1; i < line.size(); ++i) {
      for (const auto& [at, beyond] : crossings(line[i - 1], line[i])) {
        finish(at, add_border(part_of(tile), at));
        tile = beyond, begin = at;
        piece.from = add_border(part_of(tile), at);
      }
      if (i + 1 < line.size()) piece.vertices.push_back(metres(line[i]));
    }
    finish(line.back(), add_node(part_of(tile), edge.to, line.back()));
  }

  struct Crossing {
    LatticePoint at;
    TileIndex beyond;
  };

  // Neither end lies on a border.
  static std::vector<Crossing> crossings(const LatticePoint& a, const LatticePoint& b) {
    std::vector<double> ways;
    add_crossings(a.east, b.east, ways);
    add_crossings(a.north, b.north, ways);
    std::sort(ways.begin(), ways.end());
    std::vector<Crossing> out;
    for (size_t i = 0; i < ways.size(); ++i) {
      const double next = i + 1 < ways.size() ? ways[i + 1] : 1;
      const Position at = between(a, b, ways[i]);
      const TileIndex beyond = i + 1 < ways.size() ? tile_at(between(a, b, 0.5 * (ways[i] + next))) : vector_tile_of(b);
      out.push_back({{std::llround(at.x), std::llround(at.y)}, beyond});
    }
    return out;
  }

  const RoadGraph& graph_;
  std::vector<uint32_t> degree_;
  std::map<uint64_t, Part> parts_;
};

}  // namespace

std::vector<RoadTile> cut_roads(const RoadGraph& graph) { return Cutter(graph).cut(); }

}  // namespace landfix::tiles
