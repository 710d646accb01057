// Which way a landmark lies.
#pragma once

#include <cmath>
#include <numbers>

namespace landfix::landmarks {

/// Length / width from which a rectangle has a direction.
inline constexpr double kElongated = 1.15;

/// Direction of a line without sense, clockwise from grid north, in [0, pi).
inline double orientation_of(double east, double north) {
  const double direction = std::atan2(east, north);
  const double turned = direction < 0 ? direction + std::numbers::pi : direction;
  return turned >= std::numbers::pi ? turned - std::numbers::pi : turned;
}

}  // namespace landfix::landmarks
