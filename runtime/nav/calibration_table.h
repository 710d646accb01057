// Written by tools/calibrate/fit.py; not to be edited.
#pragma once

namespace landfix::nav {

/// Logistic regression on (1, gap, gap / spread, value / spread, -log similarities, log sigma_px), by Method.
inline constexpr double kCalibration[4][6] = {
    {-0.578654, 20.3456, 0, 0.181617, 0.054856, -2.24369},          // gray
    {-1.34299, 14.9603, 0.686752, 0.0411447, 0.161323, -0.681668},  // edge
    {-0.190236, 12.809, 0, 0.21479, 0, -2.28472},                   // contour
    {-5.4055, 38.5718, 0.091826, 1.14479, 0.219337, -1.06169},      // orientation
};
inline constexpr double kLargestSignificance = 12, kLargestHeight = 20;
inline constexpr double kStandardThreshold = 0.9419;
inline constexpr double kStrictThreshold = 0.99693;

}  // namespace landfix::nav
