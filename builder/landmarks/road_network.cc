#include "builder/landmarks/road_network.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>
#include <utility>

#include "builder/landmarks/road_joins.h"

namespace landfix::landmarks {
namespace {

using Place = std::pair<int64_t, int64_t>;  ///< steps east and north on the lattice
using Path = std::vector<Place>;

/// A piece of a centreline: of one line, unbroken.
struct Chain {
  const Centreline* line = nullptr;
  Path path;
};

/// A place and, where chains meet above each other, the level of the connected ones.
using Meeting = std::pair<Place, int>;

/// Between two junctions.
struct Stretch {
  const Centreline* line = nullptr;
  Path path;
  Meeting from, to;
};

/// The lattice's points inside of the map.
struct Frame {
  int64_t west, south, width, height;
};

Frame frame_of(const ingest::GridBounds& b) {
  const auto steps = [](double metres) { return int64_t(std::floor(metres / tiles::kLatticeStep_m)); };
  const int64_t west = steps(b.west_m), south = steps(b.south_m);
  return {west, south, steps(b.east_m) - west, steps(b.north_m) - south};
}

/// The part of a segment inside of the frame; false where there is none.
bool clip(const Frame& frame, Place& a, Place& b) {
  cv::Point2l p(a.first - frame.west, a.second - frame.south), q(b.first - frame.west, b.second - frame.south);
  if (!cv::clipLine(cv::Size2l(frame.width, frame.height), p, q)) return false;
  a = {p.x + frame.west, p.y + frame.south};
  b = {q.x + frame.west, q.y + frame.south};
  return a != b;
}

/// Cuts lines at the map's edge and where a segment is there already.
std::vector<Chain> chains_of(const std::vector<Centreline>& lines, const Frame& frame) {
  std::vector<Chain> chains;
  std::set<std::pair<Place, Place>> known;
  for (const Centreline& line : lines) {
    Path path;
    const auto finish = [&] {
      if (path.size() > 1) chains.push_back({&line, path});
      path.clear();
    };
    std::optional<Place> last;
    for (const tiles::RoadPoint& point : line.points) {
      const auto at = tiles::lattice_point(point.east_m, point.north_m);
      if (!at) {
        finish();
        last.reset();
        continue;
      }
      const Place here{at->east, at->north};
      if (last && *last != here) {
        Place from = *last, to = here;
        if (!clip(frame, from, to) || !known.emplace(std::min(from, to), std::max(from, to)).second) {
          finish();
        } else {
          if (!path.empty() && path.back() != from) finish();
          if (path.empty()) path.push_back(from);
          path.push_back(to);
        }
      }
      last = here;
    }
    finish();
  }
  return chains;
}

/// Where chains meet or end, and what is connected there: chains of one layer; an end without anything of its own layer
/// goes on in the nearest other one, as a bridge does on the ground.
class Junctions {
 public:
  explicit Junctions(const std::vector<Chain>& chains) {
    for (const Chain& chain : chains) {
      ++at_[chain.path.front()][chain.line->layer].ends;
      ++at_[chain.path.back()][chain.line->layer].ends;
      for (size_t i = 1; i + 1 < chain.path.size(); ++i) ++at_[chain.path[i]][chain.line->layer].within;
    }
    for (auto& [place, layers] : at_) connect(layers);
  }

  /// The lowest of the layers that are connected with this one at the place.
  int level(const Place& place, int layer) const { return at_.at(place).at(layer).level; }

  /// Whether a chain of this layer is cut where it passes the place.
  bool is_cut(const Place& place, int layer) const {
    int ends = 0, within = 0;
    for (const auto& [other, here] : at_.at(place))
      if (here.level == level(place, layer)) ends += here.ends, within += here.within;
    return ends > 0 || within > 1;
  }

 private:
  struct Here {
    int ends = 0, within = 0;  ///< of chains
    int level = 0;
  };
  using Layers = std::map<int, Here>;

  static void connect(Layers& layers) {
    for (auto& [layer, here] : layers) here.level = layer;
    if (layers.size() == 1) return;
    for (const auto& [layer, here] : layers) {
      if (here.ends != 1 || here.within != 0) continue;
      int nearest = layer == layers.begin()->first ? layers.rbegin()->first : layers.begin()->first;
      for (const auto& entry : layers)
        if (entry.first != layer && std::abs(entry.first - layer) < std::abs(nearest - layer)) nearest = entry.first;
      const int a = here.level, b = layers.at(nearest).level;
      for (auto& [other, there] : layers)
        if (there.level == a || there.level == b) there.level = std::min(a, b);
    }
  }

