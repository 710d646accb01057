#include "runtime/nav/matcher.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace landfix::nav {

const char* name_of(Method method) {
  switch (method) {
    case Method::kGray:
      return "gray";
    case Method::kEdge:
      return "edge";
    case Method::kContour:
      return "contour";
    case Method::kOrientation:
      return "orientation";
  }
  return "";
}

std::optional<Method> method_of(std::string_view name) {
  for (const Method method : kMethods)
    if (name == name_of(method)) return method;
  return std::nullopt;
}

MapLayer layer_of(Method method) {
  switch (method) {
    case Method::kGray:
      return MapLayer::kGray;
    case Method::kEdge:
      return MapLayer::kEdge;
    case Method::kContour:
      return MapLayer::kContour;
    case Method::kOrientation:
      return MapLayer::kOrientation;
  }
  return MapLayer::kGray;
}

std::unique_ptr<Matcher> make_matcher(Method method, double min_coverage) {
  switch (method) {
    case Method::kGray:
    case Method::kEdge:
      return make_ncc_matcher(method, min_coverage);
    case Method::kContour:
      return make_contour_matcher(min_coverage);
    case Method::kOrientation:
      return make_orientation_matcher(min_coverage);
  }
  return nullptr;
}

void apply(const Similarity& similarity, const features::GridImage& in, features::GridImage& out) {
  out.west_m = in.west_m;
  out.north_m = in.north_m;
  out.gsd_m = in.gsd_m;
  const cv::Mat valid = in.valid.empty() ? cv::Mat(in.pixels.size(), CV_8U, cv::Scalar(255)) : in.valid;
  if (similarity.is_identity()) {
    in.pixels.copyTo(out.pixels);
    valid.copyTo(out.valid);
    return;
  }
  // x to the right, y down: clockwise is from x towards y.
  const double x = in.column_of(0), y = in.row_of(0);
  const double c = similarity.scale * std::cos(similarity.rotation_rad),
               s = similarity.scale * std::sin(similarity.rotation_rad);
  const cv::Matx23d forward(c, -s, x - c * x + s * y, s, c, y - s * x - c * y);
  cv::warpAffine(in.pixels, out.pixels, forward, in.pixels.size(), cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  cv::warpAffine(valid, out.valid, forward, valid.size(), cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  cv::compare(out.valid, 254, out.valid, cv::CMP_GT);
}

features::GridImage without_rim(const features::GridImage& image, int rim_px) {
  features::GridImage out = image;
  const cv::Rect inside(rim_px, rim_px, image.pixels.cols - 2 * rim_px, image.pixels.rows - 2 * rim_px);
  out.pixels = image.pixels(inside);
  if (!image.valid.empty()) out.valid = image.valid(inside);
  out.west_m += rim_px * image.gsd_m;
  out.north_m -= rim_px * image.gsd_m;
  return out;
}

void prepare_surface(const features::GridImage& patch, const features::GridImage& window,
                     features::GridImage& surface) {
  const cv::Size positions = window.pixels.size() - patch.pixels.size() + cv::Size(1, 1);
  surface.pixels.create(positions, CV_32F);
  surface.valid.create(positions, CV_8U);
  surface.gsd_m = window.gsd_m;
  surface.west_m = window.west_m - patch.west_m - 0.5 * window.gsd_m;
  surface.north_m = window.north_m - patch.north_m + 0.5 * window.gsd_m;
}

}  // namespace landfix::nav
