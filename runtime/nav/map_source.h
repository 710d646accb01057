// What localization asks of a map: gray windows and ground heights. A pack answers in flight, an image in memory in
// tests.
#pragma once

#include <optional>
#include <utility>

#include "runtime/features/grid_image.h"
#include "runtime/nav/status.h"

namespace landfix::nav {

class MapSource {
 public:
  virtual ~MapSource() = default;

  /// Finest and coarsest ground sample distance of the gray layer; the levels between them double from one to the next.
  virtual std::pair<double, double> gsd_range_m() const = 0;

  /// The gray window that covers a rectangle at the level of `gsd_m`. Fills `window`, whose buffers are reused where
  /// they are large enough; pixels without data are marked in `valid`, which is empty if there are none. Returns
  /// kOutsideMap if the map has nothing there, kTooLarge, or kMapError if it cannot be read.
  virtual Status read_gray(double west_m, double south_m, double east_m, double north_m, double gsd_m,
                           features::GridImage& window) const = 0;

  /// Ground height above the ellipsoid in metres, or nothing where the map knows none.
  virtual std::optional<double> ground_height_m(double east_m, double north_m) const = 0;
};

}  // namespace landfix::nav
