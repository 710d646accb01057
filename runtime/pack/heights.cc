// Heights of the ground and of the geoid at a point.
#include <cmath>
#include <cstring>

#include "runtime/pack/queries.h"

namespace landfix::pack {
namespace {

using schema::TileRecord;
using tiles::kTilePixels;

// Pixels of one level; remembers the tile of the last one, as the four around a point mostly share theirs.
class HeightPixels {
 public:
  HeightPixels(const lf_pack& pack, const Level& level) : pack_(pack), level_(level) {}

  // LF_OUTSIDE_MAP without data.
  lf_status get(int64_t column, int64_t row, double& value) {
    const tiles::TileIndex tile = tiles::tile_of_pixel(level_.level, column, row);
    if (record_ == nullptr || tile != tile_) {
      record_ = nullptr;
      const TileRecord* record;
      if (const lf_status s = pack_.pixels_of(*pack_.height_layer, level_, tile, pixels_, record); s != LF_OK) return s;
      tile_ = tile, record_ = record;
    }
    const int64_t index = (row - tiles::first_row(tile)) * kTilePixels + (column - tiles::first_column(tile));
    int16_t raw;
    std::memcpy(&raw, pixels_ + 2 * index, 2);
    if (raw == pack_.height_layer->format.nodata) return LF_OUTSIDE_MAP;
    value = double(record_->value_offset) + double(record_->value_step) * raw;
    return LF_OK;
  }

 private:
  const lf_pack& pack_;
  const Level& level_;
  tiles::TileIndex tile_;
  const uint8_t* pixels_ = nullptr;
  const TileRecord* record_ = nullptr;
};

// Bilinear between the four pixel centres around a point. Pixels without data drop out as long as the others carry half
// the weight.
lf_status height_at_level(const lf_pack& pack, const Level& level, double east_m, double north_m, double& height_m) {
  const double gsd = tiles::gsd_of(level.level);
  const double x = east_m / gsd - 0.5, y = -north_m / gsd - 0.5;
  const auto column = int64_t(std::floor(x)), row = int64_t(std::floor(y));
  const double fx = x - double(column), fy = y - double(row);
  HeightPixels pixels(pack, level);
  double sum = 0, weights = 0;
  for (int i = 0; i < 4; ++i) {
    const int dx = i & 1, dy = i >> 1;
    const double weight = (dx ? fx : 1 - fx) * (dy ? fy : 1 - fy);
    if (weight == 0) continue;
    double value;
    const lf_status s = pixels.get(column + dx, row + dy, value);
    if (s == LF_OUTSIDE_MAP) continue;
    if (s != LF_OK) return s;
    sum += weight * value;
    weights += weight;
  }
  if (weights < 0.5) return LF_OUTSIDE_MAP;
  height_m = sum / weights;
  return LF_OK;
}

}  // namespace

lf_status height(const lf_pack& pack, double east_m, double north_m, double& height_m, lf_height_source& source) {
  if (!(std::abs(east_m) < tiles::kDomainHalf) || !(std::abs(north_m) < tiles::kDomainHalf)) return LF_INVALID_ARGUMENT;
  for (uint32_t i = 0; pack.height_layer != nullptr && i < pack.height_layer->level_count; ++i) {
    const lf_status s = height_at_level(pack, pack.height_layer->levels[i], east_m, north_m, height_m);
    if (s == LF_OUTSIDE_MAP) continue;
    source = LF_HEIGHT_LAYER;
    return s;
  }
  const schema::Bounds& b = *pack.manifest->bounds();
  if (east_m < b.west_m() || east_m > b.east_m() || north_m < b.south_m() || north_m > b.north_m())
    return LF_OUTSIDE_MAP;
  height_m = pack.manifest->plane_height_m();
  source = LF_HEIGHT_PLANE;
  return LF_OK;
}

lf_status undulation(const lf_pack& pack, double east_m, double north_m, double& undulation_m) {
  if (!std::isfinite(east_m) || !std::isfinite(north_m)) return LF_INVALID_ARGUMENT;
  const schema::Geoid* g = pack.manifest->geoid();
  if (g == nullptr) return LF_OUTSIDE_MAP;
  const double x = (east_m - g->west_m()) / g->spacing_m(), y = (north_m - g->south_m()) / g->spacing_m();
  if (!(x >= 0 && x <= g->columns() - 1 && y >= 0 && y <= g->rows() - 1)) return LF_OUTSIDE_MAP;
  const auto column = std::min(uint32_t(x), g->columns() - 2), row = std::min(uint32_t(y), g->rows() - 2);
  const double fx = x - column, fy = y - row;
  const auto node = [&](uint32_t c, uint32_t r) { return double(g->undulation_m()->Get(r * g->columns() + c)); };
  undulation_m = (1 - fy) * ((1 - fx) * node(column, row) + fx * node(column + 1, row)) +
                 fy * ((1 - fx) * node(column, row + 1) + fx * node(column + 1, row + 1));
  return LF_OK;
}

}  // namespace landfix::pack
