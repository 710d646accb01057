// The roads of one image: candidates block by block, then the pass over the whole.
#pragma once

#include "builder/roads/road_graph.h"
#include "runtime/features/grid_image.h"

namespace landfix::landmarks {

/// The roads of an image (CV_8UC1, or CV_8UC3 red, green, blue) of kRoadGsd_m per pixel. The same whatever the number
/// of threads (0: all cores).
tiles::RoadGraph extract_roads(const features::GridImage& image, const RoadModel& model, int threads = 0);

}  // namespace landfix::landmarks
