// Landmarks and roads that are known already: from OpenStreetMap or the layers of an agency, preferred to what could be
// found in images.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "builder/ingest/bounds.h"
#include "builder/ingest/source.h"
#include "builder/landmarks/kinds.h"
#include "tiles/geodesy.h"
#include "tiles/landmark.h"
#include "tiles/road.h"

namespace landfix::landmarks {

struct VectorInput {
  std::string path;
  std::string layer;         ///< empty: all of the file
  std::optional<Kind> kind;  ///< absent: by tags, else by the layer's name
};

/// "FILE[:LAYER][=KIND]". A name that is a file is taken as one, whatever it is made of. Throws Error (kUsage) for an
/// unknown kind.
VectorInput parse_input(const std::string& text);

/// What a part of this shape of a feature is: as the input says, else by tags, else by the layer's name; nullopt
/// where these are of nothing that is known here, or nothing says it.
std::optional<Kind> kind_of(const VectorInput& input, const ingest::VectorFeature& feature, ingest::Shape shape);

/// What the inputs know of a place.
struct Known {
  std::vector<ingest::Source>
      sources;  ///< one for each input; Landmark::source and RoadEdge::source count from 1 in it
  std::vector<tiles::Landmark> landmarks;
  tiles::RoadGraph roads;
  bool has_landmarks = false, has_roads = false;  ///< the inputs tell of such features, be it outside of the map
  std::vector<std::string> warnings;
};

/// Reads all inputs. Landmarks are those with their centre inside of `bounds`, whole, each once (add_new(): where two
/// inputs tell of one, the first counts), without distinctiveness: more may come from elsewhere. Roads are cut there.
/// Polygons become their smallest enclosing rectangle, of which buildings have the centre; others have that of their
/// area. Points have the size that fields say (length_m and width_m, or radius_m or diameter_crown), else the usual one
/// of their kind. Throws Error as ingest::read_vectors, and kBadInput for a file that nothing says the kinds of.
Known read_known(const std::vector<VectorInput>& inputs, const tiles::Zone& zone, const ingest::GridBounds& bounds);

/// "123 buildings, 4 fields"; "nothing" for none.
std::string text_of(const std::vector<tiles::Landmark>& landmarks);
/// "4.5 km, 12 intersections", of the graphs of tiles.
std::string text_of(const std::vector<tiles::RoadGraph>& roads);

}  // namespace landfix::landmarks
