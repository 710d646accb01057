#include "runtime/nav/rectify.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace landfix::nav {
namespace {

/// Ground rectangle around the footprint, relative to the camera's ground position.
struct Bounds {
  double west, east, south, north;
};

Status check(const Camera& camera, const Attitude& attitude, double height_m) {
  for (double v :
       {camera.fx, camera.fy, camera.cx, camera.cy, attitude.roll, attitude.pitch, attitude.heading, height_m})
    if (!std::isfinite(v)) return Status::kNotFinite;
  if (camera.fx <= 0 || camera.fy <= 0 || camera.width <= 0 || camera.height <= 0) return Status::kBadValue;
  return height_m > 0 ? Status::kOk : Status::kBelowGround;
}

/// Around the four corners if all of them see near ground, otherwise all that is within reach.
Bounds footprint_bounds(const Camera& camera, const Eigen::Matrix3d& enu_from_cam, double height_m, double reach_m) {
  Bounds b{reach_m, -reach_m, reach_m, -reach_m};
  for (double x : {-0.5, camera.width - 0.5}) {
    for (double y : {-0.5, camera.height - 0.5}) {
      const Eigen::Vector3d ray =
          enu_from_cam * Eigen::Vector3d((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1);
      const double east = ray.x() * height_m / -ray.z(), north = ray.y() * height_m / -ray.z();
      if (!(ray.z() < 0) || std::hypot(east, north) > reach_m) return {-reach_m, reach_m, -reach_m, reach_m};
      b = {std::min(b.west, east), std::max(b.east, east), std::min(b.south, north), std::max(b.north, north)};
    }
  }
  return b;
}

/// Homogeneous image coordinates of the point (column, row) of a grid of `step_m` whose top left corner is given: the
/// homography of the ground plane.
Eigen::Matrix3d image_from_grid(const Camera& camera, const Eigen::Matrix3d& enu_from_cam, double height_m,
                                double west_m, double north_m, double step_m) {
  Eigen::Matrix3d intrinsics, ground_from_grid;
  intrinsics << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  ground_from_grid << step_m, 0, west_m + 0.5 * step_m, 0, -step_m, north_m - 0.5 * step_m, 0, 0, -height_m;
  return intrinsics * enu_from_cam.transpose() * ground_from_grid;
}

/// Marks the pixels whose centre, with room for half a pixel's diagonal, is seen by the camera and within reach.
void mark_footprint(const Camera& camera, const Eigen::Matrix3d& h, double margin_px, double reach_m,
                    features::GridImage& patch) {
  const double right = camera.width - 0.5 - margin_px, bottom = camera.height - 0.5 - margin_px, edge = margin_px - 0.5;
  for (int row = 0; row < patch.pixels.rows; ++row) {
    uint8_t* valid = patch.valid.ptr<uint8_t>(row);
    const double north = patch.north_m - (row + 0.5) * patch.gsd_m;
    for (int column = 0; column < patch.pixels.cols; ++column) {
      const Eigen::Vector3d p = h * Eigen::Vector3d(column, row, 1);
      const double east = patch.west_m + (column + 0.5) * patch.gsd_m, x = p.x() / p.z(), y = p.y() / p.z();
      const bool seen = p.z() > 0 && x >= edge && x <= right && y >= edge && y <= bottom;
      valid[column] = seen && east * east + north * north <= reach_m * reach_m ? 255 : 0;
    }
  }
}

/// Means over the ground squares of the patch, by sampling each in k×k points. An image far finer than the patch is
/// first shrunk by a whole factor, so that two to four samples per side suffice.
void sample_image(const cv::Mat& image, Camera camera, const Eigen::Matrix3d& enu_from_cam, double height_m,
                  features::GridImage& patch) {
  double scale = patch.gsd_m * std::max(camera.fx, camera.fy) / height_m;  // image pixels per patch pixel
  cv::Mat source = image;
  if (const int shrink = std::min({int(scale / 2), image.cols, image.rows}); shrink >= 2) {
    const cv::Size size(image.cols / shrink, image.rows / shrink);
    cv::resize(image(cv::Rect(0, 0, size.width * shrink, size.height * shrink)), source, size, 0, 0, cv::INTER_AREA);
    camera = {size.width,
              size.height,
              camera.fx / shrink,
              camera.fy / shrink,
              (camera.cx + 0.5) / shrink - 0.5,
              (camera.cy + 0.5) / shrink - 0.5};
    scale /= shrink;
  }
  const int k = std::clamp(int(std::ceil(scale - 0.01)), 1, 4);
  const Eigen::Matrix3d h =
      image_from_grid(camera, enu_from_cam, height_m, patch.west_m, patch.north_m, patch.gsd_m / k);
  const cv::Matx33d map(h(0, 0), h(0, 1), h(0, 2), h(1, 0), h(1, 1), h(1, 2), h(2, 0), h(2, 1), h(2, 2));
  const int flags = cv::INTER_LINEAR | cv::WARP_INVERSE_MAP;
  if (k == 1) return cv::warpPerspective(source, patch.pixels, map, patch.pixels.size(), flags, cv::BORDER_REPLICATE);
  cv::Mat fine;
  cv::warpPerspective(source, fine, map, patch.pixels.size() * k, flags, cv::BORDER_REPLICATE);
  cv::resize(fine, patch.pixels, patch.pixels.size(), 0, 0, cv::INTER_AREA);
}

Status rectify_checked(const cv::Mat& image, const Camera& camera, const Attitude& attitude, double height_m,
                       double gsd_m, features::GridImage& patch, const RectifyOptions& options) {
  const Eigen::Matrix3d enu_from_cam = enu_from_camera(attitude);
  const double reach_m = options.max_reach_heights * height_m;
  const Bounds b = footprint_bounds(camera, enu_from_cam, height_m, reach_m);
  const double west = std::floor(b.west / gsd_m), north = std::ceil(b.north / gsd_m);
  const double columns = std::ceil(b.east / gsd_m) - west, rows = north - std::floor(b.south / gsd_m);
  if (!(columns * rows <= double(options.max_pixels))) return Status::kTooLarge;
  patch.west_m = west * gsd_m;
  patch.north_m = north * gsd_m;
  patch.gsd_m = gsd_m;
  patch.pixels.create(int(rows), int(columns), CV_8UC1);
  patch.valid.create(int(rows), int(columns), CV_8UC1);

  const Eigen::Matrix3d h = image_from_grid(camera, enu_from_cam, height_m, patch.west_m, patch.north_m, gsd_m);
  const double half_diagonal_px = std::sqrt(0.5) * gsd_m * std::max(camera.fx, camera.fy) / height_m;
  mark_footprint(camera, h, half_diagonal_px, reach_m, patch);
  const cv::Rect seen = cv::boundingRect(patch.valid);
  if (seen.empty()) return Status::kNothingVisible;
  if (seen.size() != patch.valid.size()) {
    patch.valid = patch.valid(seen).clone();
    patch.pixels.create(seen.size(), CV_8UC1);
    patch.west_m = (west + seen.x) * gsd_m;
    patch.north_m = (north - seen.y) * gsd_m;
  }
  sample_image(image, camera, enu_from_cam, height_m, patch);
  return Status::kOk;
}

}  // namespace

Status rectify(const cv::Mat& gray_image, const Camera& camera, const Attitude& attitude, double height_above_ground_m,
               double gsd_m, features::GridImage& patch, const RectifyOptions& options) {
  if (gray_image.empty() || gray_image.type() != CV_8UC1 || gray_image.cols != camera.width ||
      gray_image.rows != camera.height)
    return Status::kBadImage;
  if (const Status status = check(camera, attitude, height_above_ground_m); status != Status::kOk) return status;
  if (!std::isfinite(gsd_m)) return Status::kNotFinite;
  if (gsd_m <= 0) return Status::kBadValue;
  try {
    return rectify_checked(gray_image, camera, attitude, height_above_ground_m, gsd_m, patch, options);
  } catch (...) {
    return Status::kInternal;
  }
}

Status footprint_reach(const Camera& camera, const Attitude& attitude, double height_above_ground_m,
                       cv::Point2d& reach_m, const RectifyOptions& options) {
  if (const Status status = check(camera, attitude, height_above_ground_m); status != Status::kOk) return status;
  const Bounds b = footprint_bounds(camera, enu_from_camera(attitude), height_above_ground_m,
                                    options.max_reach_heights * height_above_ground_m);
  reach_m = {std::max(-b.west, b.east), std::max(-b.south, b.north)};
  return Status::kOk;
}

}  // namespace landfix::nav
