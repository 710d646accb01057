// Places on centrelines of roads in one block of an image, each with its probability: what does not need the whole map.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <opencv2/core.hpp>
#include <type_traits>
#include <utility>
#include <vector>

#include "builder/roads/road_model.h"

namespace landfix::landmarks {

/// Roads are sought at 1 m per pixel and, the wide ones, at 2 m.
inline constexpr double kRoadGsd_m = 1;
/// What lies farther away than this many pixels has no part in a candidate.
inline constexpr int kRoadHaloPx = 88;
/// A good side of blocks: small enough for memory (some 90 MB while one is searched), large against its halo.
inline constexpr int kRoadBlockPx = 1024;
/// Below this probability a candidate is no place.
inline constexpr float kLeastRoadProbability = 0.05f;
/// Below this one of the first judge the second is not asked.
inline constexpr float kLeastOfFirst = 0.1f;

/// Twenty bytes without padding, fit to be stored as they are.
struct RoadPlace {
  int32_t x = 0, y = 0;  ///< pixel
  float theta_rad = 0;   ///< direction in [0, pi), from x (east) towards y (south)
  float probability = 0;
  float width_px = 0;
  bool operator==(const RoadPlace&) const = default;
};
static_assert(sizeof(RoadPlace) == 20 && std::is_trivially_copyable_v<RoadPlace>);

/// The candidates of `core`, in the order of rows. `image`: CV_8UC1 or CV_8UC3 (red, green, blue); `valid`: CV_8UC1 or
/// empty (all valid). The image should reach kRoadHaloPx beyond `core` wherever there is more of it; where it ends it
/// is mirrored. Then blocks, whose images start at even pixels of the whole, give what the whole image gives, to the
/// bit. Candidates at 2 m replace those at 1 m beside them where these are less sure.
std::vector<RoadPlace> find_road_places(const cv::Mat& image, const cv::Mat& valid, const cv::Rect& core,
                                        const RoadModel& model);

/// The pixels of a rectangle inside of the map, CV_8UC1 or CV_8UC3 (red, green, blue).
using PixelSource = std::function<cv::Mat(const cv::Rect&)>;

/// Probability that a road of direction `theta_rad` runs through the pixel or one of its neighbours across. Reads the
/// map in tiles and keeps the last of them; not for two threads at once.
class RoadEvidence {
 public:
  RoadEvidence(PixelSource source, const cv::Size& map, const RoadModel& model);
  float operator()(double x, double y, double theta_rad);

 private:
  struct Tile {
    cv::Mat bands;
    uint64_t used = 0;  // when, in steps of the clock
  };
  const Tile& tile_at(const cv::Point& pixel);

  PixelSource source_;
  cv::Size map_;
  const RoadModel& model_;
  std::map<std::pair<int, int>, Tile> tiles_;
  uint64_t clock_ = 0;
  bool gray_ = false;
};

}  // namespace landfix::landmarks
