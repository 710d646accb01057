#include "tools/eval/camera_image.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <opencv2/imgproc.hpp>

#include "builder/error.h"
#include "builder/ingest/image_set.h"
#include "builder/ingest/window.h"

namespace landfix::eval {
namespace {

constexpr double kFinerThanCamera = 0.7;
constexpr double kInterpolationPx = 2;  ///< that a cubic reaches beyond a position

ingest::GridBounds intersection(const ingest::GridBounds& a, const ingest::GridBounds& b) {
  return {std::max(a.west_m, b.west_m), std::max(a.south_m, b.south_m), std::min(a.east_m, b.east_m),
          std::min(a.north_m, b.north_m)};
}

}  // namespace

double level_for(const std::pair<double, double>& gsd_range_m, double camera_gsd_m) {
  double gsd = gsd_range_m.first;
  while (gsd < kFinerThanCamera * camera_gsd_m && 2 * gsd <= gsd_range_m.second) gsd *= 2;
  return gsd;
}

std::pair<double, double> raster_levels(const nav::MapSource& map) {
  std::pair<double, double> range{0, 0};
  for (const nav::Method method : nav::kMethods) {
    const auto levels = map.gsd_range_m(nav::layer_of(method));
    if (levels.first > 0 && (range.first == 0 || levels.first < range.first)) range.first = levels.first;
    range.second = std::max(range.second, levels.second);
  }
  return range;
}

CameraImage::CameraImage(const std::string& path, const MapFrame& map)
    : name_(std::filesystem::path(path).filename().string()) {
  const ingest::SourceOptions file{.path = path};
  const ingest::Source source = ingest::ImageSet(std::array{file}, map.zone).sources()[0];
  date_ = source.date;
  native_gsd_m_ = source.gsd_m;
  bounds_ = intersection(source.bounds, map.bounds);
  if (bounds_.empty())
    throw Error(ExitCode::kNoData,
                fmt::format("{} and {} do not overlap: choose a camera image of the map's area", map.path, path));
  image_ = ingest::load_image(file, map.zone, bounds_, level_for(map.gsd_range_m, native_gsd_m_));
}

bool CameraImage::cut(double east_m, double north_m, int side_px, const nav::Similarity& similarity,
                      features::GridImage& patch) const {
  const double gsd = image_.gsd_m, half_px = 0.5 * side_px;
  // x to the right, y down: clockwise is from x towards y.
  const double c = similarity.scale * std::cos(similarity.rotation_rad),
               s = similarity.scale * std::sin(similarity.rotation_rad);
  const double column = image_.column_of(east_m), row = image_.row_of(north_m);
  const double reach = half_px * (std::abs(c) + std::abs(s)) + kInterpolationPx;
  const cv::Point corner(int(std::floor(column - reach)), int(std::floor(row - reach)));
  const cv::Rect source(corner, cv::Point(int(std::ceil(column + reach)) + 1, int(std::ceil(row + reach)) + 1));
  if ((source & cv::Rect({0, 0}, image_.pixels.size())) != source) return false;
  if (cv::countNonZero(image_.valid(source)) < source.area()) return false;

  const double middle = half_px - 0.5, x = column - corner.x, y = row - corner.y;
  const cv::Matx23d source_from_patch(c, -s, x - c * middle + s * middle, s, c, y - s * middle - c * middle);
  cv::warpAffine(image_.pixels(source), patch.pixels, source_from_patch, {side_px, side_px},
                 cv::INTER_CUBIC | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
  patch.valid.release();
  patch.gsd_m = gsd;
  patch.west_m = -half_px * gsd;
  patch.north_m = half_px * gsd;
  return true;
}

}  // namespace landfix::eval
