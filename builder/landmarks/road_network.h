// Centrelines as they come from vector data, joined into the graph that the pack's roads layer takes.
#pragma once

#include <cstdint>
#include <vector>

#include "builder/ingest/bounds.h"
#include "tiles/road.h"

namespace landfix::landmarks {

inline constexpr double kRoadTolerance_m = 0.5;  ///< greatest distance between a line and what is stored of it

struct Centreline {
  std::vector<tiles::RoadPoint> points;
  double width_m = 0;
  int layer = 0;  ///< of bridges above 0, of tunnels below
  uint16_t source = 0;
};

/// The roads inside of `bounds`. Positions are those of the 0.25 m lattice. Ends that miss another line by less than
/// kJoinReach_m are joined to it (join_ends). Lines meet where they share a vertex and are of the same layer; an end
/// with nothing of its own layer at it meets the nearest other one, as bridges do with what leads to them. Lines that
/// cross anywhere else do not meet. A segment that is there twice is taken from the line that comes first. Simplified
/// to kRoadTolerance_m between the nodes (Douglas & Peucker 1973). Nodes of two roads of the same width and source are
/// dissolved.
tiles::RoadGraph road_graph(std::vector<Centreline> lines, const ingest::GridBounds& bounds);

}  // namespace landfix::landmarks
