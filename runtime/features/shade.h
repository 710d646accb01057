// Shade: what the sun moves. Map and camera even it out alike.
#pragma once

#include "runtime/features/grid_image.h"

namespace landfix::features {

struct ShadeOptions {
  double ratio = 0.9;         ///< a pixel below this share of the mean around it counts as shade
  double window_m = 30;       ///< side of the square of that mean: larger than a shadow, smaller than a field
  double coarsest_gsd_m = 2;  ///< where pixels are larger no shadow is resolved, and nothing is lifted
};

/// Lifts the shade of trees and buildings to the level of what is around it: it lies elsewhere under another sun, and
/// drags a correlation of gray values with it. A pixel becomes at least `ratio` times the mean of the valid pixels in
/// the window around it. `image`: CV_8UC1; `valid` stays as it is. Throws cv::Exception for another type.
void lift_shade(GridImage& image, const ShadeOptions& options = {});

}  // namespace landfix::features
