// Regions of an image that may be one landmark each, and the numbers by which that is judged.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "builder/landmarks/object_model.h"
#include "runtime/features/object_planes.h"

namespace landfix::landmarks {

/// An image of 1 m per pixel with all that is known of its pixels.
struct ObjectScene {
  cv::Mat valid;                ///< CV_8UC1, 0 or 255
  std::vector<cv::Mat> planes;  ///< of features::object_planes
  features::FourfoldGradient gradient;
  std::array<cv::Mat, kCovers> covers;  ///< CV_8UC1, probability times 255, mean of 3 x 3 pixels
};

/// `image`: CV_8UC1 or CV_8UC3 (red, green, blue); `valid` as in GridImage. `covers`: trees for as many planes.
ObjectScene look_at(const cv::Mat& image, const cv::Mat& valid, const features::BoostedTrees& covers);

inline constexpr size_t kRegionNumbers = 53;
using RegionNumbers = std::array<float, kRegionNumbers>;

/// No region of a class reaches further than this from the middle of its box, pixels.
int reach_of(tiles::LandmarkClass cls);
/// What a region's numbers depend on lies within this many pixels of it.
inline constexpr int kRegionSight_px = features::kObjectReach_px + 8;

struct Region {
  cv::Point middle() const { return {box.x + box.width / 2, box.y + box.height / 2}; }

  tiles::LandmarkClass cls = tiles::LandmarkClass::kBuilding;
  cv::Rect box;
  cv::Mat mask;  ///< of the box, CV_8UC1, 1 where the region is
  int area_px = 0;
  int level = 0, opening = 0;  ///< how it was cut out
};

/// Connected parts of what is likely covered by the stuff of a class, cut at several probabilities and with narrow
/// bridges opened at several widths: whatever the object is, one of them should be it. They lie wholly inside of the
/// image and of its valid part, with the middle of their box in `core`.
std::vector<Region> regions_of(const ObjectScene& scene, tiles::LandmarkClass cls, const cv::Rect& core);

/// The smallest rectangle around a region, in pixels of its box ((0.5, 0.5): middle of the first).
cv::RotatedRect rectangle_of(const Region& region);

RegionNumbers numbers_of(const ObjectScene& scene, const Region& region);

/// Pixels that two regions share.
int common_px(const Region& a, const Region& b);

}  // namespace landfix::landmarks
