// From which height a route is flown best: higher, the camera sees more ground, but its pixels are coarser, attitude
// errors weigh more, and the filter waits longer for ground that is new (DeAngelo 2025's trade).
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/route/score.h"

namespace landfix::route {

struct AltitudeRow {
  double agl_m = 0, footprint_m = 0, camera_gsd_m = 0;
  double fix_probability = 0;  ///< mean along the route
  RouteScore score;
};

struct AltitudeComparison {
  std::vector<AltitudeRow> rows;  ///< as asked for
  size_t best = 0;                ///< the largest share that meets the requirement; of equals the smallest error
};

/// Makes the path at a height above ground.
using PathAt = std::function<Path(double agl_m)>;

/// Throws Error (kUsage) for no heights, and as `score` does.
AltitudeComparison compare_altitudes(const PathAt& path_at, const std::vector<double>& heights_agl_m,
                                     const NavigabilityMap& map, const Vehicle& vehicle, const ScoreOptions& options);

nlohmann::ordered_json to_json(const AltitudeComparison& comparison);
std::string to_text(const AltitudeComparison& comparison);

}  // namespace landfix::route
