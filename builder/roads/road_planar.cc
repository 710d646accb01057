#include "builder/roads/road_planar.h"

#include <CGAL/Arr_consolidated_curve_data_traits_2.h>
#include <CGAL/Arr_segment_traits_2.h>
#include <CGAL/Arrangement_2.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include "builder/roads/road_skeleton.h"

namespace landfix::landmarks {
namespace {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Traits = CGAL::Arr_consolidated_curve_data_traits_2<CGAL::Arr_segment_traits_2<Kernel>, int>;
using Arrangement = CGAL::Arrangement_2<Traits>;
using Halfedge = Arrangement::Halfedge_const_handle;
using Face = Arrangement::Face_const_handle;

constexpr double kGrid = 64, kTwig_px = 4, kSliver_px2 = 20;
// Of roundabouts; streets around a block are larger or less round.
constexpr double kRound = 0.86, kSmall_px2 = 650, kSmallRound = 0.6;

cv::Point2d rounded(const cv::Point2d& p) { return {std::round(p.x * kGrid) / kGrid, std::round(p.y * kGrid) / kGrid}; }

bool before(const cv::Point2d& a, const cv::Point2d& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); }

bool before(const std::vector<cv::Point2d>& a, const std::vector<cv::Point2d>& b) {
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(),
                                      [](const cv::Point2d& p, const cv::Point2d& q) { return before(p, q); });
}

// In one order, whatever the order in which they came.
std::vector<RoadLine> in_order(std::span<const RoadLine> given) {
  std::vector<RoadLine> lines(given.begin(), given.end());
  for (RoadLine& line : lines) {
    for (cv::Point2d& p : line.points) p = rounded(p);
    std::vector<cv::Point2d> back(line.points.rbegin(), line.points.rend());
    if (before(back, line.points)) line.points = std::move(back);
  }
  std::stable_sort(lines.begin(), lines.end(),
                   [](const RoadLine& a, const RoadLine& b) { return before(a.points, b.points); });
  return lines;
}

Arrangement arrangement_of(const std::vector<RoadLine>& lines) {
  std::vector<Traits::Curve_2> segments;
  for (size_t i = 0; i < lines.size(); ++i) {
    const std::vector<cv::Point2d>& p = lines[i].points;
    for (size_t k = 1; k < p.size(); ++k) {
      if (p[k] == p[k - 1]) continue;
      segments.emplace_back(
          Traits::Base_traits_2::Curve_2(Kernel::Point_2(p[k - 1].x, p[k - 1].y), Kernel::Point_2(p[k].x, p[k].y)),
          int(i));
    }
  }
  Arrangement arrangement;
  CGAL::insert(arrangement, segments.begin(), segments.end());
  return arrangement;
}

cv::Point2d place_of(Arrangement::Vertex_const_handle vertex) {
  return {CGAL::to_double(vertex->point().x()), CGAL::to_double(vertex->point().y())};
}

// Edges between two vertices where not just two of them meet, with the faces on both sides.
struct Chain {
  RoadLine line;
  Face left, right;
  bool from_free, to_free;
};

class Chains {
 public:
  Chains(const Arrangement& arrangement, const std::vector<RoadLine>& lines) : lines_(lines) {
    for (auto e = arrangement.edges_begin(); e != arrangement.edges_end(); ++e) {
      const Halfedge forth = e, back = e->twin();
      for (const Halfedge& h : {forth, back})
        if (h->source()->degree() != 2 && !seen_.contains(&*h)) follow(h);
    }
    for (auto e = arrangement.edges_begin(); e != arrangement.edges_end(); ++e)
      if (!seen_.contains(&*Halfedge(e))) follow(first_of_ring(e));
  }
  std::vector<Chain> take() { return std::move(chains_); }

 private:
  // Of a ring the place that comes first, so that it always begins there.
  static Halfedge first_of_ring(Halfedge start) {
    Halfedge first = start;
    for (Halfedge h = start->next(); h != start; h = h->next())
      if (before(place_of(h->source()), place_of(first->source()))) first = h;
    return first;
  }

  void follow(Halfedge h) {
    Chain chain{{}, h->face(), h->twin()->face(), h->source()->degree() == 1, false};
    chain.line.points.push_back(place_of(h->source()));
    const auto* start = &*h;
    double length = 0;
    while (true) {
      seen_.insert(&*h);
      seen_.insert(&*h->twin());
      const cv::Point2d to = place_of(h->target());
      const double part = cv::norm(to - chain.line.points.back());
      int of = h->curve().data().front();
      for (const int other : h->curve().data()) of = std::min(of, other);
      chain.line.width_px += part * lines_[size_t(of)].width_px;
      chain.line.probability += part * lines_[size_t(of)].probability;
      length += part;
      chain.line.points.push_back(to);
      if (h->target()->degree() != 2 || &*h->next() == start) break;
      h = h->next();
    }
    chain.to_free = h->target()->degree() == 1;
    chain.line.width_px /= length;
    chain.line.probability /= length;
    chains_.push_back(std::move(chain));
  }

