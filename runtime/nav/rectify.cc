#include "runtime/nav/rectify.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace landfix::nav {
namespace {

constexpr int kRimSamples = 16;  ///< points of each side of the image that bound a distorted footprint
constexpr int kBandRows = 32;    ///< patch rows sampled together: what they need stays in the cache
constexpr double kLeastClearance =
    0.1;  ///< peaks nearer to the camera than this share of its height are sampled coarsely

/// Ground rectangle around the footprint, relative to the camera's ground position.
struct Bounds {
  double west, east, south, north;
  void add(double e, double n) {
    west = std::min(west, e), east = std::max(east, e);
    south = std::min(south, n), north = std::max(north, n);
  }
};

/// A camera over the ground, as all steps need it. Heights are relative to the camera: below it negative.
struct View {
  View(const Camera& c, const Attitude& attitude, const Relief& r, double max_reach_heights)
      : camera(c),
        lens(c),
        enu_from_cam(enu_from_camera(attitude)),
        relief(r),
        reach_m(-r.plane_m() * max_reach_heights) {}

  const Camera& camera;
  Lens lens;
  Eigen::Matrix3d enu_from_cam;
  const Relief& relief;
  double reach_m;
};

Status check_pose(const Camera& camera, const Attitude& attitude, double height_m) {
  for (double v : {attitude.roll, attitude.pitch, attitude.heading, height_m})
    if (!std::isfinite(v)) return Status::kNotFinite;
  if (const Status s = check(camera); s != Status::kOk) return s;
  return height_m > 0 ? Status::kOk : Status::kBelowGround;
}

/// Rays along the rim of what the camera sees: the corners, and points between them where the lens bends its sides.
/// Where no ray meets the rim, the lens's fold is the limit.
std::vector<Eigen::Vector3d> rim(const Camera& camera, const Lens& lens) {
  std::vector<Eigen::Vector3d> rays;
  const int n = lens.distorted() ? kRimSamples : 1;
  const double left = -0.5, right = camera.width - 0.5, top = -0.5, bottom = camera.height - 0.5;
  for (int i = 0; i <= n; ++i) {
    const double x = left + (right - left) * i / n, y = top + (bottom - top) * i / n;
    for (const Eigen::Vector2d& pixel :
         {Eigen::Vector2d(x, top), Eigen::Vector2d(x, bottom), Eigen::Vector2d(left, y), Eigen::Vector2d(right, y)}) {
      Eigen::Vector3d ray;
      if (!lens.ray_of(pixel, ray)) {
        const Eigen::Vector2d outward((pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy);
        ray << outward.normalized() * lens.fold_radius(), 1;
      }
      rays.push_back(ray);
    }
  }
  return rays;
}

/// Around where the rim's rays meet the lowest and the highest ground if all do within reach, otherwise all within
/// reach.
Bounds footprint_bounds(const View& view) {
  const double reach = view.reach_m;
  Bounds b{reach, -reach, reach, -reach};
  for (const Eigen::Vector3d& in_camera : rim(view.camera, view.lens)) {
    const Eigen::Vector3d ray = view.enu_from_cam * in_camera;
    for (double height : {view.relief.lowest_m(), std::min(view.relief.highest_m(), 0.0)}) {
      const double east = ray.x() * height / ray.z(), north = ray.y() * height / ray.z();
      if (!(ray.z() < 0 && std::isfinite(east + north)) || std::hypot(east, north) > reach)
        return {-reach, reach, -reach, reach};
      b.add(east, north);
    }
  }
  return b;
}

/// Where the patch's pixels lie in the image.
struct Projection {
  cv::Mat_<cv::Vec2f> map;  ///< image coordinates of the pixel centres, with one more row and column on every side
  cv::Mat_<float> heights;  ///< known ground heights of the patch pixels, relative to the camera; NaN where unknown
  double above_m = 0;       ///< mean height of the camera above the valid pixels' ground
};

/// Fills the map and marks the pixels whose centre, with room for half a pixel's diagonal, is seen by the camera and
/// within reach.
void project(const View& view, features::GridImage& patch, Projection& p) {
  const Camera& camera = view.camera;
  const double clearance_m = std::max(-view.relief.highest_m(), -kLeastClearance * view.relief.plane_m());
  const double margin_px = std::sqrt(0.5) * patch.gsd_m * std::max(camera.fx, camera.fy) / clearance_m;
  const double right = camera.width - 0.5 - margin_px, bottom = camera.height - 0.5 - margin_px, edge = margin_px - 0.5;
  const Eigen::Matrix3d cam_from_enu = view.enu_from_cam.transpose();
  const int rows = patch.valid.rows, columns = patch.valid.cols;
  p.map.create(rows + 2, columns + 2);
  p.heights.create(rows, columns);
  double above_sum_m = 0;
  int64_t count = 0;
  for (int row = -1; row <= rows; ++row) {
    cv::Vec2f* map = p.map[row + 1];
    const double north = patch.north_m - (row + 0.5) * patch.gsd_m;
    for (int column = -1; column <= columns; ++column) {
      const double east = patch.west_m + (column + 0.5) * patch.gsd_m;
      const double known = view.relief.known_height_m(east, north);
      const double height = known == known ? known : view.relief.plane_m();
      Eigen::Vector2d pixel(-1, -1);
      const bool seen = view.lens.pixel_of(cam_from_enu * Eigen::Vector3d(east, north, height), pixel);
      map[column + 1] = {float(pixel.x()), float(pixel.y())};
      if (row < 0 || row == rows || column < 0 || column == columns) continue;
      const bool inside = seen && pixel.x() >= edge && pixel.x() <= right && pixel.y() >= edge && pixel.y() <= bottom &&
                          east * east + north * north <= view.reach_m * view.reach_m;
      patch.valid.at<uint8_t>(row, column) = inside ? 255 : 0;
      p.heights(row, column) = float(known);
      if (inside) above_sum_m -= height, ++count;
    }
  }
  p.above_m = count ? std::max(above_sum_m / double(count), clearance_m) : clearance_m;
}

/// Makes the pixels invalid that nearer ground hides. Returns how many.
int hide(const View& view, const Projection& p, features::GridImage& patch) {
  const double width_m = patch.valid.cols * patch.gsd_m, height_m = patch.valid.rows * patch.gsd_m;
  const cv::Rect2d area(patch.west_m, patch.north_m - height_m, width_m, height_m);
  const double farthest_m = std::hypot(std::max(std::abs(area.x), std::abs(area.x + area.width)),
                                       std::max(std::abs(area.y), std::abs(area.y + area.height)));
  // Nothing is hidden where no slope is as steep as the flattest ray.
  if (view.relief.steepest() * farthest_m <= -view.relief.highest_m()) return 0;
  const Horizon horizon(view.relief, area, std::max(patch.gsd_m, view.relief.gsd_m()));
  int hidden = 0;
  for (int row = 0; row < patch.valid.rows; ++row) {
    uint8_t* valid = patch.valid.ptr<uint8_t>(row);
    const double north = patch.north_m - (row + 0.5) * patch.gsd_m;
    for (int column = 0; column < patch.valid.cols; ++column) {
      const float height = p.heights(row, column);
      if (!valid[column] || height != height) continue;
      const double east = patch.west_m + (column + 0.5) * patch.gsd_m;
      if (!horizon.hides(east, north, height)) continue;
      valid[column] = 0;
      ++hidden;
    }
  }
  return hidden;
}

/// By how much the image is shrunk before it is sampled in k×k points per patch pixel: by a whole factor, so that two
/// to four samples per side suffice.
struct Sampling {
  Sampling(const Camera& camera, double gsd_m, double above_m) {
    double scale = gsd_m * std::max(camera.fx, camera.fy) / above_m;  // image pixels per patch pixel
    shrink = std::max(std::min({int(scale / 2), camera.width, camera.height}), 1);
    scale /= shrink;
    k = std::clamp(int(std::ceil(scale - 0.01)), 1, 4);
  }
  int shrink, k;
};

cv::Mat shrink_image(const cv::Mat& image, int factor) {
  if (factor == 1) return image;
  const cv::Size size(image.cols / factor, image.rows / factor);
  cv::Mat small;
  cv::resize(image(cv::Rect(0, 0, size.width * factor, size.height * factor)), small, size, 0, 0, cv::INTER_AREA);
  return small;
}

/// Takes away the pixels that touch the masked part of the image.
void apply_mask(const Camera& camera, const Projection& p, double gsd_m, cv::Mat& valid) {
  if (camera.mask.empty()) return;
  const Sampling s(camera, gsd_m, p.above_m);
  cv::Mat world = shrink_image(camera.mask != 0, s.shrink) == 255;
  // Half the diagonal of a patch pixel, and the neighbour that an interpolation takes in.
  const int radius = int(std::ceil(std::sqrt(0.5) * s.k + 0.5));
  cv::erode(world, world, cv::getStructuringElement(cv::MORPH_RECT, {2 * radius + 1, 2 * radius + 1}));
  for (int row = 0; row < valid.rows; ++row) {
    uint8_t* out = valid.ptr<uint8_t>(row);
    for (int column = 0; column < valid.cols; ++column) {
      if (!out[column]) continue;
      const cv::Vec2f& at = p.map(row + 1, column + 1);
      const int x = std::clamp(int(std::lround((at[0] + 0.5) / s.shrink - 0.5)), 0, world.cols - 1);
      const int y = std::clamp(int(std::lround((at[1] + 0.5) / s.shrink - 0.5)), 0, world.rows - 1);
      out[column] &= world.at<uint8_t>(y, x);
    }
  }
}

/// Samples a plane through a lens without distortion: a homography.
void sample_plane(const cv::Mat& image, const View& view, features::GridImage& patch) {
  const double height_m = -view.relief.plane_m();
  const Sampling s(view.camera, patch.gsd_m, height_m);
  const Camera camera = shrunk(view.camera, s.shrink);
  const double step = patch.gsd_m / s.k;
  Eigen::Matrix3d intrinsics, ground_from_grid;
  intrinsics << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  ground_from_grid << step, 0, patch.west_m + 0.5 * step, 0, -step, patch.north_m - 0.5 * step, 0, 0, -height_m;
  const Eigen::Matrix3d h = intrinsics * view.enu_from_cam.transpose() * ground_from_grid;
  const cv::Matx33d map(h(0, 0), h(0, 1), h(0, 2), h(1, 0), h(1, 1), h(1, 2), h(2, 0), h(2, 1), h(2, 2));
  const int flags = cv::INTER_LINEAR | cv::WARP_INVERSE_MAP;
  const cv::Mat source = shrink_image(image, s.shrink);
  if (s.k == 1) return cv::warpPerspective(source, patch.pixels, map, patch.pixels.size(), flags, cv::BORDER_REPLICATE);
  cv::Mat fine;
  cv::warpPerspective(source, fine, map, patch.pixels.size() * s.k, flags, cv::BORDER_REPLICATE);
  cv::resize(fine, patch.pixels, patch.pixels.size(), 0, 0, cv::INTER_AREA);
}

/// Samples where the projection says; between pixel centres the map is straight.
void sample_map(const cv::Mat& image, const Camera& camera, const Projection& p, features::GridImage& patch) {
  const Sampling s(camera, patch.gsd_m, p.above_m);
  const cv::Mat source = shrink_image(image, s.shrink);
  cv::Mat map, fine_map, fine;
  for (int row = 0; row < patch.pixels.rows; row += kBandRows) {
    const int rows = std::min(kBandRows, patch.pixels.rows - row);
    cv::Mat out = patch.pixels.rowRange(row, row + rows);
    p.map.rowRange(row, row + rows + 2).convertTo(map, CV_32F, 1.0 / s.shrink, 0.5 / s.shrink - 0.5);
    cv::resize(map, fine_map, {}, s.k, s.k, cv::INTER_LINEAR);
    const cv::Mat inner = fine_map(cv::Rect(s.k, s.k, out.cols * s.k, rows * s.k));
    cv::remap(source, fine, inner, {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    cv::resize(fine, out, out.size(), 0, 0, cv::INTER_AREA);
  }
}

Status rectify_view(const cv::Mat& image, const View& view, double gsd_m, features::GridImage& patch, TerrainUse& use,
                    const RectifyOptions& options) {
  const Bounds b = footprint_bounds(view);
  const double west = std::floor(b.west / gsd_m), north = std::ceil(b.north / gsd_m);
  const double columns = std::ceil(b.east / gsd_m) - west, rows = north - std::floor(b.south / gsd_m);
  if (!(columns * rows <= double(options.max_pixels))) return Status::kTooLarge;
  if (!(columns >= 1 && rows >= 1)) return Status::kNothingVisible;
  patch.west_m = west * gsd_m;
  patch.north_m = north * gsd_m;
  patch.gsd_m = gsd_m;
  patch.valid.create(int(rows), int(columns), CV_8UC1);

  Projection p;
  project(view, patch, p);
  const int in_image = cv::countNonZero(patch.valid);
  if (!view.relief.flat() && in_image) use.hidden = double(hide(view, p, patch)) / in_image;
  apply_mask(view.camera, p, gsd_m, patch.valid);
  const cv::Rect seen = cv::boundingRect(patch.valid);
  if (seen.empty()) return Status::kNothingVisible;
  use.known = double(cv::countNonZero((p.heights == p.heights) & patch.valid)) / cv::countNonZero(patch.valid);
  if (seen.size() != patch.valid.size()) patch.valid = patch.valid(seen).clone();
  p.map = p.map(cv::Rect(seen.tl(), seen.size() + cv::Size(2, 2)));
  patch.west_m = (west + seen.x) * gsd_m;
  patch.north_m = (north - seen.y) * gsd_m;
  patch.pixels.create(seen.size(), image.type());
  if (view.relief.flat() && !view.lens.distorted())
    sample_plane(image, view, patch);
  else
    sample_map(image, view.camera, p, patch);
  return Status::kOk;
}

}  // namespace

Status rectify(const cv::Mat& image, const Camera& camera, const Attitude& attitude, double height_above_ground_m,
               double gsd_m, features::GridImage& patch, const RectifyOptions& options) {
  return rectify(image, camera, attitude, {0, 0, height_above_ground_m}, {}, gsd_m, patch, nullptr, options);
}

Status rectify(const cv::Mat& image, const Camera& camera, const Attitude& attitude, const Position& position,
               const Terrain& terrain, double gsd_m, features::GridImage& patch, TerrainUse* use,
               const RectifyOptions& options) {
  if (image.empty() || image.depth() != CV_8U || image.channels() > 4 || image.cols != camera.width ||
      image.rows != camera.height)
    return Status::kBadImage;
  if (!std::isfinite(position.east_m) || !std::isfinite(position.north_m)) return Status::kNotFinite;
  if (const Status s = check(terrain); s != Status::kOk) return s;
  if (const Status s = check_pose(camera, attitude, position.height_m - terrain.plane_height_m); s != Status::kOk)
    return s;
  if (!std::isfinite(gsd_m)) return Status::kNotFinite;
  if (gsd_m <= 0) return Status::kBadValue;
  try {
    const Relief relief(terrain, position);
    if (relief.height_m(0, 0) >= 0) return Status::kBelowGround;
    const View view(camera, attitude, relief, options.max_reach_heights);
    TerrainUse found;
    const Status status = rectify_view(image, view, gsd_m, patch, found, options);
    if (use) *use = found;
    return status;
  } catch (...) {
    return Status::kInternal;
  }
}

Status footprint_reach(const Camera& camera, const Attitude& attitude, double height_above_ground_m,
                       cv::Point2d& reach_m, const RectifyOptions& options) {
  if (const Status s = check_pose(camera, attitude, height_above_ground_m); s != Status::kOk) return s;
  try {
    const Relief relief({}, {0, 0, height_above_ground_m});
    const Bounds b = footprint_bounds(View(camera, attitude, relief, options.max_reach_heights));
    reach_m = {std::max(-b.west, b.east), std::max(-b.south, b.north)};
    return Status::kOk;
  } catch (...) {
    return Status::kInternal;
  }
}

}  // namespace landfix::nav
