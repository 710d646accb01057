#include "builder/landmarks/outline.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Shape_regularization/regularize_contours.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>

namespace landfix::landmarks {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Contour = std::vector<Kernel::Point_2>;

constexpr double kSteps_px = 1.4;     // of a wall along pixels, that are taken for straight
constexpr double kOffset_px = 1.5;    // walls less apart become one
constexpr double kAgreement = 0.25;   // of the gradients along the boundary, from which they tell its direction
constexpr double kAlong_rad = 0.085;  // within which a side runs along a direction: just below CGAL's 5 degrees
constexpr double kSteps_per_px = 64;
constexpr double kLeastArea = 0.75, kMostArea = 1.3;  // of the outline to that of the region

// Direction of the walls in [-45, 45) degrees: that of the edges in the image where they agree, else of `rect`.
double direction_of(const features::FourfoldGradient& g, const Region& r, const cv::RotatedRect& rect) {
  double c = 0, s = 0, length = 0;
  for (int y = 0; y < r.box.height; ++y) {
    for (int x = 0; x < r.box.width; ++x) {
      const auto in = [&](int u, int v) {
        return u >= 0 && v >= 0 && u < r.box.width && v < r.box.height && r.mask.at<uint8_t>(v, u);
      };
      if (!in(x, y) || (in(x - 1, y) && in(x + 1, y) && in(x, y - 1) && in(x, y + 1))) continue;
      const cv::Point p(r.box.x + x, r.box.y + y);
      c += g.cosine.at<int16_t>(p), s += g.sine.at<int16_t>(p), length += g.length.at<int16_t>(p);
    }
  }
  if (std::hypot(c, s) >= kAgreement * length && length > 0) return std::atan2(s, c) / 4;
  return std::remainder(double(rect.angle) * std::numbers::pi / 180, std::numbers::pi / 2);
}

// Whether any side runs along the direction or across it.
bool follows(const std::vector<cv::Point>& boundary, double direction) {
  for (size_t i = 0; i < boundary.size(); ++i) {
    const cv::Point d = boundary[(i + 1) % boundary.size()] - boundary[i];
    const double turn = std::remainder(std::atan2(double(d.y), double(d.x)) - direction, std::numbers::pi / 2);
    if (std::abs(turn) < kAlong_rad) return true;
  }
  return false;
}

std::vector<cv::Point2d> regularised(const std::vector<cv::Point>& boundary, double direction, double area_px) {
  if (boundary.size() < 4 || !follows(boundary, direction)) return {};
  Contour contour, straight;
  for (const cv::Point& p : boundary) contour.emplace_back(p.x, p.y);
  const std::vector<Kernel::Direction_2> directions = {{std::cos(direction), std::sin(direction)}};
  const CGAL::Shape_regularization::Contours::User_defined_directions_2<Kernel, Contour> walls(contour, true,
                                                                                               directions);
  CGAL::Shape_regularization::Contours::regularize_closed_contour(contour, walls, std::back_inserter(straight),
                                                                  CGAL::parameters::maximum_offset(kOffset_px));
  std::vector<cv::Point2d> out;
  std::vector<cv::Point2f> polygon;
  const cv::Rect around = cv::boundingRect(boundary);
  for (const Kernel::Point_2& p : straight) {
    const cv::Point2d q(CGAL::to_double(p.x()), CGAL::to_double(p.y()));
    if (!std::isfinite(q.x) || !std::isfinite(q.y) || q.x < around.x - 4 || q.x > around.x + around.width + 4 ||
        q.y < around.y - 4 || q.y > around.y + around.height + 4)
      return {};
    out.push_back(q);
    polygon.emplace_back(q - cv::Point2d(around.tl()));
  }
  if (out.size() < 4) return {};
  const double share = cv::contourArea(polygon) / area_px;
  return share >= kLeastArea && share <= kMostArea ? out : std::vector<cv::Point2d>();
}

// Around points, along a direction.
Shape rectangle_along(const std::vector<cv::Point2d>& points, double direction) {
  const cv::Point2d u(std::cos(direction), std::sin(direction)), v(-u.y, u.x);
  const double inf = std::numeric_limits<double>::infinity();
  double low_u = inf, high_u = -inf, low_v = inf, high_v = -inf;
  for (const cv::Point2d& p : points) {
    low_u = std::min(low_u, p.dot(u)), high_u = std::max(high_u, p.dot(u));
    low_v = std::min(low_v, p.dot(v)), high_v = std::max(high_v, p.dot(v));
  }
  Shape out;
  out.centre = u * ((low_u + high_u) / 2) + v * ((low_v + high_v) / 2);
  out.length = high_u - low_u;
  out.width = high_v - low_v;
  out.along = u;
  if (out.length < out.width) {
    std::swap(out.length, out.width);
    out.along = v;
  }
  return out;
}

Shape shape_in_box(const Region& region, const features::FourfoldGradient& gradient) {
  const cv::RotatedRect rect = rectangle_of(region);
  const std::vector<cv::Point> boundary = boundary_of(region, kSteps_px);
  const std::vector<cv::Point2d> corners(boundary.begin(), boundary.end());
  if (region.cls != tiles::LandmarkClass::kBuilding)
    return rectangle_along(corners, double(rect.angle) * std::numbers::pi / 180);
  const double direction = direction_of(gradient, region, rect);
  const std::vector<cv::Point2d> outline = regularised(boundary, direction, region.area_px);
  Shape out = rectangle_along(outline.empty() ? corners : outline, direction);
  const cv::Point2d along = out.along * (out.length / 2),
                    across = cv::Point2d(-out.along.y, out.along.x) * (out.width / 2);
  if (outline.empty())
    out.outline = {out.centre + along + across, out.centre + along - across, out.centre - along - across,
                   out.centre - along + across};
  else
    out.outline = outline;
  return out;
}

}  // namespace

std::vector<cv::Point> boundary_of(const Region& r, double tolerance_px) {
  cv::Mat corners = cv::Mat::zeros(r.box.height + 1, r.box.width + 1, CV_8U);
  for (const cv::Point shift : {cv::Point(0, 0), cv::Point(1, 0), cv::Point(0, 1), cv::Point(1, 1)})
    corners(cv::Rect(shift, r.box.size())) |= r.mask;
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(corners, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  std::vector<cv::Point> out;
  cv::approxPolyDP(contours.front(), out, tolerance_px, true);
  return out;
}

Shape shape_of(const Region& region, const features::FourfoldGradient& gradient) {
  Shape out = shape_in_box(region, gradient);
  // Whole steps: wherever the image begins, the sums with its corner come out alike.
  const auto stepped = [](double v) { return std::round(v * kSteps_per_px) / kSteps_per_px; };
  const auto placed = [&](const cv::Point2d& p) {
    return cv::Point2d(stepped(p.x), stepped(p.y)) + cv::Point2d(region.box.tl());
  };
  out.length = stepped(out.length);
  out.width = stepped(out.width);
  if (region.cls != tiles::LandmarkClass::kBuilding) {
    const cv::Moments m = cv::moments(region.mask, true);
    out.centre = {m.m10 / m.m00 + 0.5, m.m01 / m.m00 + 0.5};
  }
  out.centre = placed(out.centre);
  for (cv::Point2d& p : out.outline) p = placed(p);
  return out;
}

}  // namespace landfix::landmarks
