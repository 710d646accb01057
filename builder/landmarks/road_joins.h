// Ends of centrelines that miss the line that they belong to by a little, as agencies' data often has them.
#pragma once

#include <vector>

#include "builder/landmarks/road_network.h"

namespace landfix::landmarks {

inline constexpr double kJoinReach_m = 0.5;  ///< an end that is farther from a line does not meet it

/// Moves every end of a line that lies within kJoinReach_m of another line to that line's nearest vertex within reach,
/// else to the nearest place on it, which becomes a vertex. Bridges and what lies below them are of different `layer`:
/// between these only ends meet ends. Lines that cross without an end nearby stay as they are, and no line meets
/// itself.
void join_ends(std::vector<Centreline>& lines, const ingest::GridBounds& bounds);

}  // namespace landfix::landmarks
