#include "builder/terrain/scene.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>

namespace landfix::terrain {
namespace {

/// Four heights whose surface covers the whole orthophoto.
features::GridImage plane_below(const features::GridImage& ortho, double height_m) {
  features::GridImage plane;
  const double width_m = ortho.pixels.cols * ortho.gsd_m, height_extent_m = ortho.pixels.rows * ortho.gsd_m;
  plane.gsd_m = std::max({width_m, height_extent_m, ortho.gsd_m});
  plane.pixels = cv::Mat(2, 2, CV_32FC1, cv::Scalar(height_m));
  plane.west_m = ortho.west_m + 0.5 * width_m - plane.gsd_m;
  plane.north_m = ortho.north_m - 0.5 * height_extent_m + plane.gsd_m;
  return plane;
}

}  // namespace

Scene::Scene(const features::GridImage& ortho, const features::GridImage& heights)
    : texture_(ortho), surface_(heights) {}

Scene::Scene(const features::GridImage& ortho, double plane_height_m)
    : texture_(ortho), surface_(plane_below(ortho, plane_height_m)) {}

Picture Scene::render(const nav::Camera& camera, const Pose& pose) const {
  Picture picture{cv::Mat::zeros(camera.height, camera.width, CV_8UC(texture_.channels())),
                  cv::Mat::zeros(camera.height, camera.width, CV_8UC1)};
  const nav::Lens lens(camera);
  tbb::parallel_for(0, camera.height, [&](int row) { render_row(camera, lens, pose, row, picture); });
  return picture;
}

void Scene::render_row(const nav::Camera& camera, const nav::Lens& lens, const Pose& pose, int row,
                       Picture& picture) const {
  const Eigen::Matrix3d enu_from_camera = nav::enu_from_camera(pose.attitude);
  const Eigen::Vector3d position(pose.east_m, pose.north_m, pose.height_m);
  const double focal_px = 0.5 * (camera.fx + camera.fy);
  const int channels = texture_.channels();
  for (int begin = 0; begin < camera.width; begin += Surface::kPacket) {
    const int count = std::min(Surface::kPacket, camera.width - begin);
    Surface::Directions directions;
    std::array<bool, Surface::kPacket> seen{};
    for (int i = 0; i < Surface::kPacket; ++i) {
      // Of depth 1 along the optical axis, so that the distance of a hit is its depth.
      Eigen::Vector3d in_camera(0, 0, 1);
      seen[size_t(i)] = lens.ray_of({begin + i, row}, in_camera);
      directions[size_t(i)] = (enu_from_camera * in_camera).cast<float>();
    }
    const Surface::Distances depths = surface_.intersect(position, directions, count);
    for (int i = 0; i < count; ++i) {
      const double depth_m = depths[size_t(i)];
      if (depth_m <= 0 || !seen[size_t(i)]) continue;
      const Eigen::Vector3d hit = position + depth_m * directions[size_t(i)].cast<double>();
      float value[3];
      if (!texture_.sample(hit.x(), hit.y(), depth_m / focal_px, value)) continue;
      uchar* pixel = picture.image.ptr<uchar>(row) + channels * (begin + i);
      for (int c = 0; c < channels; ++c) pixel[c] = uchar(value[c] + 0.5f);
      picture.valid.at<uchar>(row, begin + i) = 255;
    }
  }
}

std::optional<double> Scene::height_below(double east_m, double north_m) const {
  const double top_m = surface_.highest_m() + 10.0;
  Surface::Directions directions;
  directions.fill({0, 0, -1});
  const float distance_m = surface_.intersect({east_m, north_m, top_m}, directions, 1)[0];
  if (distance_m < 0) return std::nullopt;
  return top_m - distance_m;
}

}  // namespace landfix::terrain
