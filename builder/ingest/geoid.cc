#include "builder/ingest/geoid.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "builder/error.h"
#include "builder/ingest/vertical.h"

namespace landfix::ingest {
namespace {

constexpr double kSpacingM = 4000;
constexpr int kMostNodes = 256;

/// Nodes at whole multiples of the spacing, so that packs made apart have the same nodes; one cell at least each way.
GeoidGrid empty_grid(const GridBounds& b, double spacing) {
  const double west = std::floor(b.west_m / spacing), south = std::floor(b.south_m / spacing);
  const double east = std::ceil(b.east_m / spacing), north = std::ceil(b.north_m / spacing);
  return {kEgm96,
          west * spacing,
          south * spacing,
          spacing,
          int(std::max(1.0, east - west)) + 1,
          int(std::max(1.0, north - south)) + 1,
          {}};
}

}  // namespace

double GeoidGrid::at(double east_m, double north_m) const {
  const double x = (east_m - west_m) / spacing_m, y = (north_m - south_m) / spacing_m;
  if (!(x >= 0 && y >= 0 && x <= columns - 1 && y <= rows - 1)) return std::numeric_limits<double>::quiet_NaN();
  const int column = std::min(int(x), columns - 2), row = std::min(int(y), rows - 2);
  const double fx = x - column, fy = y - row;
  const float* south_west = undulation_m.data() + size_t(row) * size_t(columns) + size_t(column);
  const float* north_west = south_west + columns;
  return (south_west[0] * (1 - fx) + south_west[1] * fx) * (1 - fy) +
         (north_west[0] * (1 - fx) + north_west[1] * fx) * fy;
}

GeoidResult make_geoid_grid(const tiles::Zone& zone, const GridBounds& bounds) {
  if (bounds.empty()) throw Error(ExitCode::kBadInput, "geoid: the area is empty");
  double spacing = kSpacingM;
  GeoidGrid grid = empty_grid(bounds, spacing);
  while (grid.columns > kMostNodes || grid.rows > kMostNodes) grid = empty_grid(bounds, spacing *= 2);
  try {
    const VerticalTransformation from_geoid(kEgm96, zone, bounds, "geoid undulation");
    for (int row = 0; row < grid.rows; ++row) {
      std::vector<double> x, y(size_t(grid.columns), grid.south_m + row * spacing);
      for (int column = 0; column < grid.columns; ++column) x.push_back(grid.west_m + column * spacing);
      from_geoid.shift_and_scale(grid.columns, x.data(), y.data());
      for (const double shift : x) {
        if (!std::isfinite(shift)) return {std::nullopt, "geoid undulation: PROJ's EGM96 grid does not cover the area"};
        grid.undulation_m.push_back(float(shift));
      }
    }
  } catch (const Error& e) {
    return {std::nullopt, e.what()};
  }
  return {std::move(grid), ""};
}

}  // namespace landfix::ingest
