#include "builder/export/vector_layers.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "builder/catalog/hash.h"
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
  catalog::FinishedTile out;
  out.layer = layer;
  out.level = tile.level;
  out.record.key = tiles::hilbert_key(tile);
  out.record.length = uint32_t(data.size());
  out.record.codec = uint8_t(tiles::Codec::kVector);
  out.record.hash = catalog::hash_of(data);
  out.data = std::move(data);
  if (epochs) out.epochs = epochs(tile);
  return out;
}

// The surest first; the rest of the key makes the choice the same whatever the order they came in.
void keep_the_surest(std::vector<tiles::Landmark>& landmarks) {
  if (landmarks.size() <= tiles::kMaxTileFeatures) return;
  const auto rank = [](const tiles::Landmark& m) {
    return std::tuple(-m.confidence, -m.distinctiveness_m, m.east_m, m.north_m, m.cls, m.length_m, m.width_m);
  };
  std::sort(landmarks.begin(), landmarks.end(),
            [&](const tiles::Landmark& a, const tiles::Landmark& b) { return rank(a) < rank(b); });
  landmarks.resize(tiles::kMaxTileFeatures);
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
                                                  const EpochsOfTile& epochs) {
  std::map<uint64_t, std::vector<tiles::Landmark>> by_key;
  for (const tiles::Landmark& landmark : landmarks)
    if (const auto tile = tiles::tile_of(landmark)) by_key[tiles::hilbert_key(*tile)].push_back(landmark);
  std::vector<catalog::FinishedTile> out;
  for (auto& [key, in_tile] : by_key) {
    const tiles::TileIndex tile = tiles::tile_of_key(tiles::kVectorLevel, key);
    keep_the_surest(in_tile);
    std::vector<uint8_t> data = tiles::encode_landmarks(tile, in_tile);
    if (data.empty()) throw Error(ExitCode::kInternal, "landmarks of a class that the format does not know");
    out.push_back(finished(kLandmarks, tile, std::move(data), epochs));
  }
  return out;
}

std::vector<catalog::FinishedTile> road_tiles(const tiles::RoadGraph& graph, const EpochsOfTile& epochs) {
  std::vector<catalog::FinishedTile> out;
  for (const tiles::RoadTile& part : tiles::cut_roads(graph)) {
    std::vector<uint8_t> data = tiles::encode_roads(part.tile, part.graph);
    if (data.empty())
      throw Error(
          ExitCode::kBadInput,
          fmt::format("roads: {} stretches between {} nodes within 2048 m of easting {:.0f}, northing {:.0f}; a "
                      "tile holds {} of each: give simpler roads",
                      part.graph.edges.size(), part.graph.nodes.size(), tiles::corner_of(part.tile).east_m(),
                      tiles::corner_of(part.tile).north_m(), tiles::kMaxTileFeatures));
    out.push_back(finished(kRoads, part.tile, std::move(data), epochs));
  }
  return out;
}

}  // namespace landfix::exporter
