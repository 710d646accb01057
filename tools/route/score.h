// How well the position will be known along a route that is flown without GNSS: where it is poor, and why.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/route/path.h"

namespace landfix::route {

/// "10m@95%": the error stays below the radius with this probability.
struct Requirement {
  double radius_m = 10;
  double confidence = 0.95;
};

/// Reads "10m@95%". Throws Error (kUsage).
Requirement parse_requirement(const std::string& text);

struct ScoreOptions {
  Requirement requirement;
  double corridor_m = 50;  ///< half its width
  int flights = 2000;      ///< drawn for the chance of staying in it; 0: not asked
  uint64_t seed = 1;
};

/// At an image, after it was taken in.
struct ScoredPoint {
  Station station;
  double fix_probability = 0, false_probability = 0;
  Eigen::Matrix2d covariance_m2;  ///< of the estimate's error
  double rms_m = 0;
  double radius_m = 0;  ///< that the error does not exceed with the required confidence
  double within = 0;    ///< probability that the error is below the required radius
  uint32_t reasons = 0;
  std::optional<Repeat> repeat;
};

/// A part of the route.
struct Stretch {
  double start_m = 0, end_m = 0, start_s = 0, end_s = 0;
  double radius_m = 0;  ///< largest in it
  std::string reason;   ///< in words; empty where nothing is known to be poor
  double length_m() const { return end_m - start_m; }
  double duration_s() const { return end_s - start_s; }
};

struct LegScore {
  Leg leg;
  double rms_m = 0, radius_m = 0;  ///< largest
  double fix_probability = 0;      ///< mean
  double meeting = 0;              ///< share of its length that meets the requirement
  std::string reason;              ///< of what is poor in it
};

struct RouteScore {
  std::string name;
  Requirement requirement;
  double length_m = 0, duration_s = 0;
  double mean_agl_m = 0, footprint_m = 0;  ///< of the mean height
  std::vector<ScoredPoint> points;
  std::vector<LegScore> legs;
  double rms_m = 0;  ///< over the whole route
  double largest_rms_m = 0, largest_radius_m = 0;
  double meeting = 0;   ///< share of the route where the error stays within the radius with the required confidence
  double within = 0;    ///< expected share of the time in which the error is below the radius
  double on_map = 0;    ///< share of the route of which the map knows something
  bool met = false;     ///< everywhere
  Stretch worst;        ///< around the largest radius: not meeting, or where all meet at least 0.9 times that radius
  Stretch longest_gap;  ///< images with a chance of a fix below one half; of no length where there are none
  double corridor_m = 0;
  std::optional<double> in_corridor;  ///< chance never to leave it; where asked for
  double corridor_error = 0;          ///< standard error of that chance
};

/// Throws Error (kNoData) where the map knows nothing of any part of the path. A path partly on it is scored: elsewhere
/// there are no fixes.
RouteScore score(const Path& path, const NavigabilityMap& map, const Vehicle& vehicle,
                 const ScoreOptions& options = {});

/// Numbers to the millimetre; at most `most_points` points, evenly chosen; places in degrees.
nlohmann::ordered_json to_json(const RouteScore& score, const tiles::Zone& zone, size_t most_points = 2000);

/// A table per leg and the summary, lines ending in "\n".
std::string to_text(const RouteScore& score);

}  // namespace landfix::route
