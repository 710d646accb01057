#include "tools/fly/route.h"

#include <algorithm>
#include <cmath>

#include "builder/error.h"

namespace landfix::fly {
namespace {

/// A turn takes at most this share of each leg it joins.
constexpr double kLargestCut = 0.49;

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2 * M_PI); }

std::vector<Eigen::Vector2d> without_repeats(const std::vector<Eigen::Vector2d>& points) {
  std::vector<Eigen::Vector2d> kept;
  for (const auto& point : points) {
    if (kept.empty() || (point - kept.back()).norm() > 1e-3) kept.push_back(point);
  }
  return kept;
}

}  // namespace

RoutePoint Route::along(const Piece& piece, double distance_m) {
  const double heading = piece.start.heading_rad, turn = piece.curvature * distance_m;
  if (piece.curvature == 0) {
    return {piece.start.east_m + distance_m * std::sin(heading), piece.start.north_m + distance_m * std::cos(heading),
            heading};
  }
  const double radius = 1 / piece.curvature;
  return {piece.start.east_m + radius * (std::cos(heading) - std::cos(heading + turn)),
          piece.start.north_m + radius * (std::sin(heading + turn) - std::sin(heading)), wrapped(heading + turn)};
}

void Route::add(double length_m, double curvature) {
  if (length_m <= 0) return;
  const RoutePoint start = pieces_.empty() ? start_ : along(pieces_.back(), pieces_.back().length_m);
  pieces_.push_back({start, length_m, curvature, length_m_});
  length_m_ += length_m;
}

Route Route::loop(double east_m, double north_m, double length_m, double turn_radius_m) {
  const double radius = std::min(turn_radius_m, length_m / (2 * M_PI));
  const double side = (length_m - 2 * M_PI * radius) / 4;
  Route route;
  route.start_ = {east_m - side / 2 - radius, north_m, 0};
  route.add(side / 2, 0);
  for (int corner = 0; corner < 4; ++corner) {
    route.add(M_PI / 2 * radius, 1 / radius);
    route.add(corner < 3 ? side : side / 2, 0);
  }
  return route;
}

Route Route::racetrack(double east_m, double north_m, double length_m, double turn_radius_m) {
  const double radius = std::min(turn_radius_m, length_m / (2 * M_PI));
  const double side = (length_m - 2 * M_PI * radius) / 2;
  Route route;
  route.start_ = {east_m - radius, north_m - side / 2, 0};
  for (int end = 0; end < 2; ++end) {
    route.add(side, 0);
    route.add(M_PI * radius, 1 / radius);
  }
  return route;
}

Route Route::through(const std::vector<Eigen::Vector2d>& given, double turn_radius_m) {
  std::vector<Eigen::Vector2d> points = without_repeats(given);
  if (points.size() < 2) throw Error(ExitCode::kBadInput, "route: expected at least two different points");
  Route route;
  route.closed_ = points.size() > 3 && (points.front() - points.back()).norm() < 1.0;
  if (route.closed_) {
    // Start in the middle of the first leg, so that the corner at the first point is turned like the others.
    points.pop_back();
    const Eigen::Vector2d middle = 0.5 * (points[0] + points[1]);
    std::rotate(points.begin(), points.begin() + 1, points.end());
    points.insert(points.begin(), middle);
    points.push_back(middle);
  }
  const auto heading = [&](size_t leg) {
    const Eigen::Vector2d d = points[leg + 1] - points[leg];
    return std::atan2(d.x(), d.y());
  };
  route.start_ = {points[0].x(), points[0].y(), heading(0)};
  double cut = 0;  // of the leg's start, taken by the turn before it
  for (size_t leg = 0; leg + 1 < points.size(); ++leg) {
    const double length = (points[leg + 1] - points[leg]).norm();
    if (leg + 2 == points.size()) {
      route.add(length - cut, 0);
      break;
    }
    const double turn = wrapped(heading(leg + 1) - heading(leg));
    const double tangent = std::tan(std::min(std::abs(turn), 0.99 * M_PI) / 2);
    const double next_length = (points[leg + 2] - points[leg + 1]).norm();
    const double radius =
        std::min(turn_radius_m, kLargestCut * std::min(length, next_length) / std::max(tangent, 1e-9));
    const double cut_here = std::abs(turn) < 1e-6 ? 0 : radius * tangent;
    route.add(length - cut - cut_here, 0);
    if (cut_here > 0) route.add(std::abs(turn) * radius, std::copysign(1 / radius, turn));
    cut = cut_here;
  }
  return route;
}

RoutePoint Route::at(double distance_m) const {
  const double on_route =
      closed_ ? distance_m - length_m_ * std::floor(distance_m / length_m_) : std::clamp(distance_m, 0.0, length_m_);
  const auto after = std::upper_bound(pieces_.begin() + 1, pieces_.end(), on_route,
                                      [](double d, const Piece& piece) { return d < piece.start_distance_m; });
  const Piece& piece = *(after - 1);
  return along(piece, on_route - piece.start_distance_m);
}

}  // namespace landfix::fly
