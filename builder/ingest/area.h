// The area of interest of a build, as a shape on the zone's grid.
#pragma once

#include <memory>
#include <string>

#include "builder/ingest/bounds.h"
#include "builder/ingest/image_set.h"
#include "tiles/geodesy.h"
#include "tiles/grid.h"

namespace landfix::ingest {

/// Immutable; safe to query from many threads.
class Area {
 public:
  /// The union of the images' footprints.
  static Area of_images(const ImageSet& images);
  /// The polygons of all layers of a vector file (anything OGR opens), reprojected and densified. Throws Error: kIo for
  /// a missing file; kBadInput for no polygon, no CRS, an invalid polygon, or one that the zone's grid cannot hold.
  static Area from_file(const std::string& path, const tiles::Zone& zone);
  /// "W,S,E,N" in degrees on WGS84; W > E crosses the antimeridian. Throws Error (kUsage).
  static Area from_bbox(const std::string& text, const tiles::Zone& zone);

  /// Throws Error (kNoData) where the area does not touch any image.
  void require_overlap(const ImageSet& images) const;

  const GridBounds& bounds() const;
  /// Whether the shape itself (not only its bounds) touches the tile or rectangle.
  bool touches(const tiles::TileIndex& tile) const;
  bool touches(const GridBounds& rectangle) const;

 private:
  struct Shape;
  explicit Area(std::shared_ptr<const Shape> shape);
  std::shared_ptr<const Shape> shape_;
};

}  // namespace landfix::ingest
