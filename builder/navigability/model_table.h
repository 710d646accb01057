// Written by tools/navigability/fit.py; not to be edited.
#pragma once

namespace landfix::navigability {

/// Logistic regression on (1, least logit, mean logit, log (structure + kLeastStructure), background,
/// log template / 40 px, 1 / (n (n - 1))), n dates; rows by nav::Method, then auto.
inline constexpr double kLeastStructure = 0.03;
inline constexpr double kSeveralDates[5][7] = {
    {1.3711, 0.142822, 0.151194, 0.78394, -0.348259, 0.303802, -0.183935},
    {1.75586, 0.0584042, 0.124057, 1.28848, 0, 0.933201, -0.131003},
    {3.75175, 0.127944, 0.365223, 3.80541, 0, 0.570063, 0},
    {3.95254, 0.0786016, 0.215274, 2.14085, -3.68262, 1.90985, -0.246836},
    {2.19343, 0.0762872, 0.259104, 0.0906512, -5.79242, 1.40751, 0}};
/// The same on (1, structure, background, crest, log template / 40 px).
inline constexpr double kOneDate[5][5] = {
    {-2.2074, 3.86731, -3.82421, 1.0449, 0.251354},
    {-3.18984, 2.22905, 0, 5.20348, 1.5189},
    {-10.4446, 4.74547, 0, 11.9893, 3.01563},
    {-2.47671, 5.90388, -2.53187, 2.86898, 2.78344},
    {-0.684137, 2.66305, -1.9979, 2.11501, 1.97916}};
/// Of a match by auto that the standard gate accepts, and of one among those that is false, on (1, logit of a true
/// fix).
inline constexpr double kAccepted[2] = {-1.66475, 0.891957};
inline constexpr double kFalseOfAccepted[2] = {-3.47945, -0.512575};

}  // namespace landfix::navigability
