// Navigability of a build: what every block of imagery says about finding oneself over it, and the pass that makes
// layers of it.
#pragma once

#include <string>
#include <vector>

#include "builder/catalog/catalog.h"
#include "builder/export/pack_writer.h"
#include "builder/ingest/image_set.h"
#include "builder/plan.h"

namespace landfix {

/// The level at which the view of a footprint is matched: 32 to 64 pixels a side, where the imagery is fine enough.
int matched_level(const tiles::Footprint& footprint, int image_level);

/// Pixels of `level` around a block that the footprints matched there want; 0 where there is none.
int navigability_halo_px(const Plan& plan, int level);

/// What the images say of every node in a block of `images.rect.level`, for the journal: one tile per footprint that is
/// matched at this level. The same for a block whatever the blocks around it. `images` reaches navigability_halo_px()
/// beyond the block, where there is data.
std::vector<catalog::FinishedTile> judge_places(const Plan& plan, const ingest::Stack& images,
                                                const tiles::TileIndex& block);

/// A footprint's layer, with its one level tiles::kNavigabilityLevel, which has no tiles yet.
exporter::PackLayer navigability_layer(const tiles::Footprint& footprint);

/// The tiles of the layers, from what all blocks have said and the finished tiles of the layer `landmarks`, if the pack
/// has one.
std::vector<catalog::FinishedTile> link_navigability(const Plan& plan, const catalog::Catalog& catalog);

/// "navigability/160/160: 1840 places, a fix in 10 at 0.31, half at 0.82" and the like, one line per layer.
std::vector<std::string> text_of_navigability(const Plan& plan, const catalog::Catalog& catalog);

}  // namespace landfix
