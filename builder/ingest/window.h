// One raster as one image on the grid, at any GSD: for the camera's scene and for pictures, not for packs.
#pragma once

#include <optional>

#include "builder/ingest/source.h"
#include "runtime/features/grid_image.h"
#include "tiles/geodesy.h"

namespace landfix::ingest {

/// An image as CV_8UC3 (red, green, blue) where it has these bands, else CV_8UC1 (its first), with mask. `bounds`:
/// nullopt reads all of it; grown to whole multiples of `gsd_m`. `gsd_m` 0: the source's own. Throws like ImageSet, and
/// Error (kBadInput) above 2^29 pixels.
features::GridImage load_image(const SourceOptions& file, const tiles::Zone& zone,
                               std::optional<GridBounds> bounds = std::nullopt, double gsd_m = 0);

/// A DEM as CV_32FC1 metres above the WGS84 ellipsoid, with mask; otherwise as load_image. Throws like ElevationModel.
features::GridImage load_elevation(const SourceOptions& file, const tiles::Zone& zone,
                                   std::optional<GridBounds> bounds = std::nullopt, double gsd_m = 0);

/// What an image covers of the grid.
GridBounds bounds_of(const features::GridImage& image);

/// The standard zone of a raster's centre. Throws like ImageSet.
tiles::Zone standard_zone_of(const std::string& path);

}  // namespace landfix::ingest
