#include "tools/synth/objects.h"

#include <algorithm>
#include <cmath>

namespace landfix::synth {

Rectangle bounds_of(std::span<const Point> points) {
  Rectangle r{1e30, 1e30, -1e30, -1e30};
  for (const Point& p : points) {
    r = {std::min(r.west_m, p.x), std::min(r.south_m, p.y), std::max(r.east_m, p.x), std::max(r.north_m, p.y)};
  }
  return r;
}

std::string_view name_of(Crop crop) {
  constexpr std::array<std::string_view, 11> kNames = {"wheat",   "rapeseed", "barley", "maize", "beet",   "sunflower",
                                                       "alfalfa", "potato",   "fallow", "grass", "orchard"};
  return kNames.at(static_cast<size_t>(crop));
}

std::string_view name_of(RoadKind kind) {
  constexpr std::array<std::string_view, 4> kNames = {"track", "street", "minor", "main"};
  return kNames.at(static_cast<size_t>(kind));
}

std::string_view name_of(Roof roof) { return roof == Roof::kFlat ? "flat" : "gabled"; }

Outline Building::outline() const {
  const double l = length_m / 2, w = width_m / 2;
  Outline local = {{-l, -w}, {l, -w}, {l, w}, {-l, w}};
  if (wing_length_m > 0) {
    local = {{-l, -w}, {l, -w}, {l, w + wing_length_m}, {l - wing_width_m, w + wing_length_m}, {l - wing_width_m, w},
             {-l, w}};
  }
  for (Point& p : local) p = centre + Point(axis.x * p.x - axis.y * p.y, axis.y * p.x + axis.x * p.y);
  return local;
}

double Building::outside_m(Point local) const {
  const double body = std::max(std::abs(local.x) - length_m / 2, std::abs(local.y) - width_m / 2);
  if (wing_length_m <= 0) return body;
  const double from_wing_axis = std::abs(local.x - (length_m - wing_width_m) / 2);
  const double wing = std::max({from_wing_axis - wing_width_m / 2, -local.y, local.y - width_m / 2 - wing_length_m});
  return std::min(body, wing);
}

double Building::roof_m(Point local, Point* slope) const {
  if (roof == Roof::kFlat) {
    if (slope != nullptr) *slope = {0, 0};
    return height_m;
  }
  const double rise = height_m - eave_m;
  const double body_slope = rise / (width_m / 2);
  double height = height_m - body_slope * std::abs(local.y);
  Point fall(0, local.y > 0 ? -body_slope : body_slope);
  if (wing_length_m > 0 && local.y > 0) {
    // The wing has the pitch of the body, so its narrower ridge runs lower into the body's roof.
    const double across = local.x - (length_m - wing_width_m) / 2;
    const double wing = eave_m + body_slope * (wing_width_m / 2 - std::abs(across));
    if (wing > height) {
      height = wing;
      fall = {across > 0 ? -body_slope : body_slope, 0};
    }
  }
  if (slope != nullptr) *slope = fall;
  return std::max(height, eave_m);
}

double Building::reach_m() const { return std::hypot(length_m / 2, width_m / 2 + wing_length_m); }

double Lake::radius_m(double theta_rad) const {
  double r = 1;
  for (size_t k = 0; k < amplitude.size(); ++k) {
    r += amplitude[k] * std::cos(static_cast<double>(k + 2) * theta_rad + phase[k]);
  }
  return mean_radius_m * r;
}

double Lake::largest_radius_m() const {
  double r = 1;
  for (double a : amplitude) r += std::abs(a);
  return mean_radius_m * r;
}

double Lake::shore_distance_m(Point p) const {
  const Point d = p - centre;
  return std::hypot(d.x, d.y) - radius_m(std::atan2(d.y, d.x));
}

Outline Lake::outline() const {
  constexpr int kPoints = 180;
  Outline shore(kPoints);
  for (int i = 0; i < kPoints; ++i) {
    const double theta = 2 * M_PI * i / kPoints;
    shore[i] = centre + radius_m(theta) * Point(std::cos(theta), std::sin(theta));
  }
  return shore;
}

}  // namespace landfix::synth
