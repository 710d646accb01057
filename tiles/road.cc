// The coding of a tile of roads, and what follows from a graph.
#include "tiles/road.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <new>
#include <numbers>
#include <numeric>
#include <tuple>

#include "tiles/symbol_models.h"

namespace landfix::tiles {
namespace {

// Steps from the tile's south-western corner, 0 to kTileSteps.
struct Local {
  int32_t x = 0, y = 0;
  auto operator<=>(const Local&) const = default;
};

constexpr uint32_t kPositionEnd = 1u << 28;  // of Morton codes of coordinates up to kTileSteps

bool is_inside(const Local& p) { return p.x >= 0 && p.x <= kTileSteps && p.y >= 0 && p.y <= kTileSteps; }

struct CodedNode {
  uint32_t position = 0;  // Morton code
  uint32_t degree = 0;    // of its edges; not coded
  auto operator<=>(const CodedNode&) const = default;
  Local local() const { return {int32_t(morton_x(position)), int32_t(morton_x(position >> 1))}; }
};

RoadNodeKind kind_of(const CodedNode& node) {
  const auto [x, y] = node.local();
  if (x == 0 || x == kTileSteps || y == 0 || y == kTileSteps) return RoadNodeKind::kBorder;
  if (node.degree >= 3) return RoadNodeKind::kIntersection;
  return node.degree == 2 ? RoadNodeKind::kJoint : RoadNodeKind::kEnd;
}

struct CodedEdge {
  uint32_t from = 0, to = 0, width = 0, confidence = 0, source = 0;
  std::vector<Local> vertices;
  auto operator<=>(const CodedEdge&) const = default;
};

struct CodedGraph {
  std::vector<CodedNode> nodes;
  std::vector<CodedEdge> edges;
};

struct RoadModels {
  NumberModel nodes, edges, gap, from, to, vertices, source;
  SymbolModel<6, 1> width;
  SymbolModel<4> confidence;
  SignedNumberModel bend_x, bend_y;
};

template <typename Coder>
bool code_nodes(Coder& coder, RoadModels& models, std::vector<CodedNode>& nodes) {
  const uint32_t count = models.nodes.code(coder, uint32_t(nodes.size()));
  if (count == 0 || count > kMaxTileFeatures) return false;
  nodes.resize(count);
  CodedNode before;
  for (CodedNode& node : nodes) {
    const uint32_t gap = models.gap.code(coder, node.position - before.position);
    if (gap >= kPositionEnd - before.position) return false;
    node.position = before.position + gap;
    if (!is_inside(node.local()) || coder.failed()) return false;
    before = node;
  }
  return true;
}

// Vertices as the difference to where the line would go if it went straight on, one more step like the last.
template <typename Coder>
bool code_vertices(Coder& coder, RoadModels& models, Local at, std::vector<Local>& vertices) {
  Local step;
  for (Local& vertex : vertices) {
    const Local expected{at.x + step.x, at.y + step.y};
    const int64_t x = int64_t(expected.x) + models.bend_x.code(coder, vertex.x - expected.x),
                  y = int64_t(expected.y) + models.bend_y.code(coder, vertex.y - expected.y);
    if (x < 0 || x > kTileSteps || y < 0 || y > kTileSteps || coder.failed()) return false;
    vertex = {int32_t(x), int32_t(y)};
    step = {vertex.x - at.x, vertex.y - at.y};
    at = vertex;
  }
  return true;
}

template <typename Coder>
bool code_edges(Coder& coder, RoadModels& models, CodedGraph& graph) {
  const uint32_t count = models.edges.code(coder, uint32_t(graph.edges.size()));
  if (count == 0 || count > kMaxTileFeatures) return false;
  graph.edges.resize(count);
  const auto nodes = uint32_t(graph.nodes.size());
  uint32_t room = kMaxTileVertices;
  const CodedEdge* before = nullptr;
  for (CodedEdge& edge : graph.edges) {
    const uint32_t first = before ? before->from : 0;
    const uint32_t forward = models.from.code(coder, edge.from - first);
    if (forward >= nodes - first) return false;
    edge.from = first + forward;
    const uint32_t reach = models.to.code(coder, edge.to - edge.from);
    if (reach >= nodes - edge.from) return false;
    edge.to = edge.from + reach;
    edge.width = models.width.code(coder, edge.width);
    edge.confidence = models.confidence.code(coder, edge.confidence);
    edge.source = models.source.code(coder, edge.source);
    const uint32_t vertices = models.vertices.code(coder, uint32_t(edge.vertices.size()));
    if (vertices > room || edge.source > UINT16_MAX || coder.failed()) return false;
    room -= vertices;
    edge.vertices.resize(vertices);
    if (!code_vertices(coder, models, graph.nodes[edge.from].local(), edge.vertices)) return false;
    if (before && edge < *before) return false;
    before = &edge;
    ++graph.nodes[edge.from].degree, ++graph.nodes[edge.to].degree;
  }
  return std::none_of(graph.nodes.begin(), graph.nodes.end(), [](const CodedNode& n) { return n.degree == 0; });
}

// Both ways; false where what was decoded is not what an encoder codes.
template <typename Coder>
bool code_tile(Coder& coder, CodedGraph& graph) {
  RoadModels models;
  return code_nodes(coder, models, graph.nodes) && code_edges(coder, models, graph);
}

std::optional<Local> local_of(const LatticePoint& corner, double east_m, double north_m) {
  const auto at = lattice_point(east_m, north_m);
  if (!at) return std::nullopt;
  const int64_t x = at->east - corner.east, y = at->north - corner.north;
  if (x < 0 || x > kTileSteps || y < 0 || y > kTileSteps) return std::nullopt;
  return Local{int32_t(x), int32_t(y)};
}

// Whether a line has one direction of being written more: from its lesser node, and a ring the lesser way round.
void direct(CodedEdge& edge) {
  const auto reversed = [&] { return std::vector<Local>(edge.vertices.rbegin(), edge.vertices.rend()); };
  if (edge.from > edge.to || (edge.from == edge.to && reversed() < edge.vertices)) {
    edge.vertices = reversed();
    std::swap(edge.from, edge.to);
  }
}

// The nodes in Morton order; `place` tells where each went.
bool code_positions(const LatticePoint& corner, std::span<const RoadNode> nodes, CodedGraph& graph,
                    std::vector<uint32_t>& place) {
  std::vector<std::pair<CodedNode, uint32_t>> sorted;
  for (const RoadNode& node : nodes) {
    const auto at = local_of(corner, node.east_m, node.north_m);
    if (!at) return false;
    sorted.push_back({{morton_code(uint32_t(at->x), uint32_t(at->y)), 0}, uint32_t(sorted.size())});
  }
  std::sort(sorted.begin(), sorted.end());
  place.resize(nodes.size());
  for (const auto& [node, index] : sorted) {
    place[index] = uint32_t(graph.nodes.size());
    graph.nodes.push_back(node);
  }
  return true;
}

bool code_lines(const LatticePoint& corner, std::span<const RoadEdge> edges, std::span<const uint32_t> place,
                std::vector<CodedEdge>& out) {
  size_t vertices = 0;
  for (const RoadEdge& edge : edges) {
    if (edge.from >= place.size() || edge.to >= place.size()) return false;
    CodedEdge coded{
        place[edge.from], place[edge.to], size_level(edge.width_m), share_level(edge.confidence), edge.source, {}};
    for (const RoadPoint& vertex : edge.vertices) {
      const auto at = local_of(corner, vertex.east_m, vertex.north_m);
      if (!at || ++vertices > kMaxTileVertices) return false;
      coded.vertices.push_back(*at);
    }
    direct(coded);
    out.push_back(std::move(coded));
  }
  std::sort(out.begin(), out.end());
  return true;
}

RoadPoint point_of(const LatticePoint& corner, const Local& at) {
  const LatticePoint p{corner.east + at.x, corner.north + at.y};
  return {p.east_m(), p.north_m()};
}

// The positions of an edge from one of its nodes on.
class Walk {
 public:
  Walk(const RoadGraph& graph, const RoadEdge& edge, bool from_the_end)
      : graph_(graph), edge_(edge), reversed_(from_the_end) {}
  size_t size() const { return edge_.vertices.size() + 2; }
  RoadPoint operator[](size_t i) const {
    const size_t k = reversed_ ? size() - 1 - i : i;
    if (k > 0 && k + 1 < size()) return edge_.vertices[k - 1];
    const RoadNode& node = graph_.nodes[k == 0 ? edge_.from : edge_.to];
    return {node.east_m, node.north_m};
  }

