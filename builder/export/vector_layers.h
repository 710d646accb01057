// Landmarks and roads as layers of a pack: what extraction hands over becomes tiles for the catalog and the writer.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "builder/catalog/catalog.h"
#include "builder/export/pack_writer.h"
#include "tiles/landmark.h"
#include "tiles/road.h"

namespace landfix::exporter {

inline constexpr const char *kLandmarks = "landmarks", *kRoads = "roads";

/// The layers, with their one level tiles::kVectorLevel, which has no tiles yet. A layer without any tile is one where
/// nothing was found; a pack that was not searched has no such layer.
PackLayer landmarks_layer();
PackLayer roads_layer();

/// The epochs that went into a tile; where absent they are not stated.
using EpochsOfTile = std::function<catalog::EpochSet(const tiles::TileIndex&)>;

/// The tiles of all landmarks, by ascending key: finished but for the offset. The same tiles whatever the order of the
/// landmarks. Those off the grid are left out. Of a tile with more than tiles::kMaxTileFeatures the surest are kept, of
/// these the most distinctive, of these the longest, of these some from all over the tile; `warnings`, where given,
/// says how many are not.
std::vector<catalog::FinishedTile> landmark_tiles(std::span<const tiles::Landmark> landmarks,
                                                  const EpochsOfTile& epochs = {},
                                                  std::vector<std::string>* warnings = nullptr);

/// The tiles of a whole graph, cut by tiles::cut_roads(). Where a tile would have more nodes, edges or vertices than it
/// can hold the widest roads are kept, of these the longest stretches; `warnings`, where given, says how many are not.
std::vector<catalog::FinishedTile> road_tiles(const tiles::RoadGraph& graph, const EpochsOfTile& epochs = {},
                                              std::vector<std::string>* warnings = nullptr);

}  // namespace landfix::exporter
