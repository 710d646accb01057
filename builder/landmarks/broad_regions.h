// Landmarks too large for find_landmarks: fields and lakes, found at 4 m per pixel in what it sees of the ground.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "builder/landmarks/extraction.h"
#include "builder/landmarks/object_regions.h"

namespace landfix::landmarks {

inline constexpr int kBroadStep_px = 4;  ///< pixels of kLandmarkGsd_m a side of one of these
inline constexpr double kBroadGsd_m = kBroadStep_px * kLandmarkGsd_m;

/// Least and greatest length of what is found: where find_landmarks ends, and the greatest size that a tile keeps.
inline constexpr double kBroadLeast_m = 120, kBroadMost_m = 724;

/// Windows that are looked at as one, and what is seen around them, in pixels of kBroadGsd_m: 2048 m and 512 m.
inline constexpr int kBroadWindow_px = 512, kBroadHalo_px = 128;

/// Channels of the view of an image with so many.
inline constexpr int broad_channels(int of_image) { return 3 + of_image; }

/// What is kept of a scene for find_broad: means over squares of kBroadStep_px pixels of `core` from its corner on,
/// CV_8UC(broad_channels): share with data, ground, water, then the image.
cv::Mat broad_view(const ObjectScene& scene, const cv::Mat& image, const cv::Rect& core);

/// Numbers of a region by which its probability is judged; 1 is the first.
inline constexpr size_t kBroadNumbers = 7;
using BroadNumbers = std::array<double, kBroadNumbers>;

/// A region that may be one field or one lake.
struct BroadRegion {
  Region region;
  BroadNumbers numbers{};
  double confidence = 0;
  int first = 0;  ///< place of its pixels in their order: two regions of a class share pixels where these ranges do,
  int count = 0;  ///< and then one lies within the other
};

/// All regions of a view that may be one; of training, too.
std::vector<BroadRegion> broad_candidates(const cv::Mat& view, tiles::LandmarkClass cls);

/// The surest of them, kLeastConfidence or more, of which none covers another; surest first.
std::vector<BroadRegion> chosen_regions(const cv::Mat& view, tiles::LandmarkClass cls);

/// Fields and water of kBroadLeast_m to kBroadMost_m with their middle in `core`; none covers another of its class. A
/// field is ground of one colour that nothing else crosses (region_merging.h); its centre is that of its area, its
/// outline keeps within 2 pixels. `view`: pixels of broad_view. What reaches the rim or places without data is left
/// out.
std::vector<Extracted> find_broad(const features::GridImage& view, const cv::Rect& core);

/// The same of a whole view, window by window of kBroadWindow_px.
std::vector<Extracted> find_all_broad(const features::GridImage& view);

/// Appends to broad landmarks those that were found otherwise and do not have their centre in one of the same class.
std::vector<Extracted> with_broad(std::vector<Extracted> broad, std::vector<Extracted> found);

}  // namespace landfix::landmarks
