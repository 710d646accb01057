#include "tools/common/map_features.h"

#include <algorithm>
#include <cmath>

#include "tiles/vector_tile.h"
#include "tools/common/open_pack.h"

namespace landfix::tools {
namespace {

uint32_t layer_of(const Pack& pack, const char* name, const std::string& path) {
  const auto layer = pack.find_layer(name);
  check(layer.status(), path + ": layer '" + name + "'");
  return *layer;
}

// A map may be larger than a region can be: it is asked for piece by piece. Pieces are whole tiles, so that no road
// lies in two of them.
std::vector<FeatureQuery> pieces_of(const FeatureQuery& query) {
  if (query.ellipse) return {query};
  constexpr double kPiece_m = 16 * 256 * 8;
  std::vector<FeatureQuery> out;
  for (double south = std::floor(query.south_m / kPiece_m) * kPiece_m; south < query.north_m; south += kPiece_m)
    for (double west = std::floor(query.west_m / kPiece_m) * kPiece_m; west < query.east_m; west += kPiece_m) {
      FeatureQuery piece = query;
      piece.west_m = std::max(query.west_m, west), piece.east_m = std::min(query.east_m, west + kPiece_m);
      piece.south_m = std::max(query.south_m, south), piece.north_m = std::min(query.north_m, south + kPiece_m);
      out.push_back(piece);
    }
  return out;
}

// Calls find(query), which returns a status, for every piece of a query that lies on the map.
template <typename Find>
void for_each_piece(const Pack& pack, uint32_t layer, const FeatureQuery& query, const std::string& what, Find find) {
  const double gsd_m = tiles::gsd_of(tiles::kVectorLevel);
  for (const FeatureQuery& piece : pieces_of(query)) {
    const auto region = piece.ellipse
                            ? pack.region(layer, *piece.ellipse, gsd_m)
                            : pack.box(layer, piece.west_m, piece.south_m, piece.east_m, piece.north_m, gsd_m);
    if (region.status() == LF_OUTSIDE_MAP) continue;
    check(region.status(), what);
    check(pack.prepare(*region), what);
    check(find(piece), what);
  }
}

// Asks for the number first, then for the features, and appends these.
template <typename Feature, typename Ask>
Status append(std::vector<Feature>& out, Ask ask) {
  size_t count = 0;
  const Status status = ask(std::span<Feature>(), count);
  if (status != LF_BUFFER_TOO_SMALL) return status;
  const size_t before = out.size();
  out.resize(before + count);
  return ask(std::span(out).subspan(before), count);
}

}  // namespace

const char* name_of(lf_road_node node) {
  switch (node) {
    case LF_ROAD_END:
      return "end";
    case LF_ROAD_INTERSECTION:
      return "intersection";
    case LF_ROAD_BORDER:
      return "border";
    case LF_ROAD_JOINT:
      return "joint";
  }
  return "unknown";
}

std::vector<Landmark> find_landmarks(const Pack& pack, const FeatureQuery& query, const std::string& path) {
  const uint32_t layer = layer_of(pack, "landmarks", path);
  std::vector<Landmark> out;
  for_each_piece(pack, layer, query, path + ": layer 'landmarks'", [&](const FeatureQuery& piece) {
    return append(
        out, [&](std::span<Landmark> room, size_t& count) { return pack.find_landmarks(layer, piece, room, count); });
  });
  return out;
}

std::vector<Intersection> find_intersections(const Pack& pack, const FeatureQuery& query, const std::string& path) {
  const uint32_t layer = layer_of(pack, "roads", path);
  std::vector<Intersection> out;
  for_each_piece(pack, layer, query, path + ": layer 'roads'", [&](const FeatureQuery& piece) {
    return append(out, [&](std::span<Intersection> room, size_t& count) {
      return pack.find_intersections(layer, piece, room, count);
    });
  });
  return out;
}

RoadSet find_roads(const Pack& pack, const FeatureQuery& query, const std::string& path) {
  const uint32_t layer = layer_of(pack, "roads", path);
  RoadSet out;
  for_each_piece(pack, layer, query, path + ": layer 'roads'", [&](const FeatureQuery& piece) {
    size_t roads = 0, vertices = 0;
    const Status status = pack.find_roads(layer, piece, {}, roads, {}, vertices);
    if (status != LF_BUFFER_TOO_SMALL) return status;
    const size_t first_road = out.roads.size(), first_vertex = out.vertices.size();
    out.roads.resize(first_road + roads), out.vertices.resize(first_vertex + vertices);
    const std::span<Road> added = std::span(out.roads).subspan(first_road);
    const Status found =
        pack.find_roads(layer, piece, added, roads, std::span(out.vertices).subspan(first_vertex), vertices);
    for (Road& road : added) road.first_vertex += first_vertex;
    return found;
  });
  return out;
}

FeatureQuery everywhere(const Pack& pack) {
  const lf_info info = pack.info();
  FeatureQuery query;
  // The edges of the map are in it.
  query.west_m = info.west_m, query.east_m = info.east_m + tiles::kLatticeStep_m;
  query.south_m = info.south_m, query.north_m = info.north_m + tiles::kLatticeStep_m;
  return query;
}

FeatureCounts count_features(const Pack& pack, const lf_layer_info& layer, const std::string& path) {
  FeatureCounts counts;
  if (layer.pixel_type == LF_LANDMARKS)
    for (const Landmark& m : find_landmarks(pack, everywhere(pack), path)) ++counts.of_class.at(m.landmark_class);
  if (layer.pixel_type == LF_ROADS) {
    for (const Road& road : find_roads(pack, everywhere(pack), path).roads)
      counts.roads_km += double(road.length_m) / 1000;
    counts.intersections = find_intersections(pack, everywhere(pack), path).size();
  }
  return counts;
}

}  // namespace landfix::tools
