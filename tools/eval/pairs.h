// Registration between images of one place without georeference: each image of a folder in its namesake of another.
#pragma once

#include <string>
#include <vector>

#include "tools/eval/report.h"

namespace landfix::eval {

struct PairsOptions {
  double gsd_m = 1;       ///< of all images
  int template_px = 128;  ///< side of the template that votes
  double hit_px = 3;      ///< an answer this near to the truth is true
  int placements = 7;     ///< templates per row and per column, evenly from edge to edge
  int rim_px = 8;         ///< beyond the template, where the image has it; does not vote
  std::vector<MatcherChoice> matchers{{}};
  nav::Gate gate = nav::Gate::kStandard;
  int threads = 0;  ///< 0: one per core
};

/// Cuts templates out of every image of folder `a`, searches them in the whole image of the same name in folder `b`,
/// and the other way round: two entries, "A in B" and "B in A". All samples of a pair
/// share their block. Throws Error: kIo where a folder cannot be read, kBadInput for a folder without images, an image
/// without a namesake or of another size, or one smaller than the template.
std::vector<CameraTrials> register_pairs(const std::string& a, const std::string& b, const PairsOptions& options);

}  // namespace landfix::eval
