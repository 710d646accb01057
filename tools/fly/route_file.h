// Routes from files of longitude and latitude.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "tiles/geodesy.h"

namespace landfix::fly {

/// Points (east, north) on a zone's grid of a route in degrees on WGS84. A name ending in .json or .geojson: the first
/// LineString of a GeoJSON file. Others: text, one "longitude,latitude" a line; further columns, lines beginning with #
/// and a header line are skipped. Throws Error: kIo where the file cannot be read, kBadInput naming what is wrong with
/// it.
std::vector<Eigen::Vector2d> read_route(const std::filesystem::path& file, const tiles::Zone& zone);

}  // namespace landfix::fly
