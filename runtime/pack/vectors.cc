// Landmarks and roads: from a tile's bytes to records in memory, and from a filter's uncertainty to these records.
#include "runtime/pack/vectors.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <new>

#include "runtime/pack/queries.h"
#include "tiles/landmark.h"
#include "tiles/road.h"

namespace landfix::pack {
namespace {

// Arrays behind a head lie one after the other; all of them are of records aligned to 8 bytes.
template <typename T>
const T* array_at(const void* head, size_t offset) {
  static_assert(alignof(T) <= 8 && sizeof(T) % 8 == 0 && std::is_trivially_copyable_v<T>);
  return reinterpret_cast<const T*>(static_cast<const uint8_t*>(head) + offset);
}

// Writes a decoded tile front to back.
class Block {
 public:
  explicit Block(size_t bytes) : begin_(static_cast<uint8_t*>(std::malloc(bytes))), at_(begin_) {}
  template <typename T>
  void put(const T& record) {
    std::memcpy(at_, &record, sizeof record);
    at_ += sizeof record;
  }
  uint8_t* begin() const { return begin_; }

 private:
  uint8_t *begin_, *at_;
};

// Whether the manifest has the source; -1 stands for the images.
bool find_source(const lf_pack& pack, uint16_t number, int32_t& source) {
  source = -1;
  if (number == 0) return true;
  if (number > pack.vector_source_count) return false;
  source = int32_t(pack.vector_sources[number - 1]);
  return true;
}

lf_status decode_landmark_tile(const lf_pack& pack, const tiles::TileIndex& tile, std::span<const uint8_t> data,
                               uint8_t*& out) {
  std::vector<tiles::Landmark> landmarks;
  if (!tiles::decode_landmarks(tile, data, landmarks)) return LF_DAMAGED;
  std::erase_if(landmarks, [](const tiles::Landmark& m) { return uint8_t(m.cls) >= tiles::kLandmarkClasses; });
  const Block block(sizeof(LandmarkTile) + landmarks.size() * sizeof(lf_landmark));
  if (block.begin() == nullptr) return LF_OUT_OF_MEMORY;
  Block writer = block;
  writer.put(LandmarkTile{landmarks.size()});
  for (const tiles::Landmark& m : landmarks) {
    int32_t source;
    if (!find_source(pack, m.source, source)) {
      std::free(block.begin());
      return LF_DAMAGED;
    }
    writer.put(lf_landmark{m.east_m, m.north_m, float(m.length_m), float(m.width_m), float(m.orientation_rad),
                           float(m.confidence), float(m.distinctiveness_m), source, m.epochs_seen, uint8_t(m.cls), 0});
  }
  out = block.begin();
  return LF_OK;
}

lf_intersection intersection_of(const tiles::RoadGraph& graph, const tiles::RoadIntersection& from) {
  lf_intersection out{};
  out.east_m = from.east_m, out.north_m = from.north_m;
  out.degree = uint32_t(from.arms.size());
  out.confidence = float(from.confidence);
  for (size_t i = 0; i < std::min<size_t>(from.arms.size(), LF_MAX_ARMS); ++i) {
    out.bearing_rad[i] = float(from.arms[i].bearing_rad);
    out.width_m[i] = float(graph.edges[from.arms[i].edge].width_m);
  }
  return out;
}

void put_edges(const tiles::RoadGraph& graph, std::span<const int32_t> sources, Block& writer) {
  size_t first = 0;
  for (size_t i = 0; i < graph.edges.size(); ++i) {
    const tiles::RoadEdge& e = graph.edges[i];
    const auto vertices = uint32_t(e.vertices.size() + 2);
    writer.put(lf_road{first,
                       vertices,
                       float(e.width_m),
                       float(tiles::length_of(graph, e)),
                       float(e.confidence),
                       sources[i],
                       uint8_t(graph.nodes[e.from].kind),
                       uint8_t(graph.nodes[e.to].kind),
                       {}});
    first += vertices;
  }
  for (const tiles::RoadEdge& e : graph.edges) {
    writer.put(lf_point{graph.nodes[e.from].east_m, graph.nodes[e.from].north_m});
    for (const tiles::RoadPoint& v : e.vertices) writer.put(lf_point{v.east_m, v.north_m});
    writer.put(lf_point{graph.nodes[e.to].east_m, graph.nodes[e.to].north_m});
  }
}

lf_status decode_road_tile(const lf_pack& pack, const tiles::TileIndex& tile, std::span<const uint8_t> data,
                           uint8_t*& out) {
  tiles::RoadGraph graph;
  std::vector<tiles::RoadIntersection> intersections;
  if (!tiles::decode_roads(tile, data, graph)) return LF_DAMAGED;
  if (!tiles::intersections_of(graph, intersections)) return LF_OUT_OF_MEMORY;
  const std::unique_ptr<int32_t[]> sources(new (std::nothrow) int32_t[graph.edges.size()]);
  if (!sources) return LF_OUT_OF_MEMORY;
  size_t vertices = 0;
  for (size_t i = 0; i < graph.edges.size(); ++i) {
    if (!find_source(pack, graph.edges[i].source, sources[i])) return LF_DAMAGED;
    vertices += graph.edges[i].vertices.size() + 2;
  }
  const Block block(sizeof(RoadTile) + graph.edges.size() * sizeof(lf_road) + vertices * sizeof(lf_point) +
                    intersections.size() * sizeof(lf_intersection));
  if (block.begin() == nullptr) return LF_OUT_OF_MEMORY;
  Block writer = block;
  writer.put(RoadTile{graph.edges.size(), vertices, intersections.size()});
  put_edges(graph, {sources.get(), graph.edges.size()}, writer);
  for (const tiles::RoadIntersection& i : intersections) writer.put(intersection_of(graph, i));
  out = block.begin();
  return LF_OK;
}

// A query after its checks, and the tiles that it looks into.
struct Search {
  const Layer* layer;
  const Level* level;
  tiles::TileRange range;
  Box box;
  const tiles::Ellipse* ellipse;
  float min_confidence;
  uint32_t class_mask;