  const std::vector<RoadLine>& lines_;
  std::set<const void*> seen_;  // asked for membership alone: its order is never used
  std::vector<Chain> chains_;
};

// The centre of a face that stands for one intersection.
std::optional<cv::Point2d> centre_of(Face face, double roundabout_px) {
  if (face->is_unbounded() || !face->has_outer_ccb()) return std::nullopt;
  double area = 0, perimeter = 0;
  int roads = 0;
  cv::Point2d sum(0, 0);
  auto h = face->outer_ccb();
  const auto end = h;
  do {
    const cv::Point2d a = place_of(h->source()), b = place_of(h->target());
    const double cross = a.cross(b);
    area += cross / 2;
    sum += (a + b) * (cross / 6);
    perimeter += cv::norm(b - a);
    roads += h->target()->degree() > 2;
  } while (++h != end);
  const double roundness = 4 * std::numbers::pi * area / (perimeter * perimeter);
  const bool round = perimeter < std::numbers::pi * roundabout_px && roads >= 3 &&
                     roundness > (area < kSmall_px2 ? kSmallRound : kRound);
  if (area <= 0 || (area >= kSliver_px2 && !round)) return std::nullopt;
  return rounded(sum * (1 / area));
}

// Faces that become nodes take the ends of the roads outside of them along.
std::vector<RoadLine> without_small_faces(const Arrangement& arrangement, const std::vector<Chain>& chains,
                                          double roundabout_px) {
  std::map<const void*, cv::Point2d> centres;
  std::map<std::pair<double, double>, cv::Point2d> moved;
  for (auto f = arrangement.faces_begin(); f != arrangement.faces_end(); ++f) {
    const auto centre = centre_of(f, roundabout_px);
    if (!centre) continue;
    centres[&*f] = *centre;
    auto h = Face(f)->outer_ccb();
    const auto end = h;
    do {
      const cv::Point2d p = place_of(h->source());
      moved[{p.x, p.y}] = *centre;
    } while (++h != end);
  }
  std::vector<RoadLine> out;
  for (const Chain& chain : chains) {
    if (centres.contains(&*chain.left) || centres.contains(&*chain.right)) continue;
    out.push_back(chain.line);
    std::vector<cv::Point2d>& points = out.back().points;
    const auto first = moved.find({points.front().x, points.front().y});
    const auto last = moved.find({points.back().x, points.back().y});
    if (last != moved.end()) points.push_back(last->second);
    if (first != moved.end()) points.insert(points.begin(), first->second);
  }
  return out;
}

std::vector<RoadLine> lines_of(const std::vector<Chain>& chains) {
  std::vector<RoadLine> out;
  for (const Chain& chain : chains) {
    const bool twig = chain.from_free != chain.to_free && length_of(chain.line.points) < kTwig_px;
    if (!twig) out.push_back(chain.line);
  }
  return out;
}

}  // namespace

PlanarRoads planar_roads(std::span<const RoadLine> given, double roundabout_px) {
  std::vector<RoadLine> lines = in_order(given);
  // A face that becomes a node, or a twig that goes, may let others meet.
  for (int round = 0; round < 4; ++round) {
    const Arrangement arrangement = arrangement_of(lines);
    const std::vector<Chain> chains = Chains(arrangement, lines).take();
    std::vector<RoadLine> next =
        round % 2 == 0 ? without_small_faces(arrangement, chains, roundabout_px) : lines_of(chains);
    const bool settled = round > 0 && next.size() == chains.size();
    lines = in_order(next);
    if (settled) break;
  }
  const std::vector<Chain> chains = [&] {
    const Arrangement arrangement = arrangement_of(lines);
    return Chains(arrangement, lines).take();
  }();
  std::vector<RoadLine> parts;
  for (const Chain& chain : chains) parts.push_back(chain.line);
  PlanarRoads out;
  std::map<std::pair<double, double>, size_t> nodes;
  const auto node = [&](const cv::Point2d& p) {
    const auto [entry, added] = nodes.try_emplace({p.x, p.y}, out.nodes.size());
    if (added) out.nodes.push_back(p);
    return entry->second;
  };
  for (RoadLine& line : in_order(parts)) {
    const size_t from = node(line.points.front()), to = node(line.points.back());
    out.edges.push_back({from, to, std::move(line)});
  }
  return out;
}

}  // namespace landfix::landmarks
