// Shade: what the sun moves. Map and camera leave it out alike.
#pragma once

#include "runtime/features/grid_image.h"

namespace landfix::features {

struct ShadeOptions {
  double ratio = 0.9;         ///< a pixel below this share of the mean around it is in the shade
  double window_m = 30;       ///< side of the square of that mean: larger than a shadow, smaller than a field
  double coarsest_gsd_m = 2;  ///< where pixels are larger no shadow is resolved, and nothing is left out
};

/// Marks pixels in the shade of trees and buildings as not valid: they lie elsewhere under another sun, and drag a
/// correlation of gray values with them. `image`: CV_8UC1; its mean is taken over valid pixels only. Dark surfaces are
/// lost too where they are narrow; there is enough else. Throws cv::Exception for another type.
void leave_out_shade(GridImage& image, const ShadeOptions& options = {});

}  // namespace landfix::features
