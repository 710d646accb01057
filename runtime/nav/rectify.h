// From a camera image to a north-up patch on the metric grid, ready to be correlated with the map.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "runtime/features/grid_image.h"
#include "runtime/nav/camera.h"
#include "runtime/nav/status.h"

namespace landfix::nav {

struct RectifyOptions {
  double max_reach_heights = 3;    ///< ground farther away than this many heights above ground does not count
  int64_t max_pixels = 4'000'000;  ///< of the patch's bounding box
};

/// Projects a camera image on a horizontal plane `height_above_ground_m` below the camera and samples it north-up at
/// `gsd_m`. Each patch pixel is the mean of the image over the square it covers on the ground, as a map pixel is of the
/// scene; this scales (Conte 2009 eq. 5.14) and aligns in one step. Full pinhole projection with roll, pitch and
/// heading, so the offset between image centre and position is removed too. `gray_image`: H×W CV_8UC1 of the camera's
/// size. `patch`: `pixels` CV_8UC1, `valid` the footprint (255/0); `west_m` and `north_m` are relative to the camera's
/// ground position and whole multiples of `gsd_m`. Its buffers are reused. Errors: kNotFinite, kBadValue, kBadImage,
/// kBelowGround (height not positive), kNothingVisible (no pixel within reach), kTooLarge.
Status rectify(const cv::Mat& gray_image, const Camera& camera, const Attitude& attitude, double height_above_ground_m,
               double gsd_m, features::GridImage& patch, const RectifyOptions& options = {});

/// Half the extent of the footprint east-west (x) and north-south (y), measured from the camera's ground position, in
/// metres: what a search region must be grown by. Errors as `rectify`.
Status footprint_reach(const Camera& camera, const Attitude& attitude, double height_above_ground_m,
                       cv::Point2d& reach_m, const RectifyOptions& options = {});

}  // namespace landfix::nav
