// Which way to fly so that the position stays known well enough, compared with the straight way and a safer one.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/route/search.h"

namespace landfix::route {

struct SuggestOptions {
  ScoreOptions score;      ///< with the requirement
  double exposure = 0.15;  ///< as CostModel has it: bounds the detour for the sake of good ground
  double safer = 3;        ///< the same for the safer alternative
};

/// One of the routes that are compared.
struct Alternative {
  std::string name;  ///< "straight", "suggested", "safer", "steadiest"
  std::vector<Eigen::Vector2d> points;
  RouteScore score;
  bool allowed = true;  ///< by fences and altitude band
  std::string refused;  ///< why it cannot be flown or scored at all; the score is empty then
};

struct Suggestion {
  /// Straight, suggested, safer; where the requirement cannot be met the one with the least largest error, if that
  /// helps.
  std::vector<Alternative> alternatives;
  bool met = false;         ///< the suggested route meets the requirement everywhere
  std::string explanation;  ///< where and why not, and what the best route reaches; empty where it is met
  const Alternative& suggested() const { return alternatives[1]; }
};

/// Meets the requirement at least cost where a route does, found on the grid with some margin and confirmed by the
/// score; elsewhere the route that misses it over the least length. Throws Error: kNoData where a stop lies off the map
/// or no place around the stops gives fixes, kBadInput where fences and altitude band leave no way at all.
Suggestion suggest(const RouteProblem& problem, const SuggestOptions& options);

/// The places of a mission that a suggestion must keep, in order, and which waypoints they are. Legs within one item of
/// the file (surveys, circles) stay as they are.
struct MissionStops {
  std::vector<Stop> stops;
  std::vector<size_t> waypoints;  ///< index into Mission::waypoints of each stop
};
MissionStops stops_of(const mission::Mission& mission, const tiles::Zone& zone);

/// Points of the suggested route as a ground station takes them: above ground, or (of a level above the ellipsoid, and
/// where `above_sea` asks for it) above sea level. Throws Error (kNoData) where geoid or ground are needed and not
/// known.
std::vector<mission::Place> places_of(const std::vector<Eigen::Vector2d>& points, const RouteProblem& problem,
                                      const tiles::Zone& zone, bool above_sea = false);

/// The mission's file with the suggested detours between its stops (formats .plan and WPL). Throws Error (kUsage) for
/// other formats and for missions that jump: what is in between is flown more than once.
std::string with_detours(const mission::Mission& mission, const MissionStops& stops, const RouteProblem& problem,
                         const Suggestion& suggestion, const tiles::Zone& zone);

nlohmann::ordered_json to_json(const Suggestion& suggestion, const tiles::Zone& zone);

/// The alternatives side by side, and the explanation.
std::string to_text(const Suggestion& suggestion);

}  // namespace landfix::route
