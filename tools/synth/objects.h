// What stands and lies in the world. The same objects are drawn into image and heights and written as truth labels.
// Coordinates are grid easting (x) and northing (y) in metres.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <string_view>
#include <vector>

namespace landfix::synth {

using Point = cv::Point2d;
using Outline = std::vector<Point>;  ///< closed polygon, counter-clockwise, first point not repeated

/// A rectangle of the grid in metres.
struct Rectangle {
  double west_m = 0, south_m = 0, east_m = 0, north_m = 0;

  bool contains(Point p) const { return p.x >= west_m && p.x < east_m && p.y >= south_m && p.y < north_m; }
  Rectangle grown(double by_m) const { return {west_m - by_m, south_m - by_m, east_m + by_m, north_m + by_m}; }
  bool touches(const Rectangle& o) const {
    return west_m < o.east_m && o.west_m < east_m && south_m < o.north_m && o.south_m < north_m;
  }
};

Rectangle bounds_of(std::span<const Point> points);

enum class Crop { kWheat, kRapeseed, kBarley, kMaize, kBeet, kSunflower, kAlfalfa, kPotato, kFallow, kGrass, kOrchard };
enum class RoadKind { kTrack, kStreet, kMinor, kMain };
enum class Roof { kFlat, kGabled };

std::string_view name_of(Crop crop);
std::string_view name_of(RoadKind kind);
std::string_view name_of(Roof roof);

/// A rectangle `length_m` × `width_m` about `centre`, its long side along the unit vector `axis`; with a wing (L shape)
/// at the end of one long side if `wing_length_m` > 0.
struct Building {
  Point centre;
  Point axis = {1, 0};
  double length_m = 0, width_m = 0;
  double wing_length_m = 0, wing_width_m = 0;
  double eave_m = 0;    ///< above the ground at `centre`
  double height_m = 0;  ///< of the ridge; equal to `eave_m` under a flat roof
  double base_m = 0;    ///< ellipsoidal height of the ground at `centre`
  Roof roof = Roof::kGabled;
  uint64_t key = 0;

  Outline outline() const;
  double reach_m() const;  ///< no point of the building is farther from `centre`
  /// Coordinates along and across the axis.
  Point local(Point grid) const { return {axis.dot(grid - centre), axis.cross(grid - centre)}; }
  /// Distance of a local point to the walls, negative inside; at corners the larger of the two axes' distances.
  double outside_m(Point local) const;
  /// Height of the roof above `base_m`, and its slope along (x) and across (y) the axis.
  double roof_m(Point local, Point* slope = nullptr) const;
};

struct Tree {
  Point position;
  double radius_m = 0, height_m = 0;
  double base_m = 0;  ///< ellipsoidal height of the ground at `position`
  bool conifer = false;
  uint64_t key = 0;
};

struct Road {
  std::vector<Point> line;
  double width_m = 0;
  RoadKind kind = RoadKind::kTrack;
  double shoulder_m = 0, median_m = 0;  ///< of the width: paved strips outside of the edge lines, grass in the middle
  bool yellow = false;                  ///< its middle line
};

struct Intersection {
  Point position;
  int degree = 0;  ///< roads that leave it
};

struct Field {
  Outline outline;
  Crop crop = Crop::kWheat;
};

/// A star-shaped lake: radius R(θ) = mean (1 + Σ a_k cos((k + 2) θ + φ_k)).
struct Lake {
  Point centre;
  double mean_radius_m = 0;
  std::array<double, 5> amplitude{}, phase{};
  double level_m = 0;  ///< ellipsoidal height of the water

  double radius_m(double theta_rad) const;
  double largest_radius_m() const;
  /// About the distance to the shore, negative on the water.
  double shore_distance_m(Point p) const;
  Outline outline() const;
};

}  // namespace landfix::synth
