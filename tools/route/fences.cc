#include "tools/route/fences.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/geometry.hpp>
#include <boost/geometry/geometries/linestring.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/polygon.hpp>
#include <cmath>

#include "builder/error.h"

namespace landfix::route {
namespace {

namespace bg = boost::geometry;
using Point = bg::model::d2::point_xy<double>;
using Line = bg::model::linestring<Point>;

constexpr int kCircleSides = 48;

Eigen::Vector2d grid(const mission::Mission& mission, const tiles::Zone& zone, const mission::Position& p) {
  constexpr double kRadians = M_PI / 180;
  const auto place = tiles::grid_from_geodetic(zone, {p.latitude_deg * kRadians, p.longitude_deg * kRadians});
  if (!place) {
    throw Error(ExitCode::kNoData,
                fmt::format("{}: expected a fence in reach of the map's zone {}, found latitude {:.6f}, "
                            "longitude {:.6f}; choose the map of this area",
                            mission.file, zone.number, p.latitude_deg, p.longitude_deg));
  }
  return {place->east_m, place->north_m};
}

Polygon polygon_of(const mission::Mission& mission, const tiles::Zone& zone, const mission::Fence& fence) {
  Polygon polygon;
  for (const mission::Position& p : fence.polygon) polygon.push_back(grid(mission, zone, p));
  if (!polygon.empty()) return polygon;
  const Eigen::Vector2d centre = grid(mission, zone, fence.centre);
  const double radius_m = fence.inclusion ? fence.radius_m : fence.radius_m / std::cos(M_PI / kCircleSides);
  for (int i = 0; i < kCircleSides; ++i) {
    const double angle = 2 * M_PI * i / kCircleSides;
    polygon.push_back(centre + radius_m * Eigen::Vector2d(std::sin(angle), std::cos(angle)));
  }
  return polygon;
}

}  // namespace

struct Fences::Area {
  explicit Area(const Polygon& polygon) : corners(polygon) {
    for (const Eigen::Vector2d& c : corners) bg::append(shape.outer(), Point(c.x(), c.y()));
    bg::correct(shape);
    bg::envelope(shape, box);
  }
  static std::vector<Polygon> corners_of(const std::vector<Area>& areas) {
    std::vector<Polygon> out;
    for (const Area& a : areas) out.push_back(a.corners);
    return out;
  }
  Polygon corners;
  bg::model::polygon<Point> shape;
  bg::model::box<Point> box;
};

Fences::Fences(std::vector<Polygon> exclusions, std::vector<Polygon> inclusions) {
  for (const Polygon& p : exclusions) exclusions_.emplace_back(p);
  for (const Polygon& p : inclusions) inclusions_.emplace_back(p);
}
Fences::~Fences() = default;
Fences::Fences(const Fences&) = default;
Fences& Fences::operator=(const Fences&) = default;

std::vector<Polygon> Fences::exclusions() const { return Area::corners_of(exclusions_); }
std::vector<Polygon> Fences::inclusions() const { return Area::corners_of(inclusions_); }

bool Fences::allow(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
  if (exclusions_.empty() && inclusions_.empty()) return true;
  const Line line{{from.x(), from.y()}, {to.x(), to.y()}};
  const bg::model::box<Point> box = bg::return_envelope<bg::model::box<Point>>(line);
  const auto crosses = [&](const Area& a) { return bg::intersects(box, a.box) && bg::intersects(line, a.shape); };
  const auto holds = [&](const Area& a) {
    return bg::covered_by(line.front(), a.shape) && bg::covered_by(line.back(), a.shape) &&
           bg::covered_by(line, a.shape);
  };
  return std::none_of(exclusions_.begin(), exclusions_.end(), crosses) &&
         (inclusions_.empty() || std::any_of(inclusions_.begin(), inclusions_.end(), holds));
}

Fences fences_of(const mission::Mission& mission, const tiles::Zone& zone, std::vector<Polygon> exclusions) {
  std::vector<Polygon> inclusions;
  for (const mission::Fence& fence : mission.fences)
    (fence.inclusion ? inclusions : exclusions).push_back(polygon_of(mission, zone, fence));
  return Fences(std::move(exclusions), std::move(inclusions));
}

}  // namespace landfix::route
