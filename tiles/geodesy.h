// The only place where degrees become metres: UTM and UPS by GeographicLib, on WGS84.
#pragma once

#include <optional>

namespace landfix::tiles {

/// A UTM zone (1 to 60) or UPS (0), with hemisphere. `north` sets the false northing of UTM and the pole of UPS.
struct Zone {
  int number = 0;
  bool north = true;
  friend bool operator==(const Zone&, const Zone&) = default;
};

bool is_valid(const Zone& zone);

/// EPSG code of the zone: 326zz, 327zz, 32661 or 32761.
int epsg_code(const Zone& zone);

struct Geodetic {
  double latitude_rad = 0, longitude_rad = 0;
};

struct GridPoint {
  double east_m = 0, north_m = 0;
  /// Meridian convergence: the bearing of grid north, clockwise from true north. true heading = grid heading +
  /// convergence.
  double convergence_rad = 0;
  double scale = 1;  ///< grid distance / true distance
};

struct GeodeticPoint {
  double latitude_rad = 0, longitude_rad = 0;
  double convergence_rad = 0;
  double scale = 1;
};

/// The standard zone of a place (with the exceptions of Norway and Svalbard); nullopt for a latitude or longitude out
/// of range.
std::optional<Zone> standard_zone(const Geodetic& place);

/// Projects onto a zone's grid, also beyond the zone's edges. Accurate to nanometres within 3900 km of the central
/// meridian (Karney 2011, 6th order). nullopt where the input is not finite, the zone invalid, or the place farther
/// than 60 degrees of longitude from the central meridian (UTM) or on the other hemisphere (UPS).
std::optional<GridPoint> grid_from_geodetic(const Zone& zone, const Geodetic& place);

/// Inverse of grid_from_geodetic; nullopt for points that it gives for no place, that are not finite or outside the
/// grid's domain.
std::optional<GeodeticPoint> geodetic_from_grid(const Zone& zone, double east_m, double north_m);

}  // namespace landfix::tiles
