// What a build will do, decided before it starts: inputs opened, levels and jobs chosen, provenance and fingerprint
// made.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "builder/build.h"
#include "builder/export/pack_writer.h"
#include "builder/ingest/area.h"
#include "builder/ingest/elevation.h"
#include "builder/ingest/image_set.h"
#include "builder/landmarks/extraction.h"
#include "builder/landmarks/known.h"
#include "builder/layer_set.h"
#include "builder/layers/layer.h"
#include "builder/roads/road_model.h"
#include "runtime/nav/matcher.h"

namespace landfix {

struct LayerPlan {
  const layers::RasterLayer* layer = nullptr;
  tiles::Codec codec = tiles::Codec::kRaw;
  int base_level = 0;
  int top_level = 0;  ///< the first at which the whole area is no larger than a tile
  const layers::LayerInfo& info() const { return layer->info(); }
};

struct Plan {
  const LayerSet* set = nullptr;
  std::unique_ptr<ingest::ImageSet> images;
  std::unique_ptr<ingest::ElevationModel> elevation;  ///< absent: none was given
  std::unique_ptr<ingest::Area> area;
  int image_level = 0;
  std::vector<LayerPlan> layers;  ///< in the order of the pack, which vector layers follow
  landmarks::Known known;
  bool landmarks = false, roads = false;                       ///< whether the pack has these layers
  bool find_landmarks = false, find_roads = false;             ///< whether they are sought in the images
  std::shared_ptr<const landmarks::ObjectModel> object_model;  ///< where find_landmarks
  std::shared_ptr<const landmarks::RoadModel> road_model;      ///< where find_roads
  std::vector<tiles::Footprint> footprints;                    ///< that navigability is judged for
  std::vector<nav::Method> matchers;                           ///< that the pack serves, as `auto` asks them; ditto
  /// By level of the source window: indices of the layers that are computed from the inputs there.
  std::map<int, std::vector<size_t>> sources;
  /// By level above the imagery's: indices of the layers that are computed from the epochs halved down to it.
  std::map<int, std::vector<size_t>> halved;
  tiles::EncodeOptions encoding;
  exporter::PackDescription description;  ///< without levels
  std::string fingerprint;                ///< hash of all that decides about tile data
  std::vector<std::string> warnings;
  std::vector<ShiftSummary> shifts;
};

/// Opens and checks everything. Throws Error as `build`.
Plan make_plan(const BuildOptions& options);

/// The level that imagery is searched for landmarks and roads at: 1 m.
inline constexpr int kFeatureLevel = 0;

/// The blocks of 4x4 tiles at a window level that the area touches, as tiles two levels up in Hilbert order.
std::vector<tiles::TileIndex> blocks_of(const Plan& plan, int level);

/// The pixels of a block, grown by the halo, as far as the inputs reach. May be empty.
tiles::PixelRect window_of(const Plan& plan, const tiles::TileIndex& block, int level, int halo_px);

}  // namespace landfix
