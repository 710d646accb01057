#include "builder/export/epoch_sets.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>

#include "builder/error.h"

namespace landfix::exporter {
namespace {

void require(bool holds, const char* what) {
  if (!holds) throw Error(ExitCode::kInternal, fmt::format("the description of a pack: {}", what));
}

bool strictly_ascending(const std::vector<uint16_t>& indices) {
  return std::adjacent_find(indices.begin(), indices.end(), std::greater_equal<>()) == indices.end();
}

void check_epochs(const PackDescription& d) {
  require(d.epochs.size() <= schema::kMaxEpochs, "too many epochs");
  for (const PackEpoch& epoch : d.epochs)
    require(strictly_ascending(epoch.sources) && (epoch.sources.empty() || epoch.sources.back() < d.sources.size()),
            "an epoch whose sources are not ascending or not there");
  // Dates as 2009-08-18 sort as texts; the empty one comes last.
  require(std::is_sorted(d.epochs.begin(), d.epochs.end(),
                         [](const PackEpoch& a, const PackEpoch& b) { return a.date > b.date; }),
          "epochs that are not newest first");
  for (const catalog::EpochSet& set : d.epoch_sets)
    require(!set.empty() && strictly_ascending(set) && set.back() < d.epochs.size(),
            "a set of epochs that is empty, not ascending or not of this pack");
}

}  // namespace

EpochSets number_epoch_sets(const PackDescription& d) {
  check_epochs(d);
  EpochSets out;
  out.number.resize(d.epoch_sets.size() + 1);
  std::map<catalog::EpochSet, uint16_t> known;
  for (const PackLayer& layer : d.layers)
    for (const PackLevel& level : layer.levels)
      for (const schema::TileRecord& tile : level.tiles) {
        require(tile.epoch_set <= d.epoch_sets.size(), "a tile whose set of epochs is not there");
        if (tile.epoch_set == 0 || out.number[tile.epoch_set] != 0) continue;
        const catalog::EpochSet& set = d.epoch_sets[tile.epoch_set - 1u];
        const auto [found, is_new] = known.try_emplace(set, uint16_t(out.sets.size() + 1));
        if (is_new) out.sets.push_back(set);
        out.number[tile.epoch_set] = found->second;
      }
  return out;
}

}  // namespace landfix::exporter
