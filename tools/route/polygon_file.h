// Areas that must not be flown over, from a GeoJSON file.
#pragma once

#include <string>
#include <vector>

#include "tools/route/fences.h"

namespace landfix::route {

/// The outer rings of all Polygon and MultiPolygon geometries (of a geometry, feature or collection) on the grid; holes
/// count as area. Throws Error: kIo, kBadInput where it is no GeoJSON or holds no polygon, kNoData where one is out of
/// the zone's reach.
std::vector<Polygon> read_polygons(const std::string& path, const tiles::Zone& zone);

/// The same of a text; `name` stands for the file in messages.
std::vector<Polygon> parse_polygons(const std::string& text, const std::string& name, const tiles::Zone& zone);

}  // namespace landfix::route
