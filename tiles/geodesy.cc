#include "tiles/geodesy.h"

#include <GeographicLib/PolarStereographic.hpp>
#include <GeographicLib/TransverseMercator.hpp>
#include <GeographicLib/UTMUPS.hpp>
#include <cmath>
#include <numbers>

#include "tiles/grid.h"

namespace landfix::tiles {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kUtmFalseEasting = 500e3, kUtmFalseNorthingSouth = 10000e3, kUpsFalse = 2000e3;
constexpr double kFarthestLongitudeDeg = 60;
constexpr double kInverseErrorM = 1e-3;

double central_meridian_deg(const Zone& zone) { return 6.0 * zone.number - 183.0; }

}  // namespace

bool is_valid(const Zone& zone) { return zone.number >= 0 && zone.number <= 60; }

int epsg_code(const Zone& zone) {
  if (zone.number == 0) return zone.north ? 32661 : 32761;
  return (zone.north ? 32600 : 32700) + zone.number;
}

std::optional<Zone> standard_zone(const Geodetic& p) {
  const double latitude = p.latitude_rad / kDegree, longitude = p.longitude_rad / kDegree;
  if (!(std::abs(latitude) <= 90) || !(std::abs(longitude) <= 540)) return std::nullopt;
  return Zone{GeographicLib::UTMUPS::StandardZone(latitude, longitude), latitude >= 0};
}

std::optional<GridPoint> grid_from_geodetic(const Zone& zone, const Geodetic& p) {
  const double latitude = p.latitude_rad / kDegree, longitude = p.longitude_rad / kDegree;
  if (!is_valid(zone) || !(std::abs(latitude) <= 90) || !(std::abs(longitude) <= 540)) return std::nullopt;
  double east, north, convergence, scale;
  if (zone.number == 0) {
    if (zone.north ? latitude < 0 : latitude > 0) return std::nullopt;
    GeographicLib::PolarStereographic::UPS().Forward(zone.north, latitude, longitude, east, north, convergence, scale);
    return GridPoint{east + kUpsFalse, north + kUpsFalse, convergence * kDegree, scale};
  }
  const double from_meridian = std::remainder(longitude - central_meridian_deg(zone), 360.0);
  if (std::abs(from_meridian) > kFarthestLongitudeDeg) return std::nullopt;
  GeographicLib::TransverseMercator::UTM().Forward(0, latitude, from_meridian, east, north, convergence, scale);
  return GridPoint{east + kUtmFalseEasting, north + (zone.north ? 0 : kUtmFalseNorthingSouth), convergence * kDegree,
                   scale};
}

std::optional<GeodeticPoint> geodetic_from_grid(const Zone& zone, double east_m, double north_m) {
  if (!is_valid(zone) || !(std::abs(east_m) < kDomainHalf) || !(std::abs(north_m) < kDomainHalf)) return std::nullopt;
  double latitude, longitude, convergence, scale;
  if (zone.number == 0) {
    GeographicLib::PolarStereographic::UPS().Reverse(zone.north, east_m - kUpsFalse, north_m - kUpsFalse, latitude,
                                                     longitude, convergence, scale);
  } else {
    GeographicLib::TransverseMercator::UTM().Reverse(central_meridian_deg(zone), east_m - kUtmFalseEasting,
                                                     north_m - (zone.north ? 0 : kUtmFalseNorthingSouth), latitude,
                                                     longitude, convergence, scale);
  }
  // Far outside of where the projection is one to one, its inverse still answers something: believe only what leads
  // back.
  const auto forward = grid_from_geodetic(zone, {latitude * kDegree, longitude * kDegree});
  if (!forward || std::hypot(forward->east_m - east_m, forward->north_m - north_m) > kInverseErrorM)
    return std::nullopt;
  return GeodeticPoint{latitude * kDegree, longitude * kDegree, convergence * kDegree, scale};
}

}  // namespace landfix::tiles
