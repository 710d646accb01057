// An orthophoto that can be looked up at any ground resolution: a pyramid of halved levels.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "runtime/features/grid_image.h"

namespace landfix::terrain {

/// Texture pyramid ("mipmap", Williams 1983, "Pyramidal Parametrics"). Level k has a GSD of 2^k times the source's; a
/// texel of a level holds data only where all four texels below it do.
class Texture {
 public:
  /// `ortho`: CV_8UC1 or CV_8UC3. Throws Error (kBadInput) for another type or an empty image.
  explicit Texture(const features::GridImage& ortho);

  int channels() const { return levels_.front().pixels.channels(); }
  const features::GridImage& base() const { return levels_.front(); }

  /// Value at a place as a picture element of `footprint_m` metres on the ground sees it: bilinear within a level,
  /// linear between the two levels around the footprint; below the base level's GSD bilinear alone. Writes channels()
  /// values of 0...255; false (and nothing written) where any texel that takes part holds no data.
  bool sample(double east_m, double north_m, double footprint_m, float* value) const;

 private:
  std::vector<features::GridImage> levels_;
};

}  // namespace landfix::terrain