  std::map<Place, Layers> at_;
};

double distance(const Place& p, const Place& a, const Place& b) {
  const double dx = double(b.first - a.first), dy = double(b.second - a.second);
  const double px = double(p.first - a.first), py = double(p.second - a.second);
  const double squared = dx * dx + dy * dy;
  const double along = squared > 0 ? std::clamp((px * dx + py * dy) / squared, 0.0, 1.0) : 0;
  return std::hypot(px - along * dx, py - along * dy) * tiles::kLatticeStep_m;
}

/// Douglas & Peucker 1973. cv::approxPolyDP counts in floats, too coarse for northings, and keeps no ends of rings.
Path simplified(const Path& path) {
  std::vector<bool> keep(path.size());
  keep.front() = keep.back() = true;
  std::vector<std::pair<size_t, size_t>> open = {{0, path.size() - 1}};
  while (!open.empty()) {
    const auto [first, last] = open.back();
    open.pop_back();
    size_t farthest = first;
    double most = kRoadTolerance_m;
    for (size_t i = first + 1; i < last; ++i)
      if (const double d = distance(path[i], path[first], path[last]); d > most) most = d, farthest = i;
    if (farthest == first) continue;
    keep[farthest] = true;
    open.emplace_back(first, farthest);
    open.emplace_back(farthest, last);
  }
  Path out;
  for (size_t i = 0; i < path.size(); ++i)
    if (keep[i]) out.push_back(path[i]);
  return out;
}

/// The chains cut at all junctions.
std::vector<Stretch> stretches_of(const std::vector<Chain>& chains) {
  const Junctions junctions(chains);
  std::vector<Stretch> stretches;
  for (const auto& [line, path] : chains) {
    size_t first = 0;
    for (size_t i = 1; i < path.size(); ++i) {
      if (i + 1 < path.size() && !junctions.is_cut(path[i], line->layer)) continue;
      const auto meeting = [&](size_t k) { return Meeting(path[k], junctions.level(path[k], line->layer)); };
      stretches.push_back({line, Path(path.begin() + std::ptrdiff_t(first), path.begin() + std::ptrdiff_t(i) + 1),
                           meeting(first), meeting(i)});
      first = i;
    }
  }
  return stretches;
}

/// Joins stretches at places where just two of the same road meet.
class Dissolver {
 public:
  explicit Dissolver(std::vector<Stretch> stretches) : stretches_(std::move(stretches)) {
    for (size_t i = 0; i < stretches_.size(); ++i)
      for (const Meeting& end : {stretches_[i].from, stretches_[i].to}) ends_[end].push_back(i);
  }

  std::vector<Stretch> dissolve() {
    for (auto& [meeting, at] : ends_)
      if (at.size() == 2 && at[0] != at[1] && is_same_road(stretches_[at[0]], stretches_[at[1]])) join(meeting, at);
    std::erase_if(stretches_, [](const Stretch& stretch) { return stretch.path.empty(); });
    return std::move(stretches_);
  }

 private:
  static bool is_same_road(const Stretch& a, const Stretch& b) {
    return a.line->width_m == b.line->width_m && a.line->source == b.line->source;
  }

  static void turn(Stretch& stretch) {
    std::ranges::reverse(stretch.path);
    std::swap(stretch.from, stretch.to);
  }

  void join(const Meeting& meeting, std::vector<size_t>& at) {
    const size_t kept = at[0], gone = at[1];
    Stretch &head = stretches_[kept], &tail = stretches_[gone];
    if (head.to != meeting) turn(head);
    if (tail.from != meeting) turn(tail);
    head.path.insert(head.path.end(), tail.path.begin() + 1, tail.path.end());
    head.to = tail.to;
    std::ranges::replace(ends_[tail.to], gone, kept);
    tail.path.clear();
    at.clear();
  }

  std::vector<Stretch> stretches_;
  std::map<Meeting, std::vector<size_t>> ends_;
};

}  // namespace

tiles::RoadGraph road_graph(std::vector<Centreline> lines, const ingest::GridBounds& bounds) {
  const auto metres = [](const Place& at) {
    const tiles::LatticePoint p{at.first, at.second};
    return tiles::RoadPoint{p.east_m(), p.north_m()};
  };
  tiles::RoadGraph graph;
  std::map<Meeting, uint32_t> nodes;
  const auto node_at = [&](const Meeting& meeting) {
    const auto [found, is_new] = nodes.try_emplace(meeting, uint32_t(graph.nodes.size()));
    if (is_new) graph.nodes.push_back({metres(meeting.first).east_m, metres(meeting.first).north_m});
    return found->second;
  };
  join_ends(lines, bounds);
  for (const Stretch& stretch : Dissolver(stretches_of(chains_of(lines, frame_of(bounds)))).dissolve()) {
    const Path path = simplified(stretch.path);
    const Centreline& line = *stretch.line;
    tiles::RoadEdge edge{node_at(stretch.from), node_at(stretch.to), line.width_m, 1, line.source, {}};
    for (size_t i = 1; i + 1 < path.size(); ++i) edge.vertices.push_back(metres(path[i]));
    graph.edges.push_back(std::move(edge));
  }
  const auto arms = tiles::arms_of(graph);
  for (size_t i = 0; i < arms.size(); ++i)
    graph.nodes[i].kind = arms[i].size() >= 3   ? tiles::RoadNodeKind::kIntersection
                          : arms[i].size() == 2 ? tiles::RoadNodeKind::kJoint
                                                : tiles::RoadNodeKind::kEnd;
  return graph;
}

}  // namespace landfix::landmarks
