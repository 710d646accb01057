// Camera, attitude and frames, as every user of a camera shares them (renderer, rectification, odometry).
//
// Frames: body forward-right-down; camera x right, y down, z forward along the optical axis; navigation
// north-east-down, where "north" is grid north here. A nadir camera is mounted so that the top of its image points
// forward.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "runtime/nav/status.h"

namespace landfix::nav {

/// Lens distortion as OpenCV calibrates it (Brown-Conrady, rational with k4 to k6), in OpenCV's order. On the plane at
/// distance 1, (x, y) with r² = x² + y² is seen at x·c + 2 p1 x y + p2 (r² + 2x²), y·c + p1 (r² + 2y²) + 2 p2 x y,
/// where c = (1 + k1 r² + k2 r⁴ + k3 r⁶) / (1 + k4 r² + k5 r⁴ + k6 r⁶).
struct Distortion {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0, k4 = 0, k5 = 0, k6 = 0;
  bool none() const { return *this == Distortion{}; }
  friend bool operator==(const Distortion&, const Distortion&) = default;
};

/// Pixel (0, 0) is the centre of the top left pixel.
struct Camera {
  int width = 640, height = 480;  ///< pixels
  double fx = 554.0, fy = 554.0;  ///< focal lengths in pixels
  double cx = 319.5, cy = 239.5;  ///< principal point in pixels
  Distortion distortion{};
  cv::Mat mask{};  ///< CV_8UC1 of the camera's size, 0 where it sees its own airframe; empty: all of it sees the world
};

/// A camera of `width`×`height` pixels with this horizontal field of view, principal point in the middle.
inline Camera camera_from_field_of_view(int width, int height, double horizontal_fov_rad) {
  const double f = 0.5 * width / std::tan(0.5 * horizontal_fov_rad);
  return {width, height, f, f, 0.5 * (width - 1), 0.5 * (height - 1)};
}

/// kNotFinite, kBadValue (size or focal length not positive) or kBadImage (mask of another size or type).
Status check(const Camera& camera);

/// The camera as it sees an image shrunk by a whole factor (area mean), without its mask.
Camera shrunk(const Camera& camera, int factor);

/// Between rays and pixels, through the distortion. Polynomials of a calibration turn back somewhere outside of the
/// image that they were fitted to; beyond that fold nothing is seen, so that no false pixels come from there.
class Lens {
 public:
  explicit Lens(const Camera& camera);

  /// Pixel that sees a ray (camera frame, any length); false behind the camera or beyond the fold. The pixel may lie
  /// outside of the image. In front of the camera `pixel` is set in any case.
  bool pixel_of(const Eigen::Vector3d& ray, Eigen::Vector2d& pixel) const {
    if (!(ray.z() > 0)) return false;
    const Eigen::Vector2d ideal(ray.x() / ray.z(), ray.y() / ray.z());
    const Eigen::Vector2d seen = distorted_ ? distort(ideal) : ideal;
    pixel = {cx_ + fx_ * seen.x(), cy_ + fy_ * seen.y()};
    return ideal.squaredNorm() < fold2_;
  }

  /// Ray (camera frame, z = 1) that a pixel sees, found by Newton's method; false where it does not converge: no ray
  /// inside the fold meets that pixel.
  bool ray_of(const Eigen::Vector2d& pixel, Eigen::Vector3d& ray) const;

  /// Ideal radius, on the plane at distance 1, where the distortion turns back; infinite where it never does.
  double fold_radius() const;

  bool distorted() const { return distorted_; }

 private:
  Eigen::Vector2d distort(const Eigen::Vector2d& ideal) const;
  /// Derivative of `distort`; nothing where the model is not one-to-one.
  bool jacobian(const Eigen::Vector2d& ideal, Eigen::Matrix2d& j) const;
  double fold_along(double direction_rad) const;

  double fx_, fy_, cx_, cy_;
  Distortion d_;
  bool distorted_;
  double fold2_;
};

/// Roll about forward, pitch (nose up), heading clockwise from grid north; radians.
struct Attitude {
  double roll = 0, pitch = 0, heading = 0;
};

/// Rotation that takes body coordinates (forward-right-down) to grid north-east-down.
inline Eigen::Matrix3d ned_from_body(const Attitude& a) {
  return (Eigen::AngleAxisd(a.heading, Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(a.pitch, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(a.roll, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

/// Inverse of ned_from_body: pitch in −π/2 to π/2, roll and heading in −π to π. At a pitch of ±π/2 only the sum or
/// difference of roll and heading is defined; the roll is 0 then.
Attitude attitude_from(const Eigen::Matrix3d& ned_from_body);

/// Rotation of a nadir mount: camera z is body down, camera x is body right, camera y is body backward.
inline Eigen::Matrix3d body_from_nadir_camera() {
  Eigen::Matrix3d r;
  r << 0, -1, 0,  // forward = -y
      1, 0, 0,    // right = x
      0, 0, 1;    // down = z
  return r;
}

/// Axes of grid east-north-up in terms of north-east-down.
inline Eigen::Matrix3d enu_from_ned() {
  Eigen::Matrix3d r;
  r << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  return r;
}

/// Rotation that takes camera coordinates to grid east-north-up, for a nadir mount.
inline Eigen::Matrix3d enu_from_camera(const Attitude& a) {
  return enu_from_ned() * ned_from_body(a) * body_from_nadir_camera();
}

}  // namespace landfix::nav