  bool holds(double east_m, double north_m) const {
    if (ellipse != nullptr) return tiles::contains(*ellipse, east_m, north_m);
    return east_m >= box.west_m && east_m < box.east_m && north_m >= box.south_m && north_m < box.north_m;
  }
};

lf_status begin_search(const lf_pack& pack, uint32_t layer, lf_pixel_type type, const lf_feature_query& q,
                       tiles::Ellipse& ellipse, Search& out) {
  if (q.struct_size < sizeof q || layer >= pack.layer_count || std::isnan(q.min_confidence)) return LF_INVALID_ARGUMENT;
  if (pack.layers[layer].type != type) return LF_WRONG_TYPE;
  out = {&pack.layers[layer],
         nullptr,
         {},
         {q.west_m, q.south_m, q.east_m, q.north_m},
         nullptr,
         q.min_confidence,
         q.class_mask == 0 ? ~0u : q.class_mask};
  const double gsd_m = tiles::gsd_of(tiles::kVectorLevel);
  lf_region region;
  if (q.ellipse != nullptr) {
    const lf_ellipse& e = *q.ellipse;
    ellipse = {e.east_m, e.north_m, {e.cov_ee, e.cov_en, e.cov_nn}, e.k};
    out.ellipse = &ellipse;
    if (const lf_status s = ellipse_region(pack, layer, ellipse, gsd_m, region); s != LF_OK) return s;
  } else if (const lf_status s = box_region(pack, layer, out.box, gsd_m, region); s != LF_OK) {
    return s;
  }
  out.level = out.layer->find_level(region.level);
  out.range = tiles::tiles_of(rect_of(region));
  return LF_OK;
}

// Calls visit(const Tile&) for the prepared tiles of a search, from north to south and from west to east in a row.
template <typename Tile, typename Visit>
lf_status for_each_tile(const lf_pack& pack, const Search& search, Visit visit) {
  for (int32_t y = search.range.y_max; y >= search.range.y_min; --y)
    for (int32_t x = search.range.x_min; x <= search.range.x_max; ++x) {
      const uint8_t* features;
      const schema::TileRecord* record;
      const lf_status s = pack.pixels_of(*search.layer, *search.level, {search.level->level, x, y}, features, record);
      if (s == LF_OUTSIDE_MAP) continue;
      if (s != LF_OK) return s;
      visit(*reinterpret_cast<const Tile*>(features));
    }
  return LF_OK;
}

// The part of a line inside of a box, after Liang and Barsky: whether any is left.
bool touches_box(const Box& box, const lf_point& a, const lf_point& b) {
  double begin = 0, end = 1;
  const auto clip = [&](double from, double way, double low, double high) {
    if (way == 0) return from >= low && from <= high;
    const double t0 = (low - from) / way, t1 = (high - from) / way;
    begin = std::max(begin, std::min(t0, t1)), end = std::min(end, std::max(t0, t1));
    return begin <= end;
  };
  return clip(a.east_m, b.east_m - a.east_m, box.west_m, box.east_m) &&
         clip(a.north_m, b.north_m - a.north_m, box.south_m, box.north_m);
}

bool touches(const Search& search, std::span<const lf_point> line) {
  for (size_t i = 1; i < line.size(); ++i) {
    const lf_point &a = line[i - 1], &b = line[i];
    if (search.ellipse != nullptr ? tiles::touches_line(*search.ellipse, a.east_m, a.north_m, b.east_m, b.north_m)
                                  : touches_box(search.box, a, b))
      return true;
  }
  return false;
}

// Features at one place each, in the order of the tiles: all are counted, the first are written to `out`.
template <typename Tile, typename Feature, typename Wanted>
lf_status find_points(const lf_pack& pack, uint32_t layer, lf_pixel_type type, const lf_feature_query& query,
                      std::span<const Feature> (Tile::*features)() const, Wanted wanted, std::span<Feature> out,
                      size_t& count) {
  Search search;
  tiles::Ellipse ellipse;
  if (const lf_status s = begin_search(pack, layer, type, query, ellipse, search); s != LF_OK) return s;
  size_t found = 0;
  const lf_status s = for_each_tile<Tile>(pack, search, [&](const Tile& tile) {
    for (const Feature& f : (tile.*features)()) {
      const bool sure = f.confidence >= search.min_confidence;
      if (!sure || !wanted(search, f) || !search.holds(f.east_m, f.north_m)) continue;
      if (found < out.size()) out[found] = f;
      ++found;
    }
  });
  if (s != LF_OK) return s;
  count = found;
  return found > out.size() ? LF_BUFFER_TOO_SMALL : LF_OK;
}

}  // namespace

std::span<const lf_landmark> LandmarkTile::landmarks() const {
  return {array_at<lf_landmark>(this, sizeof *this), landmark_count};
}

std::span<const lf_road> RoadTile::roads() const { return {array_at<lf_road>(this, sizeof *this), road_count}; }

std::span<const lf_point> RoadTile::vertices() const {
  return {array_at<lf_point>(roads().data() + road_count, 0), vertex_count};
}

std::span<const lf_intersection> RoadTile::intersections() const {
  return {array_at<lf_intersection>(vertices().data() + vertex_count, 0), intersection_count};
}

lf_status decode_features(const lf_pack& pack, const Layer& layer, const tiles::TileIndex& tile,
                          const schema::TileRecord& record, uint8_t*& out) {
  const std::span<const uint8_t> data(pack.mapping.data() + record.offset, record.length);
  return layer.type == LF_LANDMARKS ? decode_landmark_tile(pack, tile, data, out)
                                    : decode_road_tile(pack, tile, data, out);
}

lf_status find_landmarks(const lf_pack& pack, uint32_t layer, const lf_feature_query& query, std::span<lf_landmark> out,
                         size_t& count) {
  return find_points<LandmarkTile, lf_landmark>(
      pack, layer, LF_LANDMARKS, query, &LandmarkTile::landmarks,
      [](const Search& search, const lf_landmark& m) { return search.class_mask >> m.landmark_class & 1; }, out, count);
}

lf_status find_intersections(const lf_pack& pack, uint32_t layer, const lf_feature_query& query,
                             std::span<lf_intersection> out, size_t& count) {
  return find_points<RoadTile, lf_intersection>(
      pack, layer, LF_ROADS, query, &RoadTile::intersections,
      [](const Search&, const lf_intersection&) { return true; }, out, count);
}

lf_status find_roads(const lf_pack& pack, uint32_t layer, const lf_feature_query& query, const RoadBuffers& out,
                     size_t& road_count, size_t& vertex_count) {
  Search search;
  tiles::Ellipse ellipse;
  if (const lf_status s = begin_search(pack, layer, LF_ROADS, query, ellipse, search); s != LF_OK) return s;
  size_t roads = 0, vertices = 0;
  bool fits = true;
  const lf_status s = for_each_tile<RoadTile>(pack, search, [&](const RoadTile& tile) {
    for (const lf_road& road : tile.roads()) {
      const auto line = tile.vertices().subspan(road.first_vertex, road.vertex_count);
      if (road.confidence < search.min_confidence || !touches(search, line)) continue;
      fits = fits && roads < out.roads.size() && line.size() <= out.vertices.size() - vertices;
      if (fits) {
        out.roads[roads] = road;
        out.roads[roads].first_vertex = vertices;
        std::copy(line.begin(), line.end(), out.vertices.begin() + ptrdiff_t(vertices));
      }
      ++roads, vertices += line.size();
    }
  });
  if (s != LF_OK) return s;
  road_count = roads, vertex_count = vertices;
  return fits ? LF_OK : LF_BUFFER_TOO_SMALL;
}

}  // namespace landfix::pack
