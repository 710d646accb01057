// Where the simulated aircraft flies: straight legs joined by circular turns, by distance along the track.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace landfix::fly {

/// A place on a route.
struct RoutePoint {
  double east_m = 0, north_m = 0;
  double heading_rad = 0;  ///< of the track, clockwise from grid north
};

/// Immutable. Places beyond the end of a closed route continue from its start, those of an open one stay at its end.
class Route {
 public:
  /// Closed square with rounded corners, clockwise, of exactly this length around a centre; it starts in the middle of
  /// the western side, heading north. Turns of more than a circle of that length are made as wide as the circle.
  static Route loop(double east_m, double north_m, double length_m, double turn_radius_m);

  /// Closed racetrack (two straights along north, two half circles), clockwise, of exactly this length around a centre.
  static Route racetrack(double east_m, double north_m, double length_m, double turn_radius_m);

  /// Straight legs through these points (east, north), corners cut by turns of at most this radius (less where a leg is
  /// too short for it). Closed where first and last point coincide. Throws Error (kBadInput) for fewer than two
  /// different points.
  static Route through(const std::vector<Eigen::Vector2d>& points, double turn_radius_m);

  double length_m() const { return length_m_; }
  bool closed() const { return closed_; }
  RoutePoint at(double distance_m) const;

 private:
  /// A leg (curvature 0) or a turn (1 / radius, positive to the right).
  struct Piece {
    RoutePoint start;
    double length_m = 0;
    double curvature = 0;
    double start_distance_m = 0;
  };
  static RoutePoint along(const Piece& piece, double distance_m);
  void add(double length_m, double curvature);

  RoutePoint start_;
  std::vector<Piece> pieces_;
  double length_m_ = 0;
  bool closed_ = true;
};

}  // namespace landfix::fly
