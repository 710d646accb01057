#include "runtime/nav/terrain.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace landfix::nav {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kMaxFan = 16'000'000;  ///< entries of a horizon: 64 MB

/// Nearest and farthest distance of a rectangle from the origin.
std::pair<double, double> ranges_of(const cv::Rect2d& r) {
  const double x = std::max({r.x, -(r.x + r.width), 0.0}), y = std::max({r.y, -(r.y + r.height), 0.0});
  const double far_x = std::max(std::abs(r.x), std::abs(r.x + r.width)),
               far_y = std::max(std::abs(r.y), std::abs(r.y + r.height));
  return {std::hypot(x, y), std::hypot(far_x, far_y)};
}

/// Directions (atan2 of north, east) under which a rectangle is seen from the origin: the first, and how many radians.
std::pair<double, double> directions_of(const cv::Rect2d& r) {
  if (r.contains({0, 0}) || ranges_of(r).first <= 0) return {-kPi, 2 * kPi};
  const double middle = std::atan2(r.y + 0.5 * r.height, r.x + 0.5 * r.width);
  double low = 0, high = 0;
  for (double x : {r.x, r.x + r.width})
    for (double y : {r.y, r.y + r.height}) {
      const double turn = std::remainder(std::atan2(y, x) - middle, 2 * kPi);
      low = std::min(low, turn);
      high = std::max(high, turn);
    }
  return {middle + low, high - low};
}

}  // namespace

Status check(const Terrain& t) {
  if (!std::isfinite(t.plane_height_m)) return Status::kNotFinite;
  if (t.heights.pixels.empty()) return Status::kOk;
  if (t.heights.pixels.type() != CV_32FC1) return Status::kBadImage;
  if (!t.heights.valid.empty() &&
      (t.heights.valid.type() != CV_8UC1 || t.heights.valid.size() != t.heights.pixels.size()))
    return Status::kBadImage;
  if (!std::isfinite(t.heights.west_m) || !std::isfinite(t.heights.north_m) || !std::isfinite(t.heights.gsd_m))
    return Status::kNotFinite;
  return t.heights.gsd_m > 0 ? Status::kOk : Status::kBadValue;
}

Relief::Relief(const Terrain& terrain, const Position& origin)
    : heights_(terrain.heights.pixels.size()),
      west_m_(terrain.heights.west_m - origin.east_m),
      north_m_(terrain.heights.north_m - origin.north_m),
      gsd_m_(terrain.heights.gsd_m),
      plane_m_(terrain.plane_height_m - origin.height_m),
      lowest_m_(plane_m_),
      highest_m_(plane_m_) {
  const features::GridImage& h = terrain.heights;
  for (int y = 0; y < heights_.rows; ++y) {
    const float* in = h.pixels.ptr<float>(y);
    const uint8_t* valid = h.valid.empty() ? nullptr : h.valid.ptr<uint8_t>(y);
    for (int x = 0; x < heights_.cols; ++x) {
      const bool known = (!valid || valid[x]) && std::isfinite(in[x]);
      const double height = known ? in[x] - origin.height_m : kNaN;
      heights_(y, x) = float(height);
      if (!known) continue;
      lowest_m_ = std::min(lowest_m_, height);
      highest_m_ = std::max(highest_m_, height);
    }
  }
  measure_slopes();
}

void Relief::measure_slopes() {
  float across = 0, along = 0;
  bool unknown = false;
  for (int y = 0; y < heights_.rows; ++y) {
    const float *here = heights_[y], *below = heights_[std::min(y + 1, heights_.rows - 1)];
    for (int x = 0; x < heights_.cols; ++x) {
      const float right = here[std::min(x + 1, heights_.cols - 1)];
      across = std::max(across, std::abs(right - here[x]));
      along = std::max(along, std::abs(below[x] - here[x]));
      unknown |= here[x] != here[x];
    }
  }
  if (!heights_.empty()) steepest_ = std::hypot(across, along) / gsd_m_;
  if (unknown) steepest_ = std::numeric_limits<double>::infinity();
}

double Relief::known_height_m(double east_m, double north_m) const {
  if (heights_.empty()) return kNaN;
  const double column = (east_m - west_m_) / gsd_m_ - 0.5, row = (north_m_ - north_m) / gsd_m_ - 0.5;
  if (!(column >= -0.5 && row >= -0.5 && column <= heights_.cols - 0.5 && row <= heights_.rows - 0.5)) return kNaN;
  // The outer half of the border pixels has one neighbour less: their height goes on.
  const double x = std::clamp(column, 0.0, heights_.cols - 1.0), y = std::clamp(row, 0.0, heights_.rows - 1.0);
  const int x0 = std::min(int(x), std::max(heights_.cols - 2, 0)), x1 = std::min(x0 + 1, heights_.cols - 1);
  const int y0 = std::min(int(y), std::max(heights_.rows - 2, 0)), y1 = std::min(y0 + 1, heights_.rows - 1);
  const double u = x - x0, v = y - y0;
  const float *top = heights_[y0], *bottom = heights_[y1];
  return (1 - v) * ((1 - u) * top[x0] + u * top[x1]) + v * ((1 - u) * bottom[x0] + u * bottom[x1]);
}

