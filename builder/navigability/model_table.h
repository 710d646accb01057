// Written by tools/navigability/fit.py; not to be edited.
#pragma once

namespace landfix::navigability {

/// Logistic regression on (1, least logit, mean logit, log (structure + kLeastStructure), background,
/// log template / 40 px, 1 / (n (n - 1))), n dates; rows by nav::Method.
inline constexpr double kLeastStructure = 0.03;
inline constexpr double kSeveralDates[4][7] = {
    {0.805912, 0.118492, 0.154007, 0.208282, 0, 0.242295, -0.500959},
    {1.75586, 0.0584042, 0.124057, 1.28848, 0, 0.933201, -0.131003},
    {3.75175, 0.127944, 0.365223, 3.80541, 0, 0.570063, 0},
    {3.95254, 0.0786016, 0.215274, 2.14085, -3.68262, 1.90985, -0.246836}};
/// The same on (1, structure, background, crest, log template / 40 px).
inline constexpr double kOneDate[4][5] = {
    {-1.82182, 3.72934, -0.659, 0, 0.335738},
    {-3.18984, 2.22905, 0, 5.20348, 1.5189},
    {-10.4446, 4.74547, 0, 11.9893, 3.01563},
    {-2.47671, 5.90388, -2.53187, 2.86898, 2.78344}};

}  // namespace landfix::navigability
