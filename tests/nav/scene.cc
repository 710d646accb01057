#include "tests/nav/scene.h"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "tests/features/draw.h"

namespace landfix::nav::testing {

using features::GridImage;

/// Multiplies seeds: streams of cv::RNG whose seeds are small numbers are correlated.
constexpr uint64_t kFarApart = 0x9E3779B97F4A7C15;

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

cv::Mat countryside(int side_px, uint64_t seed, uint64_t season) {
  using features::Numbers;
  Numbers place(seed), colours(seed * 1000003 + season), passing(seed * 1000003 + season + 500);
  cv::Mat image(side_px, side_px, CV_8UC3, cv::Scalar(95, 105, 80));
  const auto shape = [&](Numbers& numbers, int size) {
    const cv::RotatedRect box(cv::Point2f(float(numbers.within(0, side_px)), float(numbers.within(0, side_px))),
                              cv::Size2f(float(numbers.within(size / 2, size)), float(numbers.within(size / 4, size))),
                              float(numbers.within(0, 179)));
    cv::Point2f corners[4];
    box.points(corners);
    std::vector<cv::Point> outline(corners, corners + 4);
    const cv::Scalar colour(colours.within(30, 220), colours.within(30, 220), colours.within(30, 220));
    cv::fillConvexPoly(image, outline, colour);
  };
  // A shape covers a quarter of the square of its size: every size covers a sixth of what larger ones left.
  for (int size = 512; size >= 16; size /= 2) {
    const int count = 2 * side_px * side_px / (3 * size * size);
    for (int i = 0; i < count; ++i) shape(place, size);
    for (int i = 0; i < count / 4; ++i) shape(passing, size);
  }
  cv::Mat noise(image.size(), CV_16SC3);
  cv::RNG((seed * 31 + season + 1) * kFarApart).fill(noise, cv::RNG::NORMAL, 0, 6);
  cv::add(image, noise, image, cv::noArray(), CV_8U);
  return image;
}

GridImage ground_of(const cv::Mat& pixels) { return {pixels, {}, -0.125 * pixels.cols, 0.125 * pixels.rows, 0.25}; }

GridImage coarser(const GridImage& image, int factor) {
  GridImage out{{}, {}, image.west_m, image.north_m, factor * image.gsd_m};
  cv::resize(image.pixels, out.pixels, image.pixels.size() / factor, 0, 0, cv::INTER_AREA);
  return out;
}

GridImage look_down(const GridImage& ground, const View& view) {
  const int fine = 4, side = fine * view.side_px;
  const double c = view.error.scale * std::cos(view.error.rotation_rad),
               s = view.error.scale * std::sin(view.error.rotation_rad), step = view.gsd_m / fine;
  cv::Mat columns(side, side, CV_32F), rows(side, side, CV_32F), sampled;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      // East and south of the origin, as rectified; turned clockwise it is where the camera really looked.
      const double east = (x + 0.5 - 0.5 * side) * step, south = (y + 0.5 - 0.5 * side) * step;
      columns.at<float>(y, x) = float(ground.column_of(view.east_m + c * east - s * south));
      rows.at<float>(y, x) = float(ground.row_of(view.north_m - (s * east + c * south)));
    }
  cv::remap(ground.pixels, sampled, columns, rows, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  GridImage out{{}, {}, -0.5 * view.side_px * view.gsd_m, 0.5 * view.side_px * view.gsd_m, view.gsd_m};
  cv::resize(sampled, out.pixels, {view.side_px, view.side_px}, 0, 0, cv::INTER_AREA);
  return out;
}

cv::Mat take_picture(const GridImage& ground, const Camera& camera, const Pose& pose) {
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
