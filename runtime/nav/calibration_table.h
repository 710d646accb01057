// Written by tools/calibrate/fit.py; not to be edited.
#pragma once

namespace landfix::nav {

/// Logistic regression on (1, gap, gap / spread, log sigma_px), by Method.
inline constexpr double kCalibration[4][4] = {
    {0.126037, 17.7316, 0.420321, -2.42767},  // gray
    {-1.14033, 15.6291, 0.715085, -0.725491},  // edge
    {0.582262, 16.4235, 0, -2.48946},  // contour
    {-1.14339, 29.7399, 1.77474, -1.21503},  // orientation
};
inline constexpr double kLargestSignificance = 12;
inline constexpr double kStandardThreshold = 0.9426;
inline constexpr double kStrictThreshold = 0.99696;

}  // namespace landfix::nav
