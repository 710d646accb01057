// Written by tools/calibrate/fit.py; not to be edited.
#pragma once

namespace landfix::nav {

/// Logistic regression on (1, gap, gap / spread, log sigma_px), by Method.
inline constexpr double kCalibration[4][4] = {
    {0.225188, 17.3243, 0.437869, -2.53072},  // gray
    {-1.1471, 15.3697, 0.747643, -0.718771},  // edge
    {0.368447, 16.4069, 0, -2.27526},  // contour
    {-1.04814, 29.9612, 1.72594, -1.33086},  // orientation
};
inline constexpr double kLargestSignificance = 12;
inline constexpr double kStandardThreshold = 0.9707;
inline constexpr double kStrictThreshold = 0.99699;

}  // namespace landfix::nav
