// Navigability of a build, block by block: what the imagery says about finding oneself over every node, with the
// matchers that fly. navigability_layers.h makes layers of it.
#pragma once

#include <string>
#include <vector>

#include "builder/catalog/catalog.h"
#include "builder/ingest/image_set.h"
#include "builder/plan.h"
#include "runtime/nav/matcher.h"
#include "tiles/codec.h"
#include "tiles/navigability.h"

namespace landfix {

/// The level at which the view of a footprint is matched: 32 to 64 pixels a side, where the imagery is fine enough.
int matched_level(const tiles::Footprint& footprint, int image_level);

/// Pixels of `level` around a block that the footprints matched there want, and what describes the ground there; 0
/// where there is neither.
int navigability_halo_px(const Plan& plan, int level);

/// Whether images of a level are looked at for navigability.
bool judges(const Plan& plan, int level);

/// What the images say of every node in a block of `images.rect.level`, for the journal: one tile per footprint that is
/// matched at this level, and at ground_level() what covers the ground. Places are judged by the first of plan.matchers
/// at every node, by the others at some (nodes_per_view). The same for a block whatever the blocks
/// around it. `images` reaches navigability_halo_px() beyond the block, where there is data.
std::vector<catalog::FinishedTile> judge_places(const Plan& plan, const ingest::Stack& images,
                                                const tiles::TileIndex& block);

/// What there is of a footprint in the journal: nodes of a block as pixels of the layer, rows from the north.
struct JudgedBlocks {
  explicit JudgedBlocks(const tiles::Footprint& footprint, int image_level);

  std::string name;    ///< of its tiles
  int level = 0;       ///< of its blocks
  int side_nodes = 0;  ///< of one
};

/// The pixels of a layer: tiles::NavigabilityPixel.
inline constexpr tiles::TileFormat kNavigabilityFormat{tiles::PixelType::kU8, uint8_t(tiles::kNavigabilityChannels), 0};

/// Every so manieth node of each row and column is judged by all matchers, the others by the first alone: these lie at
/// most a view apart, or two nodes.
int nodes_per_view(const tiles::Footprint& footprint);

/// Whose chance a matcher's is.
tiles::Finder finder_of(nav::Method method);

}  // namespace landfix
