#include "runtime/nav/image_map.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "runtime/features/contour.h"
#include "runtime/features/edge.h"
#include "runtime/features/gray.h"
#include "runtime/features/orientation.h"
#include "runtime/features/orientation_code.h"

namespace landfix::nav {
namespace {

using features::GridImage;

constexpr double kMaxPixels = 1 << 26;  ///< of one window: a wrong covariance must not ask for gigabytes

GridImage halved(const GridImage& in) {
  const cv::Size size = in.pixels.size() / 2;
  const cv::Rect even({0, 0}, size * 2);
  GridImage out{{}, {}, in.west_m, in.north_m, 2 * in.gsd_m};
  cv::resize(in.pixels(even), out.pixels, size, 0, 0, cv::INTER_AREA);
  cv::resize(in.valid(even), out.valid, size, 0, 0, cv::INTER_AREA);
  cv::compare(out.valid, 255, out.valid, cv::CMP_EQ);
  return out;
}

void fill_orientation(std::span<const GridImage> dates, GridImage& out) {
  std::vector<features::DatedOrientation> parts(dates.size());
  for (size_t i = 0; i < dates.size(); ++i)
    features::orientation(dates[i].pixels, dates[i].valid, {}, parts[i].ab, parts[i].valid);
  const features::DatedOrientation fused = features::fuse(parts);
  features::orientation_levels(fused.ab, out.pixels);
  out.valid = fused.valid;
}

GridImage layer_from(MapLayer layer, std::span<const GridImage> dates) {
  GridImage out = dates[0];
  if (layer == MapLayer::kOrientation) {
    fill_orientation(dates, out);
    return out;
  }
  out.pixels = features::gray_from_rgb(dates[0].pixels);
  if (layer == MapLayer::kGray) return out;
  if (layer == MapLayer::kEdge) {
    cv::Mat magnitude;
    features::edge(out.pixels, out.valid, magnitude);
    out.pixels = magnitude;
  } else {
    cv::Mat mask, known;
    features::contours(out.pixels, out.valid, {}, mask, known);
    features::contour_distance(mask, known, {}, out.pixels);
  }
  out.valid = out.pixels != 0;
  return out;
}

/// First pixel that a coordinate in metres touches, and one beyond the last; a rounding error must not add a row.
constexpr double kSlackPx = 1e-6;
int first_pixel(double m, double gsd_m) { return int(std::floor(m / gsd_m + kSlackPx)); }
int end_pixel(double m, double gsd_m) { return int(std::ceil(m / gsd_m - kSlackPx)); }

}  // namespace

ImageMap::ImageMap(std::span<const GridImage> dates, int levels, double ground_height_m,
                   std::span<const MapLayer> layers)
    : ground_height_m_(ground_height_m) {
  try {
    std::vector<GridImage> at_level(dates.begin(), dates.end());
    if (at_level.empty()) return;
    for (GridImage& image : at_level)
      if (image.valid.empty()) image.valid = cv::Mat(image.pixels.size(), CV_8U, cv::Scalar(255));
    for (int i = 0; i < levels; ++i) {
      for (const MapLayer layer : layers) layers_[size_t(layer)].push_back(layer_from(layer, at_level));
      if (std::min(at_level[0].pixels.cols, at_level[0].pixels.rows) < 2) break;
      for (GridImage& image : at_level) image = halved(image);
    }
  } catch (...) {
    for (auto& layer : layers_) layer.clear();
  }
}

std::pair<double, double> ImageMap::gsd_range_m(MapLayer layer) const {
  const std::vector<GridImage>& levels = layers_[size_t(layer)];
  return levels.empty() ? std::pair(0.0, 0.0) : std::pair(levels.front().gsd_m, levels.back().gsd_m);
}

Status ImageMap::read(MapLayer layer, double west_m, double south_m, double east_m, double north_m, double gsd_m,
                      GridImage& window) const try {
  const std::vector<GridImage>& levels = layers_[size_t(layer)];
  if (levels.empty()) return Status::kNoLayer;
  const auto level = std::find_if(levels.begin(), levels.end(), [&](const GridImage& l) { return l.gsd_m == gsd_m; });
  if (level == levels.end() || !(west_m < east_m) || !(south_m < north_m)) return Status::kMapError;
  const double map_east_m = level->west_m + level->pixels.cols * gsd_m,
               map_south_m = level->north_m - level->pixels.rows * gsd_m;
  if (west_m >= map_east_m || east_m <= level->west_m || south_m >= level->north_m || north_m <= map_south_m)
    return Status::kOutsideMap;
  if ((east_m - west_m) / gsd_m * ((north_m - south_m) / gsd_m) > kMaxPixels) return Status::kTooLarge;
  const cv::Point corner(first_pixel(west_m - level->west_m, gsd_m), first_pixel(level->north_m - north_m, gsd_m)),
      end(end_pixel(east_m - level->west_m, gsd_m), end_pixel(level->north_m - south_m, gsd_m));
  const cv::Rect wanted(corner, end), common = wanted & cv::Rect({0, 0}, level->pixels.size());
  if (common.empty() || cv::countNonZero(level->valid(common)) == 0) return Status::kOutsideMap;
  window.west_m = level->west_m + corner.x * gsd_m;
  window.north_m = level->north_m - corner.y * gsd_m;
  window.gsd_m = gsd_m;
  window.pixels = cv::Mat::zeros(wanted.size(), level->pixels.type());
  window.valid = cv::Mat::zeros(wanted.size(), CV_8U);
  level->pixels(common).copyTo(window.pixels(common - corner));
  level->valid(common).copyTo(window.valid(common - corner));
  if (cv::countNonZero(window.valid) == int(window.valid.total())) window.valid.release();
  return Status::kOk;
} catch (...) {
  return Status::kInternal;
}

}  // namespace landfix::nav
