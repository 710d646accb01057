#include "tools/eval/image_map.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "runtime/features/contour.h"
#include "runtime/features/edge.h"
#include "runtime/features/gray.h"
#include "runtime/features/orientation.h"
#include "runtime/features/orientation_code.h"

namespace landfix::eval {
namespace {

using features::GridImage;
using nav::MapLayer;

GridImage halved(const GridImage& in) {
  GridImage out = in;
  const cv::Size size = in.pixels.size() / 2;
  const cv::Rect even({0, 0}, size * 2);
  out.gsd_m = 2 * in.gsd_m;
  cv::resize(in.pixels(even), out.pixels, size, 0, 0, cv::INTER_AREA);
  cv::resize(in.valid(even), out.valid, size, 0, 0, cv::INTER_AREA);
  cv::compare(out.valid, 255, out.valid, cv::CMP_EQ);
  return out;
}

std::array<GridImage, 4> layers_of(const GridImage& image) {
  std::array<GridImage, 4> out;
  out.fill(image);
  GridImage &gray = out[size_t(MapLayer::kGray)], &edge = out[size_t(MapLayer::kEdge)],
            &contour = out[size_t(MapLayer::kContour)], &orientation = out[size_t(MapLayer::kOrientation)];
  gray.pixels = features::gray_from_rgb(image.pixels);
  features::edge(gray.pixels, image.valid, edge.pixels);
  edge.valid = edge.pixels != 0;
  cv::Mat mask, known, ab;
  features::contours(gray.pixels, image.valid, {}, mask, known);
  features::contour_distance(mask, known, {}, contour.pixels);
  contour.valid = contour.pixels != 0;
  features::orientation(image.pixels, image.valid, {}, ab, orientation.valid);
  features::orientation_levels(ab, orientation.pixels);
  return out;
}

}  // namespace

ImageMap::ImageMap(const GridImage& image, int levels, double ground_height_m) : ground_height_m_(ground_height_m) {
  GridImage level = image;
  if (level.valid.empty()) level.valid = cv::Mat(image.pixels.size(), CV_8U, cv::Scalar(255));
  for (int i = 0; i < levels; ++i) {
    levels_.push_back(layers_of(level));
    if (std::min(level.pixels.cols, level.pixels.rows) < 2) break;
    if (i + 1 < levels) level = halved(level);
  }
}

std::pair<double, double> ImageMap::gsd_range_m(MapLayer layer) const {
  return {levels_.front()[size_t(layer)].gsd_m, levels_.back()[size_t(layer)].gsd_m};
}

nav::Status ImageMap::read(MapLayer layer, double west_m, double south_m, double east_m, double north_m, double gsd_m,
                           GridImage& window) const {
  for (const Level& level : levels_) {
    const GridImage& image = level[size_t(layer)];
    if (image.gsd_m != gsd_m) continue;
    // A rounding error of the edges asked for must not add a row.
    constexpr double kSlackPx = 1e-6;
    const auto first = [&](double m) { return int(std::floor(m / gsd_m + kSlackPx)); };
    const auto last = [&](double m) { return int(std::ceil(m / gsd_m - kSlackPx)); };
    const cv::Point corner(first(west_m - image.west_m), first(image.north_m - north_m)),
        end(last(east_m - image.west_m), last(image.north_m - south_m));
    const cv::Rect wanted(corner, end), common = wanted & cv::Rect({0, 0}, image.pixels.size());
    if (common.empty() || cv::countNonZero(image.valid(common)) == 0) return nav::Status::kOutsideMap;
    window.west_m = image.west_m + corner.x * gsd_m;
    window.north_m = image.north_m - corner.y * gsd_m;
    window.gsd_m = gsd_m;
    window.pixels = cv::Mat::zeros(wanted.size(), image.pixels.type());
    window.valid = cv::Mat::zeros(wanted.size(), CV_8U);
    image.pixels(common).copyTo(window.pixels(common - corner));
    image.valid(common).copyTo(window.valid(common - corner));
    return nav::Status::kOk;
  }
  return nav::Status::kMapError;
}

}  // namespace landfix::eval
