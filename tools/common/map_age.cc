#include "tools/common/map_age.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "builder/ingest/provenance.h"
#include "runtime/nav/matcher.h"
#include "runtime/nav/pack_map.h"
#include "tiles/grid.h"
#include "tiles/navigability.h"

namespace landfix::tools {
namespace {

// The epochs of the tile of a layer's finest level that a place lies in; none where the pack does not say.
std::vector<uint16_t> epochs_at(const Pack& pack, uint32_t layer, double east_m, double north_m) {
  const Result<lf_level_info> finest = pack.level(layer, 0);
  if (!finest) return {};
  const auto column = int64_t(std::floor(east_m / finest->gsd_m)), row = int64_t(std::floor(-north_m / finest->gsd_m));
  const tiles::TileIndex tile = tiles::tile_of_pixel(finest->level, column, row);
  std::vector<uint16_t> epochs(pack.info().epoch_count);
  const auto count = pack.tile_epochs(layer, finest->level, tile.x, tile.y, epochs);
  epochs.resize(count ? *count : 0);
  return epochs;
}

}  // namespace

std::optional<int> days_of(const std::string& date) {
  return ingest::is_date(date) ? nav::day_of(date.c_str()) : std::nullopt;
}

std::optional<double> map_age_years(const Pack& pack, double east_m, double north_m, int day) {
  std::optional<double> age;
  for (const nav::Method method : nav::kMethods) {
    const Result<uint32_t> layer = pack.find_layer(nav::name_of(method));  // layers bear the matchers' names
    if (!layer) continue;
    for (const uint16_t epoch : epochs_at(pack, *layer, east_m, north_m)) {
      const std::optional<int> taken = days_of(pack.epoch(epoch)->date);
      if (!taken) continue;
      const double years = std::abs(day - *taken) / tiles::kDaysPerYear;
      age = std::min(age.value_or(years), years);
    }
  }
  return age;
}

}  // namespace landfix::tools
