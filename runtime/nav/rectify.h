// From a camera image to a north-up patch on the metric grid, ready to be correlated with the map.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "runtime/features/grid_image.h"
#include "runtime/nav/camera.h"
#include "runtime/nav/status.h"
#include "runtime/nav/terrain.h"

namespace landfix::nav {

struct RectifyOptions {
  double max_reach_heights = 3;    ///< ground farther away than this many heights above ground does not count
  int64_t max_pixels = 4'000'000;  ///< of the patch's bounding box
};

/// Projects a camera image on a horizontal plane `height_above_ground_m` below the camera and samples it north-up at
/// `gsd_m`. Each patch pixel is the mean of the image over the square it covers on the ground, as a map pixel is of the
/// scene; this scales (Conte 2009 eq. 5.14) and aligns in one step. Full projection with roll, pitch and heading, so
/// the offset between image centre and position is removed too, and with the lens's distortion: patch pixel, ground
/// point, ray, distorted pixel, one interpolation. `image`: H×W of the camera's size, CV_8UC1 to CV_8UC4, colours in
/// the order red, green, blue (further bands as they are). `patch`: `pixels` of the same type; `valid` (255/0) the
/// footprint, less what the camera's mask leaves out and what lies beyond the lens's fold; `west_m` and `north_m` are
/// relative to the camera's ground position and whole multiples of `gsd_m`. Its buffers are reused. Errors: kNotFinite,
/// kBadValue, kBadImage, kBelowGround (height not positive), kNothingVisible (no pixel within reach), kTooLarge,
/// kInternal.
Status rectify(const cv::Mat& image, const Camera& camera, const Attitude& attitude, double height_above_ground_m,
               double gsd_m, features::GridImage& patch, const RectifyOptions& options = {});

/// How much of a patch the heights decided, as shares of the pixels within the camera's image.
struct TerrainUse {
  double known = 0;   ///< of the valid pixels: ground height known; the rest lies on the plane
  double hidden = 0;  ///< made invalid because nearer ground stands before them
};

/// The same through the heights of the terrain instead of one plane: an orthophoto of the view. Pixels that the camera
/// cannot see because nearer ground hides them are not valid (bare ground and surface models alike; shadow edges to
/// about half a pixel of patch or heights, whichever is coarser). Where no height is known the plane serves, and `use`
/// says how much of the patch that is. Reach counts in heights above the plane. Further errors: kBelowGround where the
/// plane or the ground under the camera is not below it, and those of `check(terrain)`.
Status rectify(const cv::Mat& image, const Camera& camera, const Attitude& attitude, const Position& position,
               const Terrain& terrain, double gsd_m, features::GridImage& patch, TerrainUse* use = nullptr,
               const RectifyOptions& options = {});

/// Half the extent of the footprint east-west (x) and north-south (y), measured from the camera's ground position, in
/// metres: what a search region must be grown by. Errors as `rectify`.
Status footprint_reach(const Camera& camera, const Attitude& attitude, double height_above_ground_m,
                       cv::Point2d& reach_m, const RectifyOptions& options = {});

}  // namespace landfix::nav
