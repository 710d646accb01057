// Outlines on the grid as OGR's shapes.
#pragma once

#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

namespace landfix::ingest {

/// One polygon per outline (points in order, not closed) as WKT.
std::string multipolygon_wkt(const std::vector<std::vector<cv::Point2d>>& outlines);

}  // namespace landfix::ingest
