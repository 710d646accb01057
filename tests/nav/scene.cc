#include "tests/nav/scene.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace landfix::nav::testing {

cv::Mat random_texture(int width, int height, uint64_t seed) {
  cv::RNG rng(seed);
  cv::Mat sum = cv::Mat::zeros(height, width, CV_32F);
  for (int size = 1; size <= 32; size *= 2) {
    cv::Mat noise(height / size + 2, width / size + 2, CV_32F), large;
    rng.fill(noise, cv::RNG::NORMAL, 0, 12 * std::pow(size, 0.4));
    cv::resize(noise, large, {}, size, size, cv::INTER_CUBIC);
    sum += large(cv::Rect(0, 0, width, height));
  }
  cv::Mat texture;
  sum.convertTo(texture, CV_8U, 1, 128);
  return cv::max(texture, 1);
}

ImageMap::ImageMap(const features::GridImage& finest, int levels, double ground_height_m)
    : levels_{finest}, ground_height_m_(ground_height_m) {
  while (int(levels_.size()) < levels) {
    features::GridImage next = levels_.back();
    cv::resize(levels_.back().pixels, next.pixels, next.pixels.size() / 2, 0, 0, cv::INTER_AREA);
    next.gsd_m *= 2;
    levels_.push_back(next);
  }
}

std::pair<double, double> ImageMap::gsd_range_m(MapLayer layer) const {
  if (layer != MapLayer::kGray) return {0, 0};
  return {levels_.front().gsd_m, levels_.back().gsd_m};
}

Status ImageMap::read(MapLayer layer, double west_m, double south_m, double east_m, double north_m, double gsd_m,
                      features::GridImage& window) const {
  if (layer != MapLayer::kGray) return Status::kNoLayer;
  for (const features::GridImage& level : levels_) {
    if (level.gsd_m != gsd_m) continue;
    const int left = int(std::floor((west_m - level.west_m) / gsd_m)),
              right = int(std::ceil((east_m - level.west_m) / gsd_m));
    const int top = int(std::floor((level.north_m - north_m) / gsd_m));
    const int bottom = int(std::ceil((level.north_m - south_m) / gsd_m));
    const cv::Rect wanted(left, top, right - left, bottom - top),
        common = wanted & cv::Rect({0, 0}, level.pixels.size());
    if (common.empty()) return Status::kOutsideMap;
    window.west_m = level.west_m + left * gsd_m;
    window.north_m = level.north_m - top * gsd_m;
    window.gsd_m = gsd_m;
    window.pixels = cv::Mat::zeros(wanted.size(), CV_8U);
    level.pixels(common).copyTo(window.pixels(common - wanted.tl()));
    window.valid = common == wanted ? cv::Mat() : cv::Mat(window.pixels != 0);
    return Status::kOk;
  }
  return Status::kMapError;
}

cv::Mat take_picture(const features::GridImage& ground, const Camera& camera, const Pose& pose) {
  const Eigen::Matrix3d enu = enu_from_camera(pose.attitude);
  cv::Mat columns(camera.height, camera.width, CV_32F), rows(camera.height, camera.width, CV_32F), picture;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3d ray = enu * Eigen::Vector3d((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1);
      const double distance = ray.z() < 0 ? pose.height_above_ground_m / -ray.z() : 1e9;
      columns.at<float>(y, x) = float(ground.column_of(pose.east_m + distance * ray.x()));
      rows.at<float>(y, x) = float(ground.row_of(pose.north_m + distance * ray.y()));
    }
  }
  cv::remap(ground.pixels, picture, columns, rows, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  return picture;
}

}  // namespace landfix::nav::testing
