// The ground as a camera meets it: heights where they are known, a plane elsewhere; what hides what, and where a ray
// ends.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "runtime/features/grid_image.h"
#include "runtime/nav/camera.h"
#include "runtime/nav/status.h"

namespace landfix::nav {

/// Where a camera stands: on the grid, height in the heights' own datum (metres above the ellipsoid in a pack).
struct Position {
  double east_m = 0, north_m = 0, height_m = 0;
};

/// What is known of the ground.
struct Terrain {
  features::GridImage heights;  ///< CV_32FC1, metres; unknown where NaN or not `valid`; empty: the plane alone
  double plane_height_m = 0;    ///< of the ground where `heights` knows none
};

/// kBadImage (heights not CV_32FC1, or `valid` of another size), kNotFinite, kBadValue (GSD not positive).
Status check(const Terrain& terrain);

/// Terrain made ready for many questions; positions are relative to an origin, so that nothing is lost where
/// coordinates are large.
class Relief {
 public:
  /// `terrain` must have passed `check`.
  Relief(const Terrain& terrain, const Position& origin);

  /// Ground height above the origin's height (negative below a camera), bilinear between the centres of four known
  /// heights; NaN where one of them is not known.
  double known_height_m(double east_m, double north_m) const;
  /// The same with the plane for what is not known.
  double height_m(double east_m, double north_m) const {
    const double known = known_height_m(east_m, north_m);
    return known == known ? known : plane_m_;
  }
  double plane_m() const { return plane_m_; }
  double lowest_m() const { return lowest_m_; }    ///< of heights and plane
  double highest_m() const { return highest_m_; }  ///< of heights and plane
  double steepest() const { return steepest_; }    ///< largest slope between neighbours; infinite at unknown heights
  bool flat() const { return heights_.empty(); }
  double gsd_m() const { return gsd_m_; }

 private:
  void measure_slopes();

  cv::Mat_<float> heights_;  ///< above the origin's height, NaN where unknown
  double west_m_, north_m_, gsd_m_, plane_m_;
  double lowest_m_, highest_m_, steepest_ = 0;
};

/// Which ground the camera at the origin cannot see because nearer ground stands before it: the highest line of sight
/// up to every range, in a fan of directions around the area asked about. Assumed heights (the plane) hide nothing.
class Horizon {
 public:
  /// `area` (east, north, relative to the camera) is what will be asked about; `step_m` what is resolved.
  Horizon(const Relief& relief, const cv::Rect2d& area, double step_m);

  /// Whether known ground nearer to the camera rises into the line of sight to this point by more than a quarter step.
  bool hides(double east_m, double north_m, double height_m) const;

 private:
  double step_m_, first_range_m_ = 0, first_direction_rad_ = 0, direction_step_rad_ = 0;
  int ranges_ = 0, directions_ = 0;
  std::vector<float> slopes_;  ///< [range][direction]: steepest line (height over range) up to that range
};

/// Where the ray of a pixel meets the ground.
struct GroundPoint {
  double east_m = 0, north_m = 0, height_m = 0;
  bool known = false;  ///< by heights; otherwise by the plane
};

/// The first point of the ground on the ray of `pixel` (it may lie outside of the image: x −0.5, y −0.5 is the image's
/// top left corner), to a hundredth of the heights' GSD. Errors: as `check`, kBelowGround (camera not above plane or
/// ground), kNothingVisible (sky, beyond `max_reach_heights` heights above the plane, or no ray: beyond the lens's
/// fold).
Status ground_point(const Camera& camera, const Attitude& attitude, const Position& position,
                    const Eigen::Vector2d& pixel, const Terrain& terrain, GroundPoint& point,
                    double max_reach_heights = 3);

}  // namespace landfix::nav
