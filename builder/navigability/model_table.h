// Written by tools/navigability/fit.py; not to be edited.
#pragma once

namespace landfix::navigability {

/// Logistic regression on (1, least logit, mean logit, structure, background, log template / 40 px, 1 / (n (n - 1))).
inline constexpr double kSeveralDates[7] = {-0.503, 0.0675, 0.1108, 7.6544, -7.5556, 2.5289, -0.7183};
/// The same on (1, structure, background, crest, log template / 40 px).
inline constexpr double kOneDate[5] = {0, 1, 1, 1, 1};

}  // namespace landfix::navigability
