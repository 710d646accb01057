#include "tools/route/search.h"

#include <algorithm>
#include <boost/graph/astar_search.hpp>
#include <boost/property_map/function_property_map.hpp>
#include <cmath>

#include "tools/route/search_graph.h"

namespace landfix::route {
namespace {

constexpr double kLeastMarginM = 1500, kMarginShare = 0.5;  ///< of the region around the stops
constexpr double kCostOfFewerCorners = 1.01;

struct Found {
  uint32_t vertex;
};

/// Boost's way to stop at a vertex is to throw.
struct Visitor : boost::default_astar_visitor {
  void examine_vertex(uint32_t vertex, const StateGraph& graph) const {
    if (graph.is_goal(vertex)) throw Found{vertex};
  }
  void edge_relaxed(const StateGraph::edge_descriptor& edge, const StateGraph& graph) const { graph.take(edge); }
};

bool is_stop(const RouteProblem& problem, const Eigen::Vector2d& point) {
  return std::any_of(problem.stops.begin(), problem.stops.end(), [&](const Stop& s) { return s.place == point; });
}

}  // namespace

Extent region_of(const RouteProblem& problem) {
  Extent box{problem.stops[0].place.x(), problem.stops[0].place.y(), problem.stops[0].place.x(),
             problem.stops[0].place.y()};
  for (const Stop& s : problem.stops) {
    box.west_m = std::min(box.west_m, s.place.x());
    box.east_m = std::max(box.east_m, s.place.x());
    box.south_m = std::min(box.south_m, s.place.y());
    box.north_m = std::max(box.north_m, s.place.y());
  }
  const double margin_m =
      std::max(kLeastMarginM, kMarginShare * std::max(box.east_m - box.west_m, box.north_m - box.south_m));
  const Extent map = problem.map->extent();
  return {std::max(box.west_m - margin_m, map.west_m), std::max(box.south_m - margin_m, map.south_m),
          std::min(box.east_m + margin_m, map.east_m), std::min(box.north_m + margin_m, map.north_m)};
}

double CostModel::of(double length_m, double within) const {
  const double miss = (1 - within) / (1 - requirement.confidence);
  return miss > 1 ? length_m * (1 + exposure + missing) : length_m * (1 + exposure * miss);
}

bool allowed(const RouteProblem& problem, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  if (!problem.fences.allow(from, to)) return false;
  const int steps = std::max(1, int(std::ceil((to - from).norm() / (problem.node_m / 2))));
  for (int i = 0; i <= steps && !problem.above_ground; ++i) {
    const Eigen::Vector2d p = from + (to - from) * (double(i) / steps);
    const std::optional<double> ground = problem.heights.ground_m(p.x(), p.y());
    const double agl_m = ground ? problem.level_m - *ground : NAN;
    if (!(agl_m >= problem.least_agl_m && agl_m <= problem.most_agl_m)) return false;
  }
  return true;
}

RouteCost cost_of(const RouteProblem& problem, const CostModel& model, const std::vector<Eigen::Vector2d>& points) {
  const Path path =
      path_through("route", points, problem.level_m, problem.above_ground, problem.speed_mps, problem.heights);
  const Vehicle& vehicle = problem.vehicle;
  Belief belief(vehicle.errors, 8);
  RouteCost cost;
  cost.length_m = path.length_m();
  const double spacing_m = search_spacing_m(problem, path.at(0).agl_m);
  for (const Image& image : images_along(path, *problem.map, vehicle, spacing_m)) {
    const double agl_m = image.station().agl_m;
    belief.fly(image.flown_m(), agl_m, vehicle.errors);
    belief.look([&](double sigma_m) -> const View& { return image.view(sigma_m); },
                outcome_correlation(image.flown_m(), vehicle.footprint_m(agl_m)), vehicle.independent_m(agl_m));
    const double within = belief.within(model.requirement.radius_m);
    cost.cost += model.of(image.flown_m(), within);
    if (within < model.requirement.confidence) cost.missing_m += image.flown_m();
  }
  return cost;
}

std::optional<std::vector<Eigen::Vector2d>> cheapest_route(const RouteProblem& problem, const CostModel& model) {
  const StateGraph graph(problem, model);
  using Edge = StateGraph::edge_descriptor;
  const auto cost =
      boost::make_function_property_map<uint32_t, double&>([&](uint32_t v) -> double& { return graph.state(v).cost; });
  const auto rank =
      boost::make_function_property_map<uint32_t, double&>([&](uint32_t v) -> double& { return graph.state(v).rank; });
  const auto before = boost::make_function_property_map<uint32_t, uint32_t&>(
      [&](uint32_t v) -> uint32_t& { return graph.state(v).before; });
  const auto weight = boost::make_function_property_map<Edge, double>([](const Edge& e) { return e.cost; });
  try {
    boost::astar_search_no_init_tree(
        graph, graph.start(), [&](uint32_t v) { return graph.least_cost_to_goal(v); }, Visitor(), before, rank, cost,
        weight, std::less<double>(), std::plus<double>(), std::numeric_limits<double>::infinity(), 0.0);
  } catch (const Found& found) {
    return graph.route_to(found.vertex);
  }
  return std::nullopt;
}

std::vector<Eigen::Vector2d> straightened(const RouteProblem& problem, const CostModel& model,
                                          std::vector<Eigen::Vector2d> points) {
  RouteCost now = cost_of(problem, model, points);
  const double most = kCostOfFewerCorners * now.cost;
  for (size_t from = 0; from + 2 < points.size(); ++from) {
    size_t last = from + 1;
    while (last + 1 < points.size() && !is_stop(problem, points[last])) ++last;
    for (size_t to = last; to > from + 1; to -= std::max<size_t>(1, (to - from) / 8)) {
      if (!allowed(problem, points[from], points[to])) continue;
      std::vector<Eigen::Vector2d> shorter(points.begin(), points.begin() + long(from) + 1);
      shorter.insert(shorter.end(), points.begin() + long(to), points.end());
      const RouteCost then = cost_of(problem, model, shorter);
      if (!(then.cost <= std::max(now.cost, most) && then.missing_m <= now.missing_m)) continue;
      points = std::move(shorter);
      now = then;
      break;
    }
  }
  return points;
}

}  // namespace landfix::route
