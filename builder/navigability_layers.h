// The navigability layers of a build: made in one pass of what its blocks have said, the landmarks, the heights and the
// cover of the ground.
#pragma once

#include <string>
#include <vector>

#include "builder/catalog/catalog.h"
#include "builder/export/pack_writer.h"
#include "builder/plan.h"
#include "tiles/navigability.h"

namespace landfix {

/// A footprint's layer, with its one level tiles::kNavigabilityLevel, which has no tiles yet.
exporter::PackLayer navigability_layer(const tiles::Footprint& footprint);

/// The tiles of the layers, from what all blocks have said and the finished tiles of the layer `landmarks`, if the pack
/// has one.
std::vector<catalog::FinishedTile> link_navigability(const Plan& plan, const catalog::Catalog& catalog);

/// "navigability/160/160: 1840 places; chance of a fix 0.82 at the median, below 0.31 at a tenth of them" and the like,
/// one line per layer.
std::vector<std::string> text_of_navigability(const Plan& plan, const catalog::Catalog& catalog);

}  // namespace landfix
