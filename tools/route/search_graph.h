// The graph of states that search.cc walks: made as it is walked.
#pragma once

#include <array>
#include <boost/graph/graph_traits.hpp>
#include <deque>
#include <limits>
#include <optional>
#include <unordered_map>
#include <vector>

#include "tools/route/belief.h"
#include "tools/route/search.h"

namespace landfix::route {

/// Nodes of the region, with what they offer.
class NodeGrid {
 public:
  explicit NodeGrid(const RouteProblem& problem);

  uint32_t columns() const { return columns_; }
  uint32_t rows() const { return rows_; }
  double node_m() const { return node_m_; }
  Eigen::Vector2d place(uint32_t node) const;
  uint32_t nearest(const Eigen::Vector2d& place) const;
  double agl_m(uint32_t node);  ///< NaN outside of the altitude band
  const View& view(uint32_t node, double filter_sigma_m);

 private:
  struct Node {
    bool known = false;
    double agl_m = 0;
    std::vector<View> views;
  };
  Node& at(uint32_t node);

  const RouteProblem& problem_;
  Extent region_;
  double node_m_;
  uint32_t columns_, rows_;
  std::vector<Node> nodes_;
};

/// Distance between images that a search takes: none of the rest is lost, it counts as tempered images do.
double search_spacing_m(const RouteProblem& problem, double agl_m);

/// An incidence graph as Boost has it. A vertex is a state (node, stops passed, level of uncertainty).
class StateGraph {
 public:
  using vertex_descriptor = uint32_t;
  struct edge_descriptor {
    uint32_t source = 0, target = 0;
    double cost = 0;
    uint32_t slot = 0;
    bool operator==(const edge_descriptor&) const = default;
  };
  using out_edge_iterator = std::vector<edge_descriptor>::const_iterator;
  using directed_category = boost::directed_tag;
  using edge_parallel_category = boost::allow_parallel_edge_tag;
  using traversal_category = boost::incidence_graph_tag;
  using degree_size_type = size_t;
  using vertices_size_type = size_t;
  using edges_size_type = size_t;

  struct State {
    uint32_t node = 0;
    uint16_t stage = 0, level = 0;
    double cost = std::numeric_limits<double>::infinity(), rank = cost;
    uint32_t before = 0;
    std::optional<Belief> belief;
  };

  StateGraph(const RouteProblem& problem, const CostModel& model);

  uint32_t start() const { return 0; }
  bool is_goal(uint32_t vertex) const { return states_[vertex].stage + 1u == problem_.stops.size(); }
  double least_cost_to_goal(uint32_t vertex) const;
  State& state(uint32_t vertex) const { return states_[vertex]; }
  /// Expands a state; what is returned is valid until the next call. Empty where a state as good has been expanded.
  const std::vector<edge_descriptor>& expand(uint32_t vertex) const;
  /// The edge was the cheapest so far to its target.
  void take(const edge_descriptor& edge) const { states_[edge.target].belief = std::move(candidates_[edge.slot]); }
  std::vector<Eigen::Vector2d> route_to(uint32_t vertex) const;

 private:
  void try_edge(uint32_t source, uint32_t node) const;
  std::optional<double> fly(Belief& belief, uint32_t from, uint32_t to) const;
  uint32_t vertex_of(uint32_t node, uint16_t stage, uint16_t level) const;

  // The walk changes nothing but this cache of the graph, which Boost asks for as const.
  const RouteProblem& problem_;
  const CostModel model_;
  mutable NodeGrid grid_;
  std::vector<uint32_t> stop_nodes_;
  std::vector<double> rest_m_;  ///< from each stop to the last
  mutable std::deque<State> states_;
  mutable std::unordered_map<uint64_t, uint32_t> vertices_;
  mutable std::unordered_map<uint64_t, uint16_t> expanded_;  ///< lowest level of each node and stage
  mutable std::vector<edge_descriptor> edges_;
  mutable std::vector<Belief> candidates_;
};

inline std::pair<StateGraph::out_edge_iterator, StateGraph::out_edge_iterator> out_edges(uint32_t vertex,
                                                                                         const StateGraph& graph) {
  const auto& edges = graph.expand(vertex);
  return {edges.begin(), edges.end()};
}
inline uint32_t source(const StateGraph::edge_descriptor& edge, const StateGraph&) { return edge.source; }
inline uint32_t target(const StateGraph::edge_descriptor& edge, const StateGraph&) { return edge.target; }

}  // namespace landfix::route
