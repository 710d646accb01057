// A procedural world to test in: farmland, villages, woods and lakes on rolling ground, drawn as orthophoto and
// heights, with the truth about every object, in any season, year and sun.
//
// The world is endless and a pure function of its seed and of grid coordinates: a window drawn alone has the same bytes
// as the same pixels of a larger one, a larger world contains the smaller ones, and what is drawn does not depend on
// threads. Season, year and sun change colours and shadows, never geometry or heights.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "runtime/features/grid_image.h"
#include "tools/synth/objects.h"
#include "tools/synth/season.h"

namespace landfix::synth {

struct WorldOptions {
  uint64_t seed = 1;
  int zone = 33;             ///< UTM zone, WGS84
  bool south = false;        ///< southern hemisphere
  double west_m = 500000;    ///< easting of the south-western corner
  double south_m = 5400000;  ///< northing of the south-western corner
  double size_m = 2000;      ///< both sides
  double gsd_m = 0.5;        ///< of the orthophoto
  double dem_gsd_m = 1;      ///< of DTM and DSM
  Season season = Season::kSummer;
  int year = 2020;               ///< crops rotate from year to year
  bool snow = false;             ///< in winter
  double sun_azimuth_deg = 150;  ///< from grid north, clockwise
  double sun_elevation_deg = 45;
  double base_height_m = 320;  ///< mean height of the ground above the ellipsoid
  double relief_m = 25;        ///< hills and valleys lie about this much above and below the mean, kilometres apart
  bool near_infrared = false;  ///< a fourth band
  bool varied_roads = false;   ///< carriageways apart, shoulders, roundabouts, tracks of different width
};

/// Throws Error(kBadInput) that names the value, the range and what to do.
void check(const WorldOptions& options);

/// Pixels to draw. The edges are rounded to whole multiples of the GSD from the zone's origin; the image says where it
/// lies.
struct Window {
  double west_m = 0, north_m = 0;
  int width = 0, height = 0;
  double gsd_m = 1;
};

/// What stands or lies in an area, in grid coordinates; objects that cross its edge are whole.
struct Labels {
  std::vector<Building> buildings;
  std::vector<Tree> trees;
  std::vector<Road> roads;
  std::vector<Intersection> intersections;
  std::vector<Field> fields;
  std::vector<Lake> water;
};

class Ground;
class Plan;

/// Safe to use from many threads at once.
class World {
 public:
  /// Throws as `check` does.
  explicit World(const WorldOptions& options);
  ~World();

  const WorldOptions& options() const { return options_; }
  Rectangle extent() const;

  /// CV_8UC3 red, green, blue, or CV_8UC4 with near infrared.
  features::GridImage ortho(const Window& window) const;
  /// CV_32FC1, metres above the ellipsoid: the bare ground, or with all that stands on it.
  features::GridImage dtm(const Window& window) const;
  features::GridImage dsm(const Window& window) const;
  /// Both at once, for the price of one: {dtm, dsm}.
  std::pair<features::GridImage, features::GridImage> heights(const Window& window) const;

  /// Objects whose bounding box touches `area`; trees and intersections that lie in it.
  Labels labels(const Rectangle& area) const;

 private:
  WorldOptions options_;
  std::unique_ptr<const Ground> ground_;
  std::unique_ptr<const Plan> plan_;
};

struct WriteOptions {
  int threads = 0;                          ///< 0: as many as there are cores
  std::function<void(double)> on_progress;  ///< called with the share that is done, 0 to 1
};

struct WriteSummary {
  std::vector<std::filesystem::path> files;
  int64_t ortho_pixels = 0, height_pixels = 0;
  int64_t buildings = 0, trees = 0, roads = 0, intersections = 0, fields = 0, water = 0;
};

/// Draws the world into `directory` (made if missing):
///   ortho.tif, dtm.tif, dsm.tif   tiled GeoTIFF in UTM (EPSG:326xx or 327xx); heights are above the ellipsoid, which
///   the
///                                 metadata item LANDFIX_VERTICAL_DATUM=ellipsoid says
///   ortho.tif.json                date, licence, attribution
///   buildings, trees, roads, intersections, fields, water .geojson
///                                 truth in longitude and latitude (RFC 7946); properties repeat the centre on the grid
/// Files get their names when all are complete. Memory is bounded by the tiles in flight. Throws Error(kBadInput, kIo).
WriteSummary write_world(const WorldOptions& options, const std::filesystem::path& directory,
                         const WriteOptions& how = {});

}  // namespace landfix::synth
