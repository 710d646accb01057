// Camera, attitude and frames, as every user of a camera shares them (renderer, rectification, odometry).
//
// Frames: body forward-right-down; camera x right, y down, z forward along the optical axis; navigation north-east-down,
// where "north" is grid north here. A nadir camera is mounted so that the top of its image points forward.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace landfix::nav {

/// Pinhole camera without distortion. Pixel (0, 0) is the centre of the top left pixel.
struct Camera {
  int width = 640, height = 480;  ///< pixels
  double fx = 554.0, fy = 554.0;  ///< focal lengths in pixels
  double cx = 319.5, cy = 239.5;  ///< principal point in pixels
};

/// A camera of `width`×`height` pixels with this horizontal field of view, principal point in the middle.
inline Camera camera_from_field_of_view(int width, int height, double horizontal_fov_rad) {
  const double f = 0.5 * width / std::tan(0.5 * horizontal_fov_rad);
  return {width, height, f, f, 0.5 * (width - 1), 0.5 * (height - 1)};
}

/// Roll about forward, pitch (nose up), heading clockwise from grid north; radians.
struct Attitude {
  double roll = 0, pitch = 0, heading = 0;
};

/// Rotation that takes body coordinates (forward-right-down) to grid north-east-down.
inline Eigen::Matrix3d ned_from_body(const Attitude& a) {
  return (Eigen::AngleAxisd(a.heading, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(a.pitch, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(a.roll, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

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
