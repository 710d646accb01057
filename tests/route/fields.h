// Navigability drawn for the tests: fields with lakes and gaps, and flat ground below.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tools/route/score.h"

namespace landfix::route {

inline const tiles::Zone kZone{32, true};
inline constexpr double kEast = 500'000, kNorth = 5'200'000;  ///< south-western corner of what is drawn

/// Flat ground at 400 m, the geoid 50 m above the ellipsoid.
inline Heights flat_heights() {
  return {[](double, double) { return std::optional(400.0); }, [](double, double) { return std::optional(50.0); }};
}

inline Navigability good_place(double fix = 0.9, double sigma_m = 1.5) {
  Navigability n;
  n.fix_probability = fix;
  n.false_probability = 0.001;
  n.covariance_m2 = sigma_m * sigma_m * Eigen::Matrix2d::Identity();
  return n;
}

inline Navigability poor_place(uint32_t reasons, double fix = 0) {
  Navigability n = good_place(fix);
  n.false_probability = 0;
  n.reasons = reasons;
  return n;
}

/// Good ground of this size with rectangles and discs of something else; coordinates from the corner, metres.
struct Patch {
  double west, south, east, north;
  Navigability what;
  bool round = false;  ///< the ellipse inside the rectangle
  bool holds(double x, double y) const {
    if (x < west || x > east || y < south || y > north) return false;
    const double u = (2 * x - west - east) / (east - west), v = (2 * y - south - north) / (north - south);
    return !round || u * u + v * v <= 1;
  }
};

inline FunctionMap field(double size_m, std::vector<Patch> patches, Navigability ground = good_place()) {
  return FunctionMap({kEast, kNorth, kEast + size_m, kNorth + size_m},
                     [patches = std::move(patches), ground](double x, double y, double, double) {
                       for (const Patch& patch : patches)
                         if (patch.holds(x - kEast, y - kNorth)) return std::optional(patch.what);
                       return std::optional(ground);
                     });
}

inline Eigen::Vector2d at(double x_m, double y_m) { return {kEast + x_m, kNorth + y_m}; }

inline Vehicle vehicle() {
  Vehicle v;
  v.errors = error_model({});
  return v;
}

/// Scores that ask nothing of drawn flights.
inline ScoreOptions without_flights(const Requirement& requirement = {}) {
  ScoreOptions options;
  options.requirement = requirement;
  options.flights = 0;
  return options;
}

}  // namespace landfix::route
