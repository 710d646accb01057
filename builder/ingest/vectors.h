// Known vector data: features of a file that OGR opens, on the zone's grid, one by one.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "builder/ingest/bounds.h"
#include "builder/ingest/source.h"
#include "tiles/geodesy.h"

namespace landfix::ingest {

enum class Shape : uint8_t { kPoint, kLine, kPolygon };

/// A single point, line or polygon of a feature; easting and northing in metres.
struct VectorPart {
  Shape shape = Shape::kPoint;
  std::vector<cv::Point2d> points;  ///< of a polygon: its outer ring, the first point not repeated at the end
  cv::Point2d
      centroid;  ///< of a polygon: of its area without holes; of the box around it where its ring crosses itself
};

/// Fields by name in lower case, without empty ones; those inside GDAL's `other_tags` of OpenStreetMap files as well.
using Tags = std::map<std::string, std::string>;

struct VectorFeature {
  std::string layer;
  Tags tags;
  std::vector<VectorPart> parts;
};

struct VectorFile {
  Source source;
  bool is_openstreetmap = false;  ///< of its own format: whatever it holds, tags say what it is
  std::vector<std::string> warnings;
};

/// Hands every feature that may touch `bounds` to `take`, in the file's order: of one layer, or of all where `layer` is
/// empty. Parts are whole, not clipped; those of geometries that are empty, not finite or off the Earth are left out.
/// Throws Error: kIo for a missing file; kBadInput for what is no vector file, is damaged, an unknown layer, one
/// without CRS, or where all layers lie apart from `bounds`. Warned of: features left out, no features at all, none in
/// `bounds`.
VectorFile read_vectors(const std::string& path, const std::string& layer, const tiles::Zone& zone,
                        const GridBounds& bounds, const std::function<void(const VectorFeature&)>& take);

/// Whether GDAL finds a file of this name.
bool file_exists(const std::string& path);

/// The pairs of a text as `"highway"=>"service","width"=>"4"` (PostgreSQL's hstore) into `tags`, up to what cannot be
/// understood. Tags that are there already stay.
void add_hstore(const std::string& text, Tags& tags);

}  // namespace landfix::ingest
