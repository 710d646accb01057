#include "tools/route/search_graph.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "builder/error.h"

namespace landfix::route {
namespace {

constexpr double kMostNodes = 40'000;
constexpr int kHypotheses = 5;
constexpr double kFinestRmsM = 0.5, kLevelRatio = 1.12;
constexpr uint16_t kHighestLevel = 100;

/// Steps to the neighbours: king's and knight's moves.
constexpr std::array<std::array<int, 2>, 16> kSteps = {{{1, 0},
                                                        {1, 1},
                                                        {0, 1},
                                                        {-1, 1},
                                                        {-1, 0},
                                                        {-1, -1},
                                                        {0, -1},
                                                        {1, -1},
                                                        {2, 1},
                                                        {1, 2},
                                                        {-1, 2},
                                                        {-2, 1},
                                                        {-2, -1},
                                                        {-1, -2},
                                                        {1, -2},
                                                        {2, -1}}};

uint16_t level_of(const Belief& belief) {
  const double level = std::log(std::max(belief.rms_m() / kFinestRmsM, 1.0)) / std::log(kLevelRatio);
  return uint16_t(std::min(level, double(kHighestLevel)));
}

}  // namespace

double search_spacing_m(const RouteProblem& problem, double agl_m) {
  return std::max(problem.vehicle.image_spacing_m(problem.speed_mps),
                  std::min(problem.vehicle.independent_m(agl_m), problem.node_m / 2));
}

NodeGrid::NodeGrid(const RouteProblem& problem)
    : problem_(problem), region_(region_of(problem)), node_m_(problem.node_m) {
  const double width_m = region_.east_m - region_.west_m, height_m = region_.north_m - region_.south_m;
  while ((width_m / node_m_ + 1) * (height_m / node_m_ + 1) > kMostNodes) node_m_ *= 2;
  columns_ = uint32_t(width_m / node_m_) + 1;
  rows_ = uint32_t(height_m / node_m_) + 1;
  nodes_.resize(size_t(columns_) * rows_);
}

Eigen::Vector2d NodeGrid::place(uint32_t node) const {
  return {region_.west_m + node % columns_ * node_m_, region_.south_m + node / columns_ * node_m_};
}

uint32_t NodeGrid::nearest(const Eigen::Vector2d& place) const {
  const auto index = [&](double offset_m, uint32_t count) {
    return uint32_t(std::clamp<double>(std::round(offset_m / node_m_), 0, count - 1));
  };
  return index(place.y() - region_.south_m, rows_) * columns_ + index(place.x() - region_.west_m, columns_);
}

NodeGrid::Node& NodeGrid::at(uint32_t index) {
  Node& node = nodes_[index];
  if (node.known) return node;
  node.known = true;
  const Eigen::Vector2d p = place(index);
  const std::optional<double> ground = problem_.heights.ground_m(p.x(), p.y());
  node.agl_m = problem_.above_ground ? problem_.level_m : ground ? problem_.level_m - *ground : NAN;
  if (!(node.agl_m >= problem_.least_agl_m && node.agl_m <= problem_.most_agl_m)) node.agl_m = NAN;
  return node;
}

double NodeGrid::agl_m(uint32_t node) { return at(node).agl_m; }

const View& NodeGrid::view(uint32_t index, double filter_sigma_m) {
  Node& node = at(index);
  const double search = search_m(problem_.vehicle, filter_sigma_m, node.agl_m);
  for (const View& view : node.views)
    if (view.search_m == search) return view;
  const Eigen::Vector2d p = place(index);
  node.views.push_back(view_at(*problem_.map, problem_.vehicle, p.x(), p.y(), node.agl_m, search));
  return node.views.back();
}

StateGraph::StateGraph(const RouteProblem& problem, const CostModel& model)
    : problem_(problem), model_(model), grid_(problem) {
  for (const Stop& stop : problem.stops) {
    if (!problem.map->extent().holds(stop.place.x(), stop.place.y())) {
      throw Error(ExitCode::kNoData, fmt::format("route: expected places on the map, found east {:.0f}, north {:.0f}; "
                                                 "choose others, or the map of this area",
                                                 stop.place.x(), stop.place.y()));
    }
    stop_nodes_.push_back(grid_.nearest(stop.place));
  }
  rest_m_.assign(stop_nodes_.size(), 0);
  for (size_t i = stop_nodes_.size() - 1; i > 0; --i)
    rest_m_[i - 1] = rest_m_[i] + (grid_.place(stop_nodes_[i]) - grid_.place(stop_nodes_[i - 1])).norm();
  State& first = states_[vertex_of(stop_nodes_[0], 0, 0)];
  first.belief.emplace(problem.vehicle.errors, kHypotheses);
  first.cost = 0;
}

uint32_t StateGraph::vertex_of(uint32_t node, uint16_t stage, uint16_t level) const {
  const uint64_t key = uint64_t(node) << 32 | uint64_t(stage) << 16 | level;
  const auto [entry, is_new] = vertices_.try_emplace(key, uint32_t(states_.size()));
  if (is_new) {
    State& state = states_.emplace_back();
    state.node = node;
    state.stage = stage;
    state.level = level;
    state.before = entry->second;
  }
  return entry->second;
}

double StateGraph::least_cost_to_goal(uint32_t vertex) const {
  const State& s = states_[vertex];
  if (is_goal(vertex)) return 0;
  return (grid_.place(stop_nodes_[s.stage + 1u]) - grid_.place(s.node)).norm() + rest_m_[s.stage + 1u];
}

const std::vector<StateGraph::edge_descriptor>& StateGraph::expand(uint32_t vertex) const {
  edges_.clear();
  candidates_.clear();
  const uint32_t node = states_[vertex].node;
  const uint16_t stage = states_[vertex].stage, level = states_[vertex].level;
  const auto [best, is_first] = expanded_.try_emplace(uint64_t(node) << 32 | stage, level);
  if (!is_first) {
    if (best->second <= level) return edges_;
    best->second = level;
  }
  if (problem_.stops[stage + 1u].straight || stop_nodes_[stage + 1u] == node) {
    try_edge(vertex, stop_nodes_[stage + 1u]);
    return edges_;
  }
  const int column = int(node % grid_.columns()), row = int(node / grid_.columns());
  for (const auto& [east, north] : kSteps) {
    const int x = column + east, y = row + north;
    if (x >= 0 && y >= 0 && x < int(grid_.columns()) && y < int(grid_.rows()))
      try_edge(vertex, uint32_t(y) * grid_.columns() + uint32_t(x));
  }
  return edges_;
}

void StateGraph::try_edge(uint32_t source, uint32_t node) const {
  const State& from = states_[source];
  const bool straight = problem_.stops[from.stage + 1u].straight;
  if (!straight && !allowed(problem_, grid_.place(from.node), grid_.place(node))) return;
  Belief belief = *from.belief;
  const std::optional<double> cost = fly(belief, from.node, node);
  if (!cost) return;
  const uint16_t stage = uint16_t(from.stage + (node == stop_nodes_[from.stage + 1u]));
  const uint32_t target = vertex_of(node, stage, level_of(belief));
  edges_.push_back({source, target, *cost, uint32_t(candidates_.size())});
  candidates_.push_back(std::move(belief));
}

std::optional<double> StateGraph::fly(Belief& belief, uint32_t from, uint32_t to) const {
  const Eigen::Vector2d a = grid_.place(from), b = grid_.place(to);
  const double length_m = (b - a).norm(), first_agl_m = grid_.agl_m(from);
  if (!std::isfinite(first_agl_m)) return std::nullopt;
  const int looks = std::max(1, int(std::ceil(length_m / search_spacing_m(problem_, first_agl_m) - 1e-9)));
  double cost = 0;
  for (int i = 1; i <= looks; ++i) {
    const uint32_t node = grid_.nearest(a + (b - a) * (double(i) / looks));
    const double agl_m = grid_.agl_m(node), step_m = length_m / looks;
    if (!std::isfinite(agl_m)) return std::nullopt;
    belief.fly(step_m, agl_m, problem_.vehicle.errors);
    belief.look([&](double sigma_m) -> const View& { return grid_.view(node, sigma_m); },
                outcome_correlation(step_m, problem_.vehicle.footprint_m(agl_m)),
                problem_.vehicle.independent_m(agl_m));
    cost += model_.of(step_m, belief.within(model_.requirement.radius_m));
  }
  return std::isfinite(cost) ? std::optional(cost) : std::nullopt;
}

std::vector<Eigen::Vector2d> StateGraph::route_to(uint32_t vertex) const {
  std::vector<Eigen::Vector2d> points;
  for (uint32_t v = vertex;; v = states_[v].before) {
    const State& s = states_[v];
    // A stop's own place instead of the node next to it.
    const bool is_stop = v == start() || states_[s.before].stage != s.stage;
    points.push_back(is_stop ? problem_.stops[s.stage].place : grid_.place(s.node));
    if (v == start()) break;
  }
  std::reverse(points.begin(), points.end());
  return points;
}

}  // namespace landfix::route