 private:
  const RoadGraph& graph_;
  const RoadEdge& edge_;
  bool reversed_;
};

double distance(const RoadPoint& a, const RoadPoint& b) {
  return std::hypot(a.east_m - b.east_m, a.north_m - b.north_m);
}

// Where an edge is `reach_m` after its beginning; its end where it is shorter.
RoadPoint point_along(const Walk& walk, double reach_m) {
  for (size_t i = 1; i < walk.size(); ++i) {
    const RoadPoint a = walk[i - 1], b = walk[i];
    const double length = distance(a, b);
    if (length >= reach_m && length > 0) {
      const double t = reach_m / length;
      return {a.east_m + t * (b.east_m - a.east_m), a.north_m + t * (b.north_m - a.north_m)};
    }
    reach_m -= length;
  }
  return walk[walk.size() - 1];
}

RoadArm arm_of(const RoadGraph& graph, uint32_t edge, bool from_the_end) {
  const Walk walk(graph, graph.edges[edge], from_the_end);
  const RoadPoint from = walk[0], to = point_along(walk, kBearingReach_m);
  const double bearing = std::atan2(to.east_m - from.east_m, to.north_m - from.north_m);
  return {edge, bearing < 0 ? bearing + 2 * std::numbers::pi : bearing};
}

double third_greatest_confidence(const RoadGraph& graph, std::span<const RoadArm> arms) {
  std::vector<double> confidences;
  for (const RoadArm& arm : arms) confidences.push_back(graph.edges[arm.edge].confidence);
  std::nth_element(confidences.begin(), confidences.begin() + 2, confidences.end(), std::greater<>());
  return confidences[2];
}

}  // namespace

std::vector<uint8_t> encode_roads(const TileIndex& tile, const RoadGraph& graph) {
  CodedGraph coded;
  std::vector<uint32_t> place;
  const LatticePoint corner = corner_of(tile);
  if (!code_positions(corner, graph.nodes, coded, place)) return {};
  if (!code_lines(corner, graph.edges, place, coded.edges)) return {};
  ArithmeticEncoder encoder;
  return code_tile(encoder, coded) ? encoder.finish() : std::vector<uint8_t>{};
}

bool decode_roads(const TileIndex& tile, std::span<const uint8_t> data, RoadGraph& graph) noexcept try {
  graph = {};
  CodedGraph coded;
  ArithmeticDecoder decoder(data);
  if (!code_tile(decoder, coded) || !decoder.at_end()) return false;
  const LatticePoint corner = corner_of(tile);
  for (const CodedNode& node : coded.nodes) {
    const RoadPoint at = point_of(corner, node.local());
    graph.nodes.push_back({at.east_m, at.north_m, kind_of(node)});
  }
  for (const CodedEdge& edge : coded.edges) {
    graph.edges.push_back(
        {edge.from, edge.to, size_of_level(edge.width), share_of_level(edge.confidence), uint16_t(edge.source), {}});
    for (const Local& vertex : edge.vertices) graph.edges.back().vertices.push_back(point_of(corner, vertex));
  }
  return true;
} catch (const std::bad_alloc&) {
  return false;
}

std::vector<std::vector<RoadArm>> arms_of(const RoadGraph& graph) {
  std::vector<std::vector<RoadArm>> arms(graph.nodes.size());
  for (uint32_t i = 0; i < graph.edges.size(); ++i) {
    arms[graph.edges[i].from].push_back(arm_of(graph, i, false));
    arms[graph.edges[i].to].push_back(arm_of(graph, i, true));
  }
  for (auto& of_node : arms)
    std::stable_sort(of_node.begin(), of_node.end(),
                     [](const RoadArm& a, const RoadArm& b) { return a.bearing_rad < b.bearing_rad; });
  return arms;
}

bool intersections_of(const RoadGraph& graph, std::vector<RoadIntersection>& intersections) noexcept try {
  intersections.clear();
  std::vector<std::vector<RoadArm>> arms = arms_of(graph);
  for (size_t i = 0; i < graph.nodes.size(); ++i) {
    if (graph.nodes[i].kind != RoadNodeKind::kIntersection || arms[i].size() < 3) continue;
    const double confidence = third_greatest_confidence(graph, arms[i]);
    intersections.push_back({graph.nodes[i].east_m, graph.nodes[i].north_m, confidence, std::move(arms[i])});
  }
  return true;
} catch (const std::bad_alloc&) {
  return false;
}

std::vector<RoadPoint> line_of(const RoadGraph& graph, const RoadEdge& edge) {
  const Walk walk(graph, edge, false);
  std::vector<RoadPoint> line;
  for (size_t i = 0; i < walk.size(); ++i) line.push_back(walk[i]);
  return line;
}

double length_of(const RoadGraph& graph, const RoadEdge& edge) {
  const Walk walk(graph, edge, false);
  double length = 0;
  for (size_t i = 1; i < walk.size(); ++i) length += distance(walk[i - 1], walk[i]);
  return length;
}

}  // namespace landfix::tiles
