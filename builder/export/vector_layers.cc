#include "builder/export/vector_layers.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "builder/error.h"

namespace landfix::exporter {
namespace {

PackLayer vector_layer(const char* name, const char* description, VectorContent content) {
  PackLayer layer;
  layer.name = name;
  layer.description = description;
  layer.content = content;
  layer.levels = {{tiles::kVectorLevel, {}}};
  return layer;
}

catalog::FinishedTile finished(const char* layer, const tiles::TileIndex& tile, std::vector<uint8_t> data,
                               const EpochsOfTile& epochs) {
  catalog::FinishedTile out = catalog::finished_tile(layer, tile, std::move(data));
  out.record.codec = uint8_t(tiles::Codec::kVector);
  if (epochs) out.epochs = epochs(tile);
  return out;
}

void warn(std::vector<std::string>* warnings, const char* layer, const tiles::TileIndex& tile, size_t kept, size_t all,
          const char* of_what, const char* which) {
  if (!warnings || kept == all) return;
  const tiles::LatticePoint corner = tiles::corner_of(tile);
  warnings->push_back(
      fmt::format("{}: {} of {} {} are kept, {}, in the tile of 2048 m from easting {:.0f}, northing {:.0f}: it holds "
                  "{} of each. Fewer in the input (--vectors) leave the choice to you",
                  layer, kept, all, of_what, which, corner.east_m(), corner.north_m(), tiles::kMaxTileFeatures));
}

// A number that leaps from each place to the next: the lowest of all come from everywhere.
uint32_t scattered(const tiles::Landmark& m) {
  const auto at = tiles::lattice_point(m.east_m, m.north_m);
  return at ? tiles::morton_code(uint32_t(at->east), uint32_t(at->north)) * 2654435761u : 0;
}

// The last members of the key make the choice the same whatever the order they came in.
void keep_the_best(std::vector<tiles::Landmark>& landmarks) {
  if (landmarks.size() <= tiles::kMaxTileFeatures) return;
  const auto rank = [](const tiles::Landmark& m) {
    return std::tuple(-m.confidence, -m.distinctiveness_m, -m.length_m, scattered(m), m.east_m, m.north_m, m.cls,
                      m.width_m);
  };
  std::sort(landmarks.begin(), landmarks.end(),
            [&](const tiles::Landmark& a, const tiles::Landmark& b) { return rank(a) < rank(b); });
  landmarks.resize(tiles::kMaxTileFeatures);
}

bool fits(const tiles::RoadGraph& graph) {
  size_t vertices = 0;
  for (const tiles::RoadEdge& edge : graph.edges) vertices += edge.vertices.size();
  return graph.nodes.size() <= tiles::kMaxTileFeatures && graph.edges.size() <= tiles::kMaxTileFeatures &&
         vertices <= tiles::kMaxTileVertices;
}

// The widest roads, of these the longest, as many as a tile holds.
tiles::RoadGraph best_of(const tiles::RoadGraph& graph) {
  std::vector<std::tuple<double, double, size_t>> order;
  for (size_t i = 0; i < graph.edges.size(); ++i)
    order.emplace_back(-graph.edges[i].width_m, -tiles::length_of(graph, graph.edges[i]), i);
  std::sort(order.begin(), order.end());
  tiles::RoadGraph best;
  std::map<uint32_t, uint32_t> place;
  size_t vertices = 0;
  const auto node = [&](uint32_t old) {
    const auto [found, is_new] = place.try_emplace(old, uint32_t(best.nodes.size()));
    if (is_new) best.nodes.push_back(graph.nodes[old]);
    return found->second;
  };
  for (const auto& [width, length, i] : order) {
    tiles::RoadEdge edge = graph.edges[i];
    const size_t nodes =
        best.nodes.size() + !place.contains(edge.from) + (edge.from != edge.to && !place.contains(edge.to));
    if (nodes > tiles::kMaxTileFeatures || best.edges.size() == tiles::kMaxTileFeatures ||
        vertices + edge.vertices.size() > tiles::kMaxTileVertices)
      continue;
    vertices += edge.vertices.size();
    edge.from = node(edge.from), edge.to = node(edge.to);
    best.edges.push_back(std::move(edge));
  }
  return best;
}

}  // namespace

PackLayer landmarks_layer() {
  return vector_layer(kLandmarks, "buildings, fields, trees, water and paved areas, each at its centre",
                      VectorContent::kLandmarks);
}

PackLayer roads_layer() {
  return vector_layer(kRoads, "centrelines of roads and their intersections", VectorContent::kRoads);
}

std::vector<catalog::FinishedTile> landmark_tiles(std::span<const tiles::Landmark> landmarks,
                                                  const EpochsOfTile& epochs, std::vector<std::string>* warnings) {
  std::map<uint64_t, std::vector<tiles::Landmark>> by_key;
  for (const tiles::Landmark& landmark : landmarks)
    if (const auto tile = tiles::tile_of(landmark)) by_key[tiles::hilbert_key(*tile)].push_back(landmark);
  std::vector<catalog::FinishedTile> out;
  for (auto& [key, in_tile] : by_key) {
    const tiles::TileIndex tile = tiles::tile_of_key(tiles::kVectorLevel, key);
    const size_t all = in_tile.size();
    keep_the_best(in_tile);
    warn(warnings, kLandmarks, tile, in_tile.size(), all, "landmarks", "the surest and most distinctive");
    std::vector<uint8_t> data = tiles::encode_landmarks(tile, in_tile);
    if (data.empty()) throw Error(ExitCode::kInternal, "landmarks of a class that the format does not know");
    out.push_back(finished(kLandmarks, tile, std::move(data), epochs));
  }
  return out;
}

std::vector<catalog::FinishedTile> road_tiles(const tiles::RoadGraph& graph, const EpochsOfTile& epochs,
                                              std::vector<std::string>* warnings) {
  std::vector<catalog::FinishedTile> out;
  for (tiles::RoadTile& part : tiles::cut_roads(graph)) {
    const size_t all = part.graph.edges.size();
    if (!fits(part.graph)) part.graph = best_of(part.graph);
    warn(warnings, kRoads, part.tile, part.graph.edges.size(), all, "stretches", "the widest and longest");
    std::vector<uint8_t> data = tiles::encode_roads(part.tile, part.graph);
    if (data.empty()) throw Error(ExitCode::kInternal, "a graph of roads that the format cannot hold");
    out.push_back(finished(kRoads, part.tile, std::move(data), epochs));
  }
  return out;
}

}  // namespace landfix::exporter
