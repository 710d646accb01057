#include "builder/roads/road_extraction.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

namespace landfix::landmarks {
namespace {

std::vector<cv::Rect> blocks_of(const cv::Size& size) {
  std::vector<cv::Rect> blocks;
  for (int y = 0; y < size.height; y += kRoadBlockPx)
    for (int x = 0; x < size.width; x += kRoadBlockPx)
      blocks.push_back({x, y, std::min(kRoadBlockPx, size.width - x), std::min(kRoadBlockPx, size.height - y)});
  return blocks;
}

}  // namespace

tiles::RoadGraph extract_roads(const features::GridImage& image, const RoadModel& model, int threads) {
  const std::vector<cv::Rect> blocks = blocks_of(image.pixels.size());
  std::vector<std::vector<RoadPlace>> found(blocks.size());
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(size_t(0), blocks.size(),
                      [&](size_t i) { found[i] = find_road_places(image.pixels, image.valid, blocks[i], model); });
  });
  std::vector<RoadPlace> places;
  for (const std::vector<RoadPlace>& some : found) places.insert(places.end(), some.begin(), some.end());
  RoadEvidence evidence([&](const cv::Rect& r) { return image.pixels(r); }, image.pixels.size(), model);
  return link_roads(places, image.pixels.size(), std::ref(evidence), {image.west_m, image.north_m, image.gsd_m});
}

}  // namespace landfix::landmarks
