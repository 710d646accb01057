// The questions a pack answers, behind the C ABI: arguments are not null, everything else is checked here.
#pragma once

#include "runtime/pack/pack.h"
#include "tiles/ellipse.h"

namespace landfix::pack {

inline tiles::PixelRect rect_of(const lf_region& r) {
  return {r.level, r.first_column, r.first_row, r.width, r.height};
}

struct Box {
  double west_m, south_m, east_m, north_m;
};

lf_status ellipse_region(const lf_pack& pack, uint32_t layer, const tiles::Ellipse& ellipse, double gsd_m,
                         lf_region& out);
lf_status box_region(const lf_pack& pack, uint32_t layer, const Box& box, double gsd_m, lf_region& out);
lf_status read_pixels(const lf_pack& pack, const lf_region& region, uint8_t* out, size_t row_bytes, size_t out_bytes);
lf_status read_values(const lf_pack& pack, const lf_region& region, float* out, size_t row_bytes, size_t out_bytes);
lf_status read_bits(const lf_pack& pack, const lf_region& region, uint64_t* out, size_t row_words, size_t plane_words,
                    size_t out_words);
lf_status tile_view(const lf_pack& pack, uint32_t layer, const tiles::TileIndex& index, lf_tile& out);
lf_status next_tile(const lf_pack& pack, const lf_region& region, const tiles::Ellipse* ellipse, uint64_t& cursor,
                    lf_tile& out);
lf_status prepare(const lf_pack& pack, const lf_region& region, bool copy);
/// The epochs of a tile, in the manifest; empty: not stated.
lf_status tile_epochs(const lf_pack& pack, uint32_t layer, const tiles::TileIndex& index,
                      std::span<const uint16_t>& epochs);
lf_status region_epochs(const lf_pack& pack, const lf_region& region, lf_epoch_range& out);
lf_status find_landmarks(const lf_pack& pack, uint32_t layer, const lf_feature_query& query, std::span<lf_landmark> out,
                         size_t& count);
lf_status find_intersections(const lf_pack& pack, uint32_t layer, const lf_feature_query& query,
                             std::span<lf_intersection> out, size_t& count);
struct RoadBuffers {
  std::span<lf_road> roads;
  std::span<lf_point> vertices;
};
lf_status find_roads(const lf_pack& pack, uint32_t layer, const lf_feature_query& query, const RoadBuffers& out,
                     size_t& road_count, size_t& vertex_count);
lf_status height(const lf_pack& pack, double east_m, double north_m, double& height_m, lf_height_source& source);
lf_status undulation(const lf_pack& pack, double east_m, double north_m, double& undulation_m);
lf_status verify(const lf_pack& pack, bool deep, uint64_t& tiles);

}  // namespace landfix::pack
