// Vertical datums: their names, and what PROJ knows about them.
#pragma once

#include <ogr_spatialref.h>
#include <tbb/enumerable_thread_specific.h>

#include <memory>
#include <string>

#include "builder/error.h"
#include "builder/ingest/bounds.h"
#include "tiles/geodesy.h"

namespace landfix::ingest {

inline constexpr const char* kEllipsoid = "ellipsoid";
inline constexpr const char* kEgm96 = "egm96";

/// "ellipsoid", "egm96" or "EPSG:n" of a vertical CRS in its one spelling ("EPSG:5773" is "egm96", a geographic 3D CRS
/// is "ellipsoid"). Throws Error (`code`) for anything else; `where` begins the message.
std::string parse_datum(const std::string& text, ExitCode code, const std::string& where);

/// The vertical datum of a compound or 3D CRS; empty where it says nothing that has a name.
std::string datum_of(const OGRSpatialReference& crs);

/// Metres per unit of height of a datum's CRS.
double metres_per_unit(const std::string& datum);

/// Heights above a datum at places on a zone's grid, converted to heights above the WGS84 ellipsoid by PROJ's best
/// transformation, never by a ballpark one. Safe to use from many threads.
class VerticalTransformation {
 public:
  /// `datum` as parse_datum returns it. Throws Error (kBadInput) where PROJ has no transformation at `area`'s centre,
  /// naming missing grid files.
  VerticalTransformation(const std::string& datum, const tiles::Zone& zone, const GridBounds& area,
                         const std::string& where);

  /// Height above the ellipsoid = shift + scale * height above the datum. In: places; out: `x` the shift in metres, `y`
  /// the scale; NaN outside the transformation's grid files.
  void shift_and_scale(int count, double* x, double* y) const;

 private:
  std::unique_ptr<OGRCoordinateTransformation> transformation() const;

  OGRSpatialReference source_, target_;
  mutable tbb::enumerable_thread_specific<std::unique_ptr<OGRCoordinateTransformation>> transformations_;
};

}  // namespace landfix::ingest
