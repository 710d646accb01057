// The sets of epochs of a pack in the order in which its tiles need them, whatever order they were found in.
#pragma once

#include <cstdint>
#include <vector>

#include "builder/export/pack_writer.h"

namespace landfix::exporter {

struct EpochSets {
  std::vector<catalog::EpochSet> sets;  ///< as the pack holds them
  std::vector<uint16_t> number;         ///< by `epoch_set` of the description's records: that of the pack's
};

/// Throws Error (kInternal) where a record, a set or an epoch points beyond its list, a set is empty or not ascending,
/// or the epochs are not newest first.
EpochSets number_epoch_sets(const PackDescription& description);

}  // namespace landfix::exporter
