// From what a match looks like to the probability that it is true, and how far off it may be. The numbers come from
// tools/calibrate.
#pragma once

#include "runtime/nav/matcher.h"

namespace landfix::nav {

/// What must be certain before a fix is given out.
enum class Gate {
  kNone,      ///< every match, with its probability
  kStandard,  ///< fewer than 1 false fix in 100
  kStrict     ///< fewer than 1 false fix in 1000
};

/// What tells a true match from a false one.
struct Evidence {
  double value = 0;               ///< height of the peak
  double gap = 0;                 ///< to the highest rival outside of the main lobe
  double spread = 1;              ///< standard deviation of the scores outside of the main lobe
  double sigma_px = 1;            ///< the peak's standard deviation where it is widest, in pixels of the finest level
  double independent_pixels = 0;  ///< of the patch, for the likelihood
  double similarities = 1;        ///< rotations and scales searched: the more there are, the better one fits by chance
};

/// Probability within (0, 1) that a match is true.
double probability_of(Method method, const Evidence& evidence);

/// The same for two methods that looked at one image: `agree`, if their peaks lie in one main lobe.
double combined_probability(double first, double second, bool agree);

/// By how much variances from the curvature of a peak's likelihood are too small: neighbouring pixels err alike.
double variance_factor(Method method);

/// Lowest probability that a gate lets through.
double threshold_of(Gate gate);

}  // namespace landfix::nav
