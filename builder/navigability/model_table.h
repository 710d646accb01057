// Written by tools/navigability/fit.py; not to be edited.
#pragma once

namespace landfix::navigability {

/// Logistic regression on (1, least logit, mean logit, log (structure + kLeastStructure), background,
/// log template / 40 px, 1 / (n (n - 1))), n dates; rows by nav::Method.
inline constexpr double kLeastStructure = 0.03;
inline constexpr double kSeveralDates[4][7] = {
    {0.805912, 0.118492, 0.154007, 0.208282, 0, 0.242295, -0.500959},
    {1.57424, 0.07075, 0.0986478, 0.936424, 0, 1.03352, -0.298266},
    {3.33098, 0.115716, 0.401285, 2.92383, 0, 0.591863, -0.12793},
    {3.95254, 0.0786016, 0.215274, 2.14085, -3.68262, 1.90985, -0.246836}};
/// Where there is one date: on (1, structure, background, crest, log template / 40 px).
inline constexpr double kOneDate[3][5] = {
    {-1.82182, 3.72934, -0.659, 0, 0.335738},
    {-2.88339, 1.8027, 0, 4.74535, 1.5881},
    {-9.17084, 4.89269, 0, 9.86515, 3.1255}};
/// By drawn views, of orientation: on (1, log (structure + kLeastStructure), background, mean logit, log template / 40
/// px, mean logit times that).
inline constexpr double kDrawnViews[6] = {3.05782, 1.89164, -3.28714, 0.135297, 1.89571, -0.0982123};

}  // namespace landfix::navigability
