// The cheapest route over a grid of nodes that keeps the position known well enough.
//
// How well it is known at a node depends on the way there, so the state is a node and a level of uncertainty: of all
// ways to one state the cheapest is kept, with its whole distribution (belief.h), not only its level. The graph of
// these states is made while A* (Boost.Graph) walks it. Levels are 12 % apart, edges lead to 16 neighbours: what is
// found is at most about 3 % longer for the grid, and what the levels hide.
#pragma once

#include <optional>
#include <vector>

#include "tools/route/fences.h"
#include "tools/route/score.h"

namespace landfix::route {

/// A place that the route must pass.
struct Stop {
  Eigen::Vector2d place;
  bool straight = false;  ///< the leg that leads here is not to be changed
};

struct RouteProblem {
  const NavigabilityMap* map = nullptr;
  Vehicle vehicle;
  Heights heights;
  Fences fences;
  std::vector<Stop> stops;  ///< at least two, in their order
  double level_m = 120;     ///< above ground, or above the ellipsoid
  bool above_ground = true;
  double speed_mps = 15;
  double least_agl_m = 0, most_agl_m = 1e5;  ///< the altitude band
  double node_m = 64;                        ///< doubled until the region has no more than 40 000 nodes
};

/// Where a search takes place: the stops' surroundings as far as the map reaches.
Extent region_of(const RouteProblem& problem);

/// What a route costs: its length, more where the requirement is nearly missed, and much more where it is.
struct CostModel {
  Requirement requirement;
  /// A metre counts (1 + exposure · m) metres, m being the probability to miss the radius over the one allowed, up
  /// to 1.
  double exposure = 0.15;
  /// A metre that misses the requirement counts (1 + exposure + missing) metres; infinite: there may be none.
  double missing = 10;

  double of(double length_m, double within) const;
};

struct RouteCost {
  double length_m = 0, cost = 0, missing_m = 0;
};

/// Along straight legs, with images no nearer to each other than the search takes them.
RouteCost cost_of(const RouteProblem& problem, const CostModel& model, const std::vector<Eigen::Vector2d>& points);

/// Whether fences and the altitude band allow a straight leg.
bool allowed(const RouteProblem& problem, const Eigen::Vector2d& from, const Eigen::Vector2d& to);

/// Points from the first stop to the last, one per node; nothing where no way leads there. Throws Error (kNoData) where
/// a stop lies outside of the map.
std::optional<std::vector<Eigen::Vector2d>> cheapest_route(const RouteProblem& problem, const CostModel& model);

/// The same route with fewer corners: corners are left out as long as the cost does not rise by more than 1 % in all.
std::vector<Eigen::Vector2d> straightened(const RouteProblem& problem, const CostModel& model,
                                          std::vector<Eigen::Vector2d> points);

}  // namespace landfix::route
