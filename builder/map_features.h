// Landmarks and roads of a build: what every block of imagery shows of them, and the one pass over the whole map that
// joins it with what is known.
#pragma once

#include <vector>

#include "builder/catalog/catalog.h"
#include "builder/ingest/image_set.h"
#include "builder/plan.h"

namespace landfix {

/// Pixels of kFeatureLevel that `find_features` wants around a block.
int feature_halo_px();

/// What the images show in a block of kFeatureLevel, for the journal: landmarks of every epoch, places on roads of what
/// is newest, and that image itself, which the last pass looks at again where roads have gaps. The same for a block
/// whatever the blocks around it. `images` reaches feature_halo_px() beyond the block, where there is data.
std::vector<catalog::FinishedTile> find_features(const Plan& plan, const ingest::Stack& images,
                                                 const tiles::TileIndex& block);

/// The tiles of the vector layers, from what is known and what all blocks have found. Known landmarks come first: those
/// that were found count where nothing of their class is known. Warns of tiles that had too much to hold.
std::vector<catalog::FinishedTile> link_features(const Plan& plan, const catalog::Catalog& catalog,
                                                 std::vector<std::string>& warnings);

/// What finished tiles hold, in words: "landmarks: 123 buildings, 4 fields", "roads: 4.5 km, 12 intersections".
std::vector<std::string> text_of_features(const Plan& plan, const catalog::Catalog& catalog);

}  // namespace landfix
