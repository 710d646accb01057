#include "tests/nav/relief_scene.h"

#include <cmath>

namespace landfix::nav::testing {

cv::Mat ReliefScene::take_picture(const Camera& camera, const Attitude& attitude, const Position& p) const {
  constexpr double kStep = 0.5, kFarthest = 2000;
  const Lens lens(camera);
  const Eigen::Matrix3d enu = enu_from_camera(attitude);
  cv::Mat picture = cv::Mat::zeros(camera.height, camera.width, CV_8UC1);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      Eigen::Vector3d in_camera;
      if (!lens.ray_of({double(x), double(y)}, in_camera)) continue;
      const Eigen::Vector3d ray = (enu * in_camera).normalized();
      const auto below = [&](double t) {
        return p.height_m + t * ray.z() <= height_m(p.east_m + t * ray.x(), p.north_m + t * ray.y());
      };
      double far = ray.z() < 0 ? (highest_m - p.height_m) / ray.z() : kFarthest;
      while (far < kFarthest && !below(far)) far += kStep;
      if (far >= kFarthest) continue;
      double near = far - kStep;
      for (int i = 0; i < 30; ++i) (below(0.5 * (near + far)) ? far : near) = 0.5 * (near + far);
      picture.at<uint8_t>(y, x) = uint8_t(std::lround(gray(p.east_m + far * ray.x(), p.north_m + far * ray.y())));
    }
  }
  return picture;
}

bool ReliefScene::visible(double east_m, double north_m, const Position& camera, double slack_m) const {
  const double height = height_m(east_m, north_m);
  const double de = camera.east_m - east_m, dn = camera.north_m - north_m, dh = camera.height_m - height;
  const double length = std::hypot(de, dn, dh);
  for (double t = 0.2; t < length && height + dh * t / length <= highest_m; t += 0.2)
    if (height + dh * t / length < height_m(east_m + de * t / length, north_m + dn * t / length) - slack_m)
      return false;
  return true;
}

features::GridImage ReliefScene::heights(double east_m, double north_m, double half_side_m, double gsd_m) const {
  const int side = int(2 * half_side_m / gsd_m);
  features::GridImage image{cv::Mat(side, side, CV_32FC1), {}, east_m - half_side_m, north_m + half_side_m, gsd_m};
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      image.pixels.at<float>(y, x) =
          float(height_m(image.west_m + (x + 0.5) * gsd_m, image.north_m - (y + 0.5) * gsd_m));
  return image;
}

}  // namespace landfix::nav::testing
