// How well roads that were found agree with roads that are known.
#pragma once

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "builder/ingest/bounds.h"
#include "tiles/geodesy.h"
#include "tiles/road.h"

namespace landfix::eval {

using RoadLine = std::vector<tiles::RoadPoint>;

/// The lines of a vector file (all layers) on a zone's grid. Throws Error: kIo where it cannot be opened, kBadInput
/// where it has no lines or a line lies off the grid.
std::vector<RoadLine> read_road_lines(const std::string& path, const tiles::Zone& zone);

/// Bounding boxes of the polygons of a vector file on a zone's grid; throws likewise.
std::vector<ingest::GridBounds> read_windows(const std::string& path, const tiles::Zone& zone);

/// Points of a vector file on a zone's grid; throws likewise.
std::vector<tiles::RoadPoint> read_intersections(const std::string& path, const tiles::Zone& zone);

/// Ends of lines where three or more meet, within 0.1 m; where lines cross or touch without an end, nothing.
std::vector<tiles::RoadPoint> intersections_of_lines(const std::vector<RoadLine>& lines);

struct RoadScore {
  double true_m = 0, true_found_m = 0;   ///< length of known roads, and of what lies near a found one
  double found_m = 0, found_true_m = 0;  ///< the same for found ones
  size_t true_nodes = 0, found_nodes = 0, matched_nodes = 0;
  double completeness() const { return true_m > 0 ? true_found_m / true_m : 0; }
  double correctness() const { return found_m > 0 ? found_true_m / found_m : 0; }
  double recall() const { return true_nodes > 0 ? double(matched_nodes) / double(true_nodes) : 0; }
  double precision() const { return found_nodes > 0 ? double(matched_nodes) / double(found_nodes) : 0; }
};

/// Completeness and correctness (Wiedemann 1998) in steps of one metre inside of `bounds`, lines within `line_m` of
/// each other; intersections matched one to one, the nearest pairs first, within `node_m`.
RoadScore score_roads(const tiles::RoadGraph& found, const std::vector<RoadLine>& truth,
                      const std::vector<tiles::RoadPoint>& intersections, const ingest::GridBounds& bounds,
                      double line_m, double node_m);

std::string to_text(const RoadScore& score, double line_m, double node_m);
nlohmann::ordered_json to_json(const RoadScore& score);

}  // namespace landfix::eval
