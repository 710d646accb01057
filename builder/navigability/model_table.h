// Written by tools/navigability/fit.py; not to be edited.
#pragma once

namespace landfix::navigability {

/// Logistic regression on (1, least logit, mean logit, log (structure + kLeastStructure), background,
/// log template / 40 px, 1 / (n (n - 1))), n dates.
inline constexpr double kLeastStructure = 0.03;
inline constexpr double kSeveralDates[7] = {3.75287, 0.0643032, 0.220494, 1.91909, -4.71473, 1.73963, -0.167487};
/// The same on (1, structure, background, crest, log template / 40 px).
inline constexpr double kOneDate[5] = {-1.96059, 5.86751, -2.99177, 2.10829, 2.56325};
/// Of a match that the standard gate accepts, and of one among those that is false, on (1, logit of a true fix).
inline constexpr double kAccepted[2] = {-2.14503, 0.973777};
inline constexpr double kFalseOfAccepted[2] = {-3.6462, -0.769949};

}  // namespace landfix::navigability
