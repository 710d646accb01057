// Masked zero-mean normalized cross-correlation of a rectified patch over a window of the map.
#pragma once

#include <memory>

#include "runtime/features/grid_image.h"
#include "runtime/nav/status.h"

namespace landfix::nav {

/// Correlates; keeps its buffers, so that repeated matches of like size allocate next to nothing. One object per
/// thread.
class Ncc {
 public:
  /// `min_coverage`: share of the patch's valid pixels that must meet valid pixels of the window for a position to
  /// count.
  explicit Ncc(double min_coverage = 0.5);
  ~Ncc();
  Ncc(Ncc&&) noexcept;
  Ncc& operator=(Ncc&&) noexcept;

  /// Conte 2009 eq. 5.15 with sums and means over the pixels valid in both images.
  /// `patch`: h×w, `window`: H×W, both CV_8UC1 with an optional mask. `surface`: (H−h+1)×(W−w+1) CV_32F in −1 to 1,
  /// with `valid`. Its georeference makes the centre of a surface pixel the position of the patch's origin: the camera,
  /// if `patch` comes from `rectify`. Where patch or window is flat (variance below that of rounding to 8 bits, 1/12)
  /// the surface is 0, never NaN; where coverage is too small it is 0 and not valid. Errors: kBadImage,
  /// kTemplateTooLarge, kNoTexture (flat patch; the surface is all 0), kOutsideMap (no position valid), kInternal.
  Status match(const features::GridImage& patch, const features::GridImage& window, features::GridImage& surface);

  /// How many independent samples the last patch is worth: its valid pixels over Σρ², ρ its autocorrelation. A
  /// coefficient with unrelated content of like texture has a variance of one over this (Bartlett 1946). 0 before the
  /// first match.
  double independent_pixels() const;

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace landfix::nav
