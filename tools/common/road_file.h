// A graph of roads as a file for GIS programs, before it is part of a map.
#pragma once

#include <string>

#include "tiles/geodesy.h"
#include "tiles/road.h"

namespace landfix::tools {

/// Writes a GeoPackage with the layers roads (width_m, length_m, confidence) and intersections (degree) on the zone's
/// grid, atomically. Throws Error: kUsage for another extension than .gpkg, kIo where writing fails.
void write_road_file(const std::string& path, const tiles::RoadGraph& graph, const tiles::Zone& zone);

}  // namespace landfix::tools
