// From a correlation surface to the likelihood of positions, honest where the peak is weak or ambiguous.
#pragma once

#include <array>

#include "runtime/features/grid_image.h"
#include "runtime/nav/status.h"

namespace landfix::nav {

struct LikelihoodOptions {
  double independent_pixels = 100;    ///< N: template pixels over pixels that share one independent residual
  double position_sigma_m = 0.5;      ///< of the position given the true match: attitude noise × height, grid spacings
  double outlier_probability = 0.02;  ///< ε: of an image that says nothing about the position
};

/// Likelihood of positions relative to that of an image that says nothing: 1 is no information.
struct Likelihood {
  features::GridImage values;  ///< CV_32F, positive; the centre of a pixel is a position; `valid` as in the surface
  double outside = 1;          ///< of positions beyond the grid
};

/// Gain, offset and noise of the camera against the map are unknown; maximised over, a Gaussian residual leaves
///   log L(x) = −N/2 · log(1 − max(C(x), 0)²)
/// (concentrated likelihood of a linear regression; a contrast reversal is no match). L is convolved with the Gaussian
/// error of the position (separable), normalised to mean 1 over the n valid positions of the surface and mixed with
/// outliers:
///   p(y|x) = (1 − ε) n L/ΣL + ε, ε beyond the surface, 1 where the surface is not valid (Conte 2009 eq. 5.25).
/// `surface`: from Ncc::match. Buffers of `likelihood` are reused.
/// Errors: kNotFinite, kBadValue (options), kBadImage (surface not CV_32F), kOutsideMap (nothing valid), kInternal.
Status likelihood_from_ncc(const features::GridImage& surface, const LikelihoodOptions& options,
                           Likelihood& likelihood);

/// Raises a likelihood to a power of 0 to 1: for an image that partly repeats what an earlier one said. kBadValue,
/// kInternal.
Status temper(double exponent, Likelihood& likelihood);

/// Covariance in m² of the position by this likelihood alone, outliers left out, row-major over (east, north): wide
/// where it is ambiguous. `likelihood` must not be empty.
std::array<double, 4> covariance_m2(const Likelihood& likelihood);

/// The highest peak of a surface and what rivals it.
struct Peak {
  double east_m = 0, north_m = 0;  ///< refined by a parabola through the neighbours
  double value = 0;
  double gap =
      0;  ///< value less that of the highest local maximum farther than the main lobe; value + 1 if there is none
};

/// `main_lobe_px`: radius around the peak that belongs to it. Same errors as above.
Status find_peak(const features::GridImage& surface, int main_lobe_px, Peak& peak);

}  // namespace landfix::nav
