// The files of a flight that people and programs read: CSV of the track, picture of the tracks over the map.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

#include "runtime/nav/map_source.h"
#include "tiles/geodesy.h"
#include "tools/fly/flight.h"

namespace landfix::fly {

/// One line per image after a line of column names, which carry the units. The same records give the same
/// bytes. Throws Error (kIo).
void write_track_csv(const std::filesystem::path& file, const std::vector<Record>& records, const tiles::Zone& zone);

/// Truth, estimate with 3-sigma ellipses, and dead reckoning over the gray layer of the map, with legend and scale bar:
/// CV_8UC3 in OpenCV's order (blue, green, red), longer side about `size_px`.
cv::Mat draw_tracks(const std::vector<Record>& records, const nav::MapSource& map, int size_px = 1400);

}  // namespace landfix::fly
