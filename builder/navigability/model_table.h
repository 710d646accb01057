// Written by tools/navigability/fit.py; not to be edited.
#pragma once

namespace landfix::navigability {

/// Logistic regression on (1, least logit, mean logit, log (structure + kLeastStructure), background,
/// log template / 40 px, 1 / (n (n - 1))), n dates.
inline constexpr double kLeastStructure = 0.03;
inline constexpr double kSeveralDates[5][7] = {{3.95254, 0.0786016, 0.215274, 2.14085, -3.68262, 1.90985, -0.246836},{3.95254, 0.0786016, 0.215274, 2.14085, -3.68262, 1.90985, -0.246836},{3.95254, 0.0786016, 0.215274, 2.14085, -3.68262, 1.90985, -0.246836},{3.95254, 0.0786016, 0.215274, 2.14085, -3.68262, 1.90985, -0.246836},{3.95254, 0.0786016, 0.215274, 2.14085, -3.68262, 1.90985, -0.246836}};
/// The same on (1, structure, background, crest, log template / 40 px).
inline constexpr double kOneDate[5][5] = {{-2.47671, 5.90388, -2.53187, 2.86898, 2.78344},{-2.47671, 5.90388, -2.53187, 2.86898, 2.78344},{-2.47671, 5.90388, -2.53187, 2.86898, 2.78344},{-2.47671, 5.90388, -2.53187, 2.86898, 2.78344},{-2.47671, 5.90388, -2.53187, 2.86898, 2.78344}};
/// Of a match that the standard gate accepts, and of one among those that is false, on (1, logit of a true fix).
inline constexpr double kAccepted[2] = {-2.04112, 0.926337};
inline constexpr double kFalseOfAccepted[2] = {-3.65415, -0.617451};

}  // namespace landfix::navigability
