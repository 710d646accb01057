#include "tiles/ellipse.h"

#include <algorithm>
#include <cmath>

namespace landfix::tiles {
namespace {

// Least value of the ellipse's quadratic form over a rectangle: inside it is 0, else it lies on an edge, where the form
// is a parabola. The form is scaled by the determinant so that a degenerate covariance needs no inverse.
struct Form {
  double a, b, c, limit;  // a x^2 + 2 b x y + c y^2 <= limit
  double at(double x, double y) const { return (a * x + 2 * b * y) * x + c * y * y; }
};

Form form_of(const Ellipse& e) {
  const auto& [ee, en, nn] = e.covariance;
  const double determinant = std::max(0.0, ee * nn - en * en);
  // A line segment's form would vanish along it everywhere; a floor of a millimetre keeps its width.
  const double floor_m2 = 1e-6;
  return {nn + floor_m2, -en, ee + floor_m2, e.k * e.k * (determinant + floor_m2 * (ee + nn))};
}

double least_on_vertical(const Form& f, double x, double y0, double y1) {
  const double y = f.c > 0 ? std::clamp(-f.b * x / f.c, y0, y1) : y0;
  return std::min({f.at(x, y), f.at(x, y0), f.at(x, y1)});
}

double least_on_horizontal(const Form& f, double y, double x0, double x1) {
  const double x = f.a > 0 ? std::clamp(-f.b * y / f.a, x0, x1) : x0;
  return std::min({f.at(x, y), f.at(x0, y), f.at(x1, y)});
}

}  // namespace

bool is_valid(const Ellipse& e) {
  const auto& [ee, en, nn] = e.covariance;
  for (const double v : {e.east_m, e.north_m, ee, en, nn, e.k})
    if (!std::isfinite(v)) return false;
  if (e.k < 0 || ee < 0 || nn < 0) return false;
  if (en * en > ee * nn * (1 + 1e-9) + 1e-12) return false;
  const double reach_e = std::abs(e.east_m) + e.k * std::sqrt(ee), reach_n = std::abs(e.north_m) + e.k * std::sqrt(nn);
  return reach_e < kDomainHalf && reach_n < kDomainHalf;
}

std::optional<PixelRect> bounding_pixels(const Ellipse& e, int level) {
  if (level < kMinLevel || level > kMaxLevel || !is_valid(e)) return std::nullopt;
  const double gsd = gsd_of(level);
  const double half_e = e.k * std::sqrt(e.covariance.ee), half_n = e.k * std::sqrt(e.covariance.nn);
  const auto west = int64_t(std::floor((e.east_m - half_e) / gsd)),
             east = int64_t(std::floor((e.east_m + half_e) / gsd));
  const auto top = int64_t(std::floor(-(e.north_m + half_n) / gsd)),
             bottom = int64_t(std::floor(-(e.north_m - half_n) / gsd));
  return PixelRect{level, west, top, east - west + 1, bottom - top + 1};
}

bool touches(const Ellipse& e, const TileIndex& t) {
  const double side = tile_side(t.level);
  const double x0 = t.x * side - e.east_m, x1 = x0 + side, y0 = t.y * side - e.north_m, y1 = y0 + side;
  const auto& [ee, en, nn] = e.covariance;
  const double half_e = e.k * std::sqrt(ee), half_n = e.k * std::sqrt(nn);
  if (x0 > half_e || x1 < -half_e || y0 > half_n || y1 < -half_n) return false;
  if (x0 <= 0 && x1 >= 0 && y0 <= 0 && y1 >= 0) return true;
  const Form f = form_of(e);
  const double least = std::min({least_on_vertical(f, x0, y0, y1), least_on_vertical(f, x1, y0, y1),
                                 least_on_horizontal(f, y0, x0, x1), least_on_horizontal(f, y1, x0, x1)});
  return least <= f.limit;
}

bool contains(const Ellipse& e, double east_m, double north_m) {
  const Form f = form_of(e);
  return f.at(east_m - e.east_m, north_m - e.north_m) <= f.limit;
}

bool touches_line(const Ellipse& e, double east0_m, double north0_m, double east1_m, double north1_m) {
  const Form f = form_of(e);
  const double x = east0_m - e.east_m, y = north0_m - e.north_m, dx = east1_m - east0_m, dy = north1_m - north0_m;
  // Along the line the form is a parabola in t.
  const double curvature = f.at(dx, dy), slope = f.a * x * dx + f.b * (x * dy + y * dx) + f.c * y * dy;
  const double t = curvature > 0 ? std::clamp(-slope / curvature, 0.0, 1.0) : 0;
  return f.at(x + t * dx, y + t * dy) <= f.limit;
}

}  // namespace landfix::tiles