Horizon::Horizon(const Relief& relief, const cv::Rect2d& area, double step_m) : step_m_(step_m) {
  const auto [nearest, farthest] = ranges_of(area);
  // What hides a point lies between it and where its line of sight is as high as the highest ground.
  const double share = relief.highest_m() < 0 ? relief.highest_m() / relief.lowest_m() : 0;
  first_range_m_ = std::max(nearest * share - step_m_, 0.5 * step_m_);
  const auto [first, width] = directions_of(area);
  // Coarser than asked for rather than without bound.
  for (;; step_m_ *= 2) {
    direction_step_rad_ = step_m_ / farthest;
    ranges_ = int(std::ceil((farthest - first_range_m_) / step_m_)) + 1;
    directions_ = int(std::ceil(width / direction_step_rad_)) + 3;
    if (double(ranges_) * directions_ <= kMaxFan) break;
  }
  first_direction_rad_ = first - direction_step_rad_;
  slopes_.resize(size_t(ranges_) * size_t(directions_));
  std::vector<double> east(static_cast<size_t>(directions_)), north(east.size());
  for (size_t j = 0; j < east.size(); ++j) {
    east[j] = std::cos(first_direction_rad_ + double(j) * direction_step_rad_);
    north[j] = std::sin(first_direction_rad_ + double(j) * direction_step_rad_);
  }
  for (int i = 0; i < ranges_; ++i) {
    const double range = first_range_m_ + i * step_m_;
    float* slopes = &slopes_[size_t(i) * east.size()];
    for (size_t j = 0; j < east.size(); ++j) {
      const float before = i > 0 ? *(slopes + j - east.size()) : -std::numeric_limits<float>::infinity();
      const float here = float(relief.known_height_m(range * east[j], range * north[j]) / range);
      slopes[j] = here > before ? here : before;
    }
  }
}

bool Horizon::hides(double east_m, double north_m, double height_m) const {
  const double range = std::hypot(east_m, north_m);
  // The ground right before the point is the point's own slope.
  const int i = std::min(int(std::floor((range - first_range_m_) / step_m_ - 0.5)), ranges_ - 1);
  if (i < 0) return false;
  double turn = std::atan2(north_m, east_m) - first_direction_rad_;
  turn -= 2 * kPi * std::floor(turn / (2 * kPi));
  const double j = std::min(turn / direction_step_rad_, directions_ - 2.0);
  const float* slopes = &slopes_[size_t(i) * size_t(directions_) + size_t(j)];
  const double share = j - std::floor(j);
  // Minus infinity where nothing is known; times 0 it would be no number.
  const double slope = share > 0 ? (1 - share) * slopes[0] + share * slopes[1] : slopes[0];
  return slope * range - height_m > 0.25 * step_m_;
}

Status ground_point(const Camera& camera, const Attitude& attitude, const Position& position,
                    const Eigen::Vector2d& pixel, const Terrain& terrain, GroundPoint& point,
                    double max_reach_heights) {
  for (double v : {attitude.roll, attitude.pitch, attitude.heading, position.east_m, position.north_m,
                   position.height_m, pixel.x(), pixel.y(), max_reach_heights})
    if (!std::isfinite(v)) return Status::kNotFinite;
  if (const Status s = check(camera); s != Status::kOk) return s;
  if (const Status s = check(terrain); s != Status::kOk) return s;
  try {
    const Relief relief(terrain, position);
    if (relief.plane_m() >= 0 || relief.height_m(0, 0) >= 0) return Status::kBelowGround;
    Eigen::Vector3d in_camera;
    if (!Lens(camera).ray_of(pixel, in_camera)) return Status::kNothingVisible;
    const Eigen::Vector3d ray = (enu_from_camera(attitude) * in_camera).normalized();
    // Along the ray, from where it comes down to the highest ground to where it is below the lowest.
    const double sideways = std::hypot(ray.x(), ray.y());
    const double reach = -relief.plane_m() * max_reach_heights / std::max(sideways, 1e-12);
    const double begin = ray.z() < 0 && relief.highest_m() < 0 ? relief.highest_m() / ray.z() : 0;
    const double end = ray.z() < 0 ? std::min(reach, relief.lowest_m() / ray.z() + 1e-6) : reach;
    if (begin > end) return Status::kNothingVisible;
    const auto below = [&](double t) { return t * ray.z() <= relief.height_m(t * ray.x(), t * ray.y()); };
    const double steps = relief.flat() ? 1 : std::ceil((end - begin) * sideways / (0.5 * relief.gsd_m())) + 1;
    double above_t = begin, below_t = begin;
    for (double i = 1; i <= steps && !below(below_t); ++i) {
      above_t = below_t;
      below_t = begin + (end - begin) * i / steps;
    }
    if (!below(below_t)) return Status::kNothingVisible;
    for (int i = 0; i < 50; ++i) (below(0.5 * (above_t + below_t)) ? below_t : above_t) = 0.5 * (above_t + below_t);
    const Eigen::Vector3d p = below_t * ray;
    const double known = relief.known_height_m(p.x(), p.y());
    point = {position.east_m + p.x(), position.north_m + p.y(), position.height_m + p.z(), known == known};
    return Status::kOk;
  } catch (...) {
    return Status::kInternal;
  }
}

}  // namespace landfix::nav
