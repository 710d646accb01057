// A height raster of any CRS and vertical datum as metres above the WGS84 ellipsoid on the pack's grid.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "builder/ingest/pixel_window.h"
#include "builder/ingest/source.h"
#include "runtime/features/grid_image.h"
#include "tiles/geodesy.h"
#include "tiles/grid.h"

namespace landfix::ingest {

/// One DEM (a VRT joins several). Its vertical datum is known from the options, the sidecar's "datum", the file's
/// compound or 3D CRS or its metadata item LANDFIX_VERTICAL_DATUM, in this order, and never guessed. Safe to read from
/// many threads at once. A pixel's value does not depend on the window it is read with.
class ElevationModel {
 public:
  /// Throws Error: kIo for a missing file; kBadInput for no georeference, no CRS, rotated, more than one band, vertical
  /// datum unknown (says how to give it) or not convertible without a grid file that PROJ lacks (names it); kUsage for
  /// a malformed datum option.
  ElevationModel(const SourceOptions& file, const tiles::Zone& zone);
  ~ElevationModel();
  ElevationModel(ElevationModel&&) noexcept;
  ElevationModel& operator=(ElevationModel&&) noexcept;

  const Source& source() const;
  double gsd_m() const { return source().gsd_m; }
  const std::vector<std::string>& warnings() const;  ///< a datum of the options that contradicts the file, for instance

  /// Throws Error (kNoData) where the raster's bounds do not overlap `area`.
  void require_overlap(const GridBounds& area) const;

  /// CV_32FC1 metres above the WGS84 ellipsoid (0 where not valid) and mask (all 0 outside the raster). Resampled like
  /// images; the shift between datums is exact to 0.5 mm at the check points of smooth_map.h. Throws like
  /// ImageSet::read, and kBadInput where the datum's grid files end.
  features::GridImage read(const tiles::PixelRect& rect) const { return read(window_of(rect)); }
  features::GridImage read(const PixelWindow& window) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace landfix::ingest
