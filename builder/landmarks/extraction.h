// Landmarks seen in an image: buildings, fields, trees, water and paved areas, each at its own centre.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "builder/landmarks/object_model.h"
#include "builder/landmarks/object_regions.h"
#include "runtime/features/grid_image.h"
#include "tiles/landmark.h"

namespace landfix::landmarks {

inline constexpr double kLandmarkGsd_m = 1;   ///< of the images that landmarks are found in
inline constexpr int kLandmarkHalo_px = 128;  ///< around the core that find_landmarks has to see

/// Landmarks that are less likely than this to be there are left out.
inline constexpr double kLeastConfidence = 0.3;

struct Extracted {
  tiles::Landmark landmark;          ///< its distinctiveness and epochs are not measured
  std::vector<cv::Point2d> outline;  ///< grid east and north, of buildings and what find_broad finds; else empty
};

/// The landmarks of an image (CV_8UC1, or CV_8UC3 red, green, blue; kLandmarkGsd_m per pixel) with their middle in
/// `core`, in the order of their class, then from north to south. What lies at the image's rim or beside pixels without
/// data is not seen whole and left out. The same for the same core however much more than kLandmarkHalo_px around it
/// the image shows, and together the same however a map is cut into cores. Throws Error (kInternal) for another type.
/// `view`, where given, gets the broad_view (broad_regions.h) of the part of `core` within the image, from the first
/// whole square of its corner on; it stays empty where there are no data. `covers`, where given, becomes the likeliest
/// cover of each pixel of `core`, kNoCover where there are no data.
std::vector<Extracted> find_landmarks(const features::GridImage& image, const cv::Rect& core, const ObjectModel& model,
                                      cv::Mat* view = nullptr, cv::Mat* covers = nullptr);

/// The landmarks of a whole image, found block by block, broad ones (broad_regions.h) first; their distinctiveness is
/// measured. The same whatever the number of threads (0: all cores).
std::vector<Extracted> extract_landmarks(const features::GridImage& image, const ObjectModel& model, int threads = 0);

/// Regions that were chosen as landmarks, with the score of ObjectModel::Part::whole; of training, too.
struct Chosen {
  Region region;
  RegionNumbers numbers{};
  float score = 0;
};

/// The best regions of a class with their middle in `core` that do not cover one another.
std::vector<Chosen> choose_regions(const ObjectScene& scene, tiles::LandmarkClass cls, const cv::Rect& core,
                                   const features::BoostedTrees& whole);

}  // namespace landfix::landmarks
