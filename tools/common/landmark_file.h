// Landmarks that were found in an image as a file for GIS programs.
#pragma once

#include <string>
#include <vector>

#include "builder/landmarks/extraction.h"
#include "tiles/geodesy.h"

namespace landfix::tools {

/// Writes a GeoPackage with the layers `landmarks` (points) and `outlines` (polygons: of buildings as they were seen,
/// of others the rectangle around them), atomically. Throws Error: kUsage for another extension, kIo where writing
/// fails.
void write_landmark_file(const std::string& path, const std::vector<landmarks::Extracted>& landmarks,
                         const tiles::Zone& zone);

/// The corners of the rectangle around a landmark, easting and northing; along grid north where it has no direction.
std::vector<cv::Point2d> rectangle_of(const tiles::Landmark& landmark);

}  // namespace landfix::tools
