// Heading from lines: by how much the camera's edges are turned against the map's (Conte 2009 §7.3.3, Algorithm 1).
#pragma once

#include "runtime/features/contour.h"
#include "runtime/features/grid_image.h"
#include "runtime/nav/status.h"

namespace landfix::nav {

struct HeadingOptions {
  double max_offset_rad = 0.78539816339744831;  ///< 45°: beyond that a town of right angles looks the same again
  double min_quality = 6;             ///< below this no heading is given: about 1 % of unrelated places reach it
  int min_contour_px = 200;           ///< fewer contour pixels in patch or map tell nothing
  features::ContourOptions contours;  ///< what counts as an edge, in both images
};

/// By how much the heading that the patch was rectified with is wrong.
struct HeadingOffset {
  double offset_rad = 0;  ///< true heading = heading of the patch + this; clockwise
  double sigma_rad = 0;   ///< one sigma, provided that the right peak was taken
  double quality = 0;     ///< how far the peak stands above all other angles, in their standard deviations
  double gap = 0;         ///< to the best rival outside the main lobe, as a share of the peak, 0 to 1
};

/// Turns the patch against the map until their lines agree. `patch`: the camera's image rectified north-up with the
/// heading to be corrected; `map`: the map on the same GSD around the same place, of about the same extent (what lies
/// beyond the patch only disturbs); the two may be shifted by a good part of their size. Both H×W CV_8UC1 with an
/// optional mask.
///
/// Conte detects lines in both Hough transforms and averages the angles between corresponding ones. Here nothing is
/// detected and no correspondence chosen: contour pixels vote in Hough space near the direction of their gradient; the
/// magnitude of its Fourier transform along ρ, which a shift leaves as it is, keeps per angle both how much of the
/// edges lies on lines and how far apart these are; the offset is where the two images' spectra correlate best. The
/// sense of the gradient does not count, so light and dark may be exchanged.
///
/// The map must show the place: another town or other fields with straight lines of their own agree at some angle too,
/// and `quality` then cannot tell.
///
/// Errors: kBadImage, kBadValue (GSDs differ, options), kNoTexture (no contours, or no agreement of lines that stands
/// out from chance; `result` then holds what was found all the same), kInternal.
Status align_heading(const features::GridImage& patch, const features::GridImage& map, HeadingOffset& result,
                     const HeadingOptions& options = {});

}  // namespace landfix::nav
