// Heights of ground and objects on a lattice of pixels, and the shadows they cast.
#pragma once

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "tools/synth/layout.h"
#include "tools/synth/season.h"

namespace landfix::synth {

/// Pixels at whole multiples of the GSD from the zone's origin, so that every window has the same sample points.
struct Lattice {
  int64_t left = 0;  ///< west edge in pixels from easting 0
  int64_t top = 0;   ///< north edge in pixels from northing 0
  int width = 0, height = 0;
  double gsd_m = 1;

  SampleRow row(int y) const { return {left, gsd_m, (static_cast<double>(top - y) - 0.5) * gsd_m}; }
  Point at(int x, int y) const {
    const SampleRow r = row(y);
    return {r.east_m(x), r.north_m};
  }
  Rectangle area() const {
    return {static_cast<double>(left) * gsd_m, static_cast<double>(top - height) * gsd_m,
            static_cast<double>(left + width) * gsd_m, static_cast<double>(top) * gsd_m};
  }
  Lattice grown(int by) const { return {left - by, top + by, width + 2 * by, height + 2 * by, gsd_m}; }

  /// Calls `visit(x, y, grid)` for the pixels whose centres lie in `r`.
  template <typename Visit>
  void visit(const Rectangle& r, Visit&& visit) const {
    const auto clip = [](double v, int n) { return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(n))); };
    const int x0 = clip(std::ceil(r.west_m / gsd_m - static_cast<double>(left) - 0.5), width);
    const int x1 = clip(std::floor(r.east_m / gsd_m - static_cast<double>(left) + 0.5), width);
    const int y0 = clip(std::ceil(static_cast<double>(top) - r.north_m / gsd_m - 0.5), height);
    const int y1 = clip(std::floor(static_cast<double>(top) - r.south_m / gsd_m + 0.5), height);
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) visit(x, y, at(x, y));
    }
  }
};

struct Sun {
  double azimuth_rad = 0;  ///< from grid north, clockwise
  double elevation_rad = 0;
};

/// Heights in metres above the ellipsoid.
struct Surface {
  cv::Mat1f ground;
  cv::Mat1f top;      ///< of whatever stands there
  cv::Mat1f opacity;  ///< of what stands there, to sunlight
};

/// Height of a crown above the tree's base, `away_m` from its stem and within its radius.
double crown_m(const Tree& tree, double away_m);

Surface make_surface(const Layout& layout, const std::vector<Tree>& trees, const Lattice& lattice, Season season);

/// Shadows are followed over this distance: enough for what stands on gentle ground.
double shadow_reach_m(const Sun& sun);

/// Share of sunlight held back, 0 to 1, for the inner `width` × `height` pixels of a surface that has `margin` pixels
/// around them, at least `shadow_reach_m / gsd_m + 2`.
cv::Mat1f shadows(const Surface& surface, const Sun& sun, double gsd_m, int margin);

}  // namespace landfix::synth
