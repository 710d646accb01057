// The grid of geoid undulation that a pack carries, from PROJ's data.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "builder/ingest/bounds.h"
#include "tiles/geodesy.h"

namespace landfix::ingest {

/// Node (column, row) lies at easting west_m + column * spacing_m and northing south_m + row * spacing_m: rows run
/// north.
struct GeoidGrid {
  std::string model;  ///< "egm96"
  double west_m = 0, south_m = 0, spacing_m = 0;
  int columns = 0, rows = 0;
  std::vector<float> undulation_m;  ///< row by row: geoid above the WGS84 ellipsoid

  /// Bilinear between nodes; NaN outside.
  double at(double east_m, double north_m) const;
};

struct GeoidResult {
  std::optional<GeoidGrid> grid;
  std::string warning;  ///< why there is no grid; empty where there is one
};

/// EGM96 undulation over `bounds`, nodes at whole multiples of a spacing of 4 km, doubled until there are at most 256
/// each way. No grid and a warning where PROJ lacks egm96_15.gtx (Debian: proj-data). Throws Error (kBadInput) for
/// empty bounds.
GeoidResult make_geoid_grid(const tiles::Zone& zone, const GridBounds& bounds);

}  // namespace landfix::ingest
