#include "tools/fly/shift.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "builder/error.h"
#include "runtime/features/gray.h"

namespace landfix::fly {
namespace {

constexpr int kPlacesAcross = 12;
constexpr int kTemplatePx = 160;
constexpr double kLeastNcc = 0.4;
constexpr int kLeastPlaces = 5;

/// Square of the scene around a place in the map's pixels; nothing where the scene has holes.
std::optional<cv::Mat> scene_patch(const terrain::Texture& scene, const features::GridImage& like, cv::Point corner) {
  cv::Mat patch(kTemplatePx, kTemplatePx, CV_8UC(scene.channels()));
  for (int y = 0; y < kTemplatePx; ++y) {
    for (int x = 0; x < kTemplatePx; ++x) {
      float value[3];
      const double east = like.west_m + (corner.x + x + 0.5) * like.gsd_m;
      const double north = like.north_m - (corner.y + y + 0.5) * like.gsd_m;
      if (!scene.sample(east, north, like.gsd_m, value)) return std::nullopt;
      for (int c = 0; c < scene.channels(); ++c) patch.ptr<uchar>(y)[scene.channels() * x + c] = uchar(value[c] + 0.5f);
    }
  }
  return features::gray_from_rgb(patch);
}

/// Offset of a parabola's top from its middle sample.
double parabola_top(double left, double middle, double right) {
  const double curvature = left - 2 * middle + right;
  return curvature < 0 ? 0.5 * (left - right) / curvature : 0.0;
}

/// Shift at one place in metres; nothing where the map or the scene has a hole or the match is weak or at the rim.
std::optional<Eigen::Vector2d> shift_at(const terrain::Texture& scene, const nav::MapSource& map, double east_m,
                                        double north_m, double reach_m) {
  const double gsd = map.gsd_range_m(nav::MapLayer::kGray).first;
  const double half_m = 0.5 * kTemplatePx * gsd + reach_m;
  features::GridImage window;
  if (map.read(nav::MapLayer::kGray, east_m - half_m, north_m - half_m, east_m + half_m, north_m + half_m, gsd,
               window) != nav::Status::kOk) {
    return std::nullopt;
  }
  if (!window.valid.empty() && cv::countNonZero(window.valid) < int(window.valid.total())) return std::nullopt;
  const cv::Point corner((window.pixels.cols - kTemplatePx) / 2, (window.pixels.rows - kTemplatePx) / 2);
  const auto patch = scene_patch(scene, window, corner);
  if (!patch) return std::nullopt;
  cv::Mat ncc;
  cv::matchTemplate(window.pixels, *patch, ncc, cv::TM_CCOEFF_NORMED);
  double top;
  cv::Point peak;
  cv::minMaxLoc(ncc, nullptr, &top, nullptr, &peak);
  const bool at_rim = peak.x == 0 || peak.y == 0 || peak.x == ncc.cols - 1 || peak.y == ncc.rows - 1;
  if (!(top >= kLeastNcc) || at_rim) return std::nullopt;
  const auto at = [&](int dx, int dy) { return double(ncc.at<float>(peak.y + dy, peak.x + dx)); };
  const double column = peak.x - corner.x + parabola_top(at(-1, 0), top, at(1, 0));
  const double row = peak.y - corner.y + parabola_top(at(0, -1), top, at(0, 1));
  return Eigen::Vector2d(column * gsd, -row * gsd);
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + long(values.size() / 2), values.end());
  return values[values.size() / 2];
}

}  // namespace

Shift measure_shift(const terrain::Texture& scene, const nav::MapSource& map, double reach_m) {
  const features::GridImage& base = scene.base();
  const double width_m = base.pixels.cols * base.gsd_m, height_m = base.pixels.rows * base.gsd_m;
  std::vector<double> found[2];
  for (int j = 0; j < kPlacesAcross; ++j) {
    for (int i = 0; i < kPlacesAcross; ++i) {
      const auto shift = shift_at(scene, map, base.west_m + width_m * (i + 0.5) / kPlacesAcross,
                                  base.north_m - height_m * (j + 0.5) / kPlacesAcross, reach_m);
      if (!shift) continue;
      for (int axis = 0; axis < 2; ++axis) found[axis].push_back((*shift)[axis]);
    }
  }
  Shift result;
  result.places = int(found[0].size());
  if (result.places < kLeastPlaces) {
    throw Error(ExitCode::kNoData,
                fmt::format("shift of scene against map: expected at least {} places that match, found "
                            "{}; state it with --scene-shift instead",
                            kLeastPlaces, result.places));
  }
  for (int axis = 0; axis < 2; ++axis) {
    result.map_from_scene[axis] = median(found[axis]);
    for (double& value : found[axis]) value = std::abs(value - result.map_from_scene[axis]);
    result.spread[axis] = median(found[axis]);
  }
  return result;
}

}  // namespace landfix::fly
