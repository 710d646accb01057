#include "builder/landmarks/road_joins.h"

#include <algorithm>
#include <boost/geometry.hpp>
#include <cmath>
#include <iterator>
#include <map>
#include <tuple>
#include <utility>

namespace landfix::landmarks {
namespace {

namespace bg = boost::geometry;
using Place = bg::model::point<double, 2, bg::cs::cartesian>;
using Box = bg::model::box<Place>;
using tiles::RoadPoint;

struct Vertex {
  size_t line;
  bool is_end;
  bool operator==(const Vertex&) const = default;
};
using VertexEntry = std::pair<Place, Vertex>;
using SegmentEntry = std::pair<Box, std::pair<size_t, size_t>>;  ///< of a line, from its k-th point
using Parameters = bg::index::quadratic<16>;

Place place_of(const RoadPoint& p) { return {p.east_m, p.north_m}; }

Box around(const RoadPoint& p, double reach_m) {
  return {{p.east_m - reach_m, p.north_m - reach_m}, {p.east_m + reach_m, p.north_m + reach_m}};
}

double distance_m(const RoadPoint& a, const RoadPoint& b) {
  return std::hypot(a.east_m - b.east_m, a.north_m - b.north_m);
}

/// Where on a segment, 0 to 1, a point is nearest to it.
double nearest_on(const RoadPoint& p, const RoadPoint& a, const RoadPoint& b) {
  const double dx = b.east_m - a.east_m, dy = b.north_m - a.north_m, squared = dx * dx + dy * dy;
  if (squared <= 0) return 0;
  return std::clamp(((p.east_m - a.east_m) * dx + (p.north_m - a.north_m) * dy) / squared, 0.0, 1.0);
}

RoadPoint between(const RoadPoint& a, const RoadPoint& b, double t) {
  return {a.east_m + t * (b.east_m - a.east_m), a.north_m + t * (b.north_m - a.north_m)};
}

class Joiner {
 public:
  Joiner(std::vector<Centreline>& lines, const ingest::GridBounds& b)
      : lines_(lines), map_({b.west_m - 1, b.south_m - 1}, {b.east_m + 1, b.north_m + 1}) {
    std::vector<VertexEntry> vertices;
    std::vector<SegmentEntry> segments;
    for (size_t i = 0; i < lines.size(); ++i) {
      const std::vector<RoadPoint>& points = lines[i].points;
      for (size_t k = 0; k < points.size(); ++k) {
        if (bg::covered_by(place_of(points[k]), map_))
          vertices.push_back({place_of(points[k]), {i, k == 0 || k + 1 == points.size()}});
        if (k + 1 == points.size()) continue;
        Box box(place_of(points[k]), place_of(points[k]));
        bg::expand(box, place_of(points[k + 1]));
        if (bg::intersects(box, map_)) segments.push_back({box, {i, k}});
      }
    }
    vertices_ = {vertices.begin(), vertices.end()};
    segments_ = {segments.begin(), segments.end()};
  }

  void join() {
    for (size_t i = 0; i < lines_.size(); ++i)
      for (RoadPoint* end : {&lines_[i].points.front(), &lines_[i].points.back()})
        if (bg::covered_by(place_of(*end), map_) && !join_to_vertex(i, *end)) join_to_line(i, *end);
    // From the last one backwards: what lies before keeps its place.
    for (auto at = added_.rbegin(); at != added_.rend(); ++at) {
      const auto& [line, k, along] = at->first;
      std::vector<RoadPoint>& points = lines_[line].points;
      points.insert(points.begin() + std::ptrdiff_t(k) + 1, at->second);
    }
  }

 private:
  bool join_to_vertex(size_t line, RoadPoint& end) {
    std::vector<VertexEntry> near;
    vertices_.query(bg::index::intersects(around(end, kJoinReach_m)), std::back_inserter(near));
    std::vector<std::tuple<double, size_t, double, double>> found;
    for (const auto& [place, vertex] : near) {
      const RoadPoint at{bg::get<0>(place), bg::get<1>(place)};
      const double away_m = distance_m(at, end);
      const bool may_meet = away_m == 0 || vertex.is_end || lines_[vertex.line].layer == lines_[line].layer;
      if (vertex.line != line && away_m <= kJoinReach_m && may_meet)
        found.emplace_back(away_m, vertex.line, at.east_m, at.north_m);
    }
    if (found.empty()) return false;
    const auto& [away_m, other, east_m, north_m] = *std::ranges::min_element(found);
    move(line, end, {east_m, north_m});
    return true;
  }

  void join_to_line(size_t line, RoadPoint& end) {
    std::vector<SegmentEntry> near;
    segments_.query(bg::index::intersects(around(end, kJoinReach_m)), std::back_inserter(near));
    std::vector<std::tuple<double, size_t, size_t, double>> found;
    for (const auto& [box, id] : near) {
      const auto& [other, k] = id;
      if (other == line || lines_[other].layer != lines_[line].layer) continue;
      const RoadPoint &a = lines_[other].points[k], &b = lines_[other].points[k + 1];
      const double t = nearest_on(end, a, b);
      if (const double away_m = distance_m(between(a, b, t), end); away_m <= kJoinReach_m)
        found.emplace_back(away_m, other, k, t);
    }
    if (found.empty()) return;
    const auto& [away_m, other, k, t] = *std::ranges::min_element(found);
    const RoadPoint at = between(lines_[other].points[k], lines_[other].points[k + 1], t);
    added_.insert({{other, k, t}, at});
    vertices_.insert({place_of(at), {other, false}});
    move(line, end, at);
  }

  void move(size_t line, RoadPoint& end, const RoadPoint& to) {
    vertices_.remove(VertexEntry{place_of(end), {line, true}});
    end = to;
    vertices_.insert({place_of(end), {line, true}});
  }

  std::vector<Centreline>& lines_;
  Box map_;
  bg::index::rtree<VertexEntry, Parameters> vertices_;
  bg::index::rtree<SegmentEntry, Parameters> segments_;
  std::map<std::tuple<size_t, size_t, double>, RoadPoint> added_;  ///< by line, segment and place along it
};

}  // namespace

void join_ends(std::vector<Centreline>& lines, const ingest::GridBounds& bounds) { Joiner(lines, bounds).join(); }

}  // namespace landfix::landmarks
