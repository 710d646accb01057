// What localization asks of a map: windows of its layers, ground heights and dates. A pack answers in flight, an image
// in memory in tests.
#pragma once

#include <optional>
#include <utility>

#include "runtime/features/grid_image.h"
#include "runtime/nav/status.h"

namespace landfix::nav {

/// The raster layers that a camera image can be matched with.
enum class MapLayer {
  kGray,        ///< CV_8UC1, luma
  kEdge,        ///< CV_8UC1, gradient magnitude
  kContour,     ///< CV_8UC1, 1 + truncated distance to the nearest contour in pixels
  kOrientation  ///< CV_8SC2, doubled-angle orientation (a, b), each −2 to 2
};

/// Days since 1970-01-01 of the oldest and newest image that a piece of the map was made from.
struct CaptureDays {
  int oldest = 0, newest = 0;
};

class MapSource {
 public:
  virtual ~MapSource() = default;

  /// Finest and coarsest ground sample distance of a layer, {0, 0} where the map has none; the levels between them
  /// double from one to the next.
  virtual std::pair<double, double> gsd_range_m(MapLayer layer) const = 0;

  /// The window of a layer that covers a rectangle at the level of `gsd_m`. Fills `window`, whose buffers are reused
  /// where they are large enough; pixels without data are marked in `valid`, which is empty if there are none. Returns
  /// kOutsideMap if the map has nothing there, kNoLayer, kTooLarge, or kMapError if it cannot be read.
  virtual Status read(MapLayer layer, double west_m, double south_m, double east_m, double north_m, double gsd_m,
                      features::GridImage& window) const = 0;

  /// Ground height above the ellipsoid in metres, or nothing where the map knows none.
  virtual std::optional<double> ground_height_m(double east_m, double north_m) const = 0;

  /// Ground heights above the ellipsoid over a rectangle: CV_32FC1, NaN where unknown, at the coarsest level not
  /// coarser than `gsd_m`, or the finest. kNoLayer where the map has no heights, kOutsideMap, kTooLarge, kMapError.
  virtual Status read_heights(double west_m, double south_m, double east_m, double north_m, double gsd_m,
                              features::GridImage& heights) const {
    (void)west_m, (void)south_m, (void)east_m, (void)north_m, (void)gsd_m, (void)heights;
    return Status::kNoLayer;
  }

  /// When the images were taken that show a rectangle; nothing where the map does not say.
  virtual std::optional<CaptureDays> capture_days(double west_m, double south_m, double east_m, double north_m) const {
    (void)west_m, (void)south_m, (void)east_m, (void)north_m;
    return std::nullopt;
  }
};

}  // namespace landfix::nav
