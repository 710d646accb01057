// Tiles of vector layers in memory: decoded once by lf_prepare, then read without allocation.
#pragma once

#include "runtime/pack/pack.h"

namespace landfix::pack {

/// The head of a decoded tile, from std::malloc; the arrays that it counts follow.
struct LandmarkTile {
  uint64_t landmark_count;
  std::span<const lf_landmark> landmarks() const;
};

struct RoadTile {
  uint64_t road_count, vertex_count, intersection_count;
  std::span<const lf_road> roads() const;  ///< `first_vertex` counts in the tile
  std::span<const lf_point> vertices() const;
  std::span<const lf_intersection> intersections() const;
};

/// Decodes a checked tile of a vector layer into a LandmarkTile or RoadTile, to be freed by std::free.
lf_status decode_features(const lf_pack& pack, const Layer& layer, const tiles::TileIndex& tile,
                          const schema::TileRecord& record, uint8_t*& out);

}  // namespace landfix::pack
