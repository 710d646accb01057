// The navigability layers of a pack as routes ask for them.
#pragma once

#include <memory>
#include <string>

#include "landfix/landfix.hpp"
#include "tools/route/navigability_map.h"

namespace landfix::route {

/// All footprints that a pack was judged for, read into memory. A view between two of them gets the mean of their
/// chances, by the logarithm of its side; one smaller than all gets its share of the smallest's ground of that one's
/// chance, one larger the largest's. A search is answered by the next wider one that was judged; beyond the widest only
/// by the share of a Gaussian belief that this one reaches. `day`: of the flight, days since 1970-01-01; chances are
/// those of maps of the usual age without it. Throws Error: kNoData where the pack has no such layer, kBadPack where it
/// is damaged; `path` is the pack's, for messages.
std::unique_ptr<NavigabilityMap> open_navigability(const Pack& pack, const std::string& path,
                                                   std::optional<int> day = std::nullopt);

}  // namespace landfix::route
