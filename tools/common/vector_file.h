// Landmarks and roads as files for GIS programs: GeoPackage on the pack's grid, GeoJSON in degrees.
#pragma once

#include <string>

#include "landfix/landfix.hpp"

namespace landfix::tools {

/// Writes what a pack holds of `layer` ("landmarks", "roads" or "intersections") to `path`, atomically and with the
/// same bytes every time: a GeoPackage (.gpkg) whose style QGIS finds in it, or GeoJSON (.geojson) with the style
/// beside it
/// (.qml). Attributes carry their unit in the name (docs/command-line.md). Returns the number of features. Throws
/// Error: kUsage for another layer or extension, kNoData where the pack lacks the layer, kIo where writing fails.
size_t write_vector_file(const std::string& path, const Pack& pack, const std::string& layer,
                         const std::string& pack_path);

}  // namespace landfix::tools
