// Closes gaps between chains of road places.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "builder/roads/road_graph.h"

namespace landfix::landmarks {
namespace {

constexpr double kBendDoubt = 0.55;  // per pixel: nothing but the image says that a road goes on through a bend
constexpr double kMargin = 5;        // to the border: there a road leaves the map

struct End {
  size_t path;
  int node;
  cv::Point2d at, heading;  // unit, outwards
  double reach;             // 0 to 1: short paths reach less
  bool bend = false;        // no end, but a sharp bend that one arm may go on through
};

// Direction of the line through points.
cv::Point2d direction_of(const std::vector<cv::Point2d>& points) {
  cv::Point2d mean(0, 0);
  for (const cv::Point2d& p : points) mean += p * (1.0 / double(points.size()));
  double xx = 0, xy = 0, yy = 0;
  for (const cv::Point2d& p : points) {
    const cv::Point2d d = p - mean;
    xx += d.x * d.x;
    xy += d.x * d.y;
    yy += d.y * d.y;
  }
  const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
  return {std::cos(angle), std::sin(angle)};
}

// `line` ends at the free end.
cv::Point2d heading_of(const std::vector<cv::Point2d>& line, const PlaceIndex& index) {
  std::vector<cv::Point2d> near;
  double s = 0;
  const size_t n = line.size();
  for (size_t i = n; i-- > 0;) {
    if (i + 1 < n) s += cv::norm(line[i + 1] - line[i]);
    if (s > 15) break;
    if (s >= 2) near.push_back(line[i]);
  }
  if (near.size() < 3) near.assign(line.end() - ptrdiff_t(std::min<size_t>(n, 6)), line.end());
  cv::Point2d u = direction_of(near);
  if (u.dot(line.back() - near.back()) + u.dot(line.back() - near[near.size() / 2]) < 0) u = -u;
  const double length = length_of(line);
  if (length > 25) return u;
  // Of a short line the places know the direction better than its few pixels do.
  double c = 0, sine = 0;
  int count = 0;
  for (size_t i = n - std::min<size_t>(n, 14); i < n; ++i) {
    const RoadPlace* p = index.nearest(line[i], 1.5);
    if (p == nullptr) continue;
    c += double(p->probability) * std::cos(2 * double(p->theta_rad));
    sine += double(p->probability) * std::sin(2 * double(p->theta_rad));
    ++count;
  }
  cv::Point2d v(std::cos(std::atan2(sine, c) / 2), std::sin(std::atan2(sine, c) / 2));
  if (v.dot(u) < 0) v = -v;
  if (count < 2 || v.dot(u) < 0.7) return u;
  const double f = std::clamp((length - 8) / 17, 0.0, 1.0);
  v = v * (1 - f) + u * f;
  return v * (1 / cv::norm(v));
}

std::vector<End> free_ends(const std::vector<Path>& paths, const PlaceIndex& index, const cv::Size& size) {
  const std::vector<int> degrees = degrees_of(paths);
  std::vector<End> ends;
  for (size_t i = 0; i < paths.size(); ++i) {
    const Path& p = paths[i];
    if (p.from == p.to) continue;
    for (const bool last : {true, false}) {
      const int node = last ? p.to : p.from;
      std::vector<cv::Point2d> line = p.points;
      if (!last) std::reverse(line.begin(), line.end());
      if (degrees[size_t(node)] != 1 || at_border(line.back(), size, kMargin)) continue;
      ends.push_back({i, node, line.back(), heading_of(line, index), std::min(1.0, length_of(line) / 20)});
    }
  }
  return ends;
}

cv::Point2d unit(const cv::Point2d& v) { return v * (1 / std::max(1e-9, cv::norm(v))); }

// Where thinning has made one curve of two roads that meet, both arms may go on straight: a sharp bend is two ends.
void add_bends(const std::vector<Path>& paths, std::vector<End>& ends) {
  constexpr int kNear = 4, kFar = 14, kApart = 12;
  constexpr double kSharp = 0.64;  // cosine of 50 degrees
  int node = -1;
  for (size_t k = 0; k < paths.size(); ++k) {
    const std::vector<cv::Point2d>& p = paths[k].points;
    const auto direction = [&](int from, int to) { return unit(p[size_t(to)] - p[size_t(from)]); };
    int best = -1;
    double least = kSharp;
    for (int i = kFar; i + kFar < int(p.size()); ++i) {
      const double cosine = direction(i - kFar, i - kNear).dot(direction(i + kNear, i + kFar));
      if (cosine < least) {
        least = cosine;
        best = i;
      }
      if (best < 0 || (i < best + kApart && i + kFar + 1 < int(p.size()))) continue;
      ends.push_back({k, node, p[size_t(best - kNear + 1)], direction(best - kFar, best - kNear), 1, true});
      ends.push_back({k, node, p[size_t(best + kNear - 1)], direction(best + kFar, best + kNear), 1, true});
      --node;
      best = -1;
      least = kSharp;
      i += kNear;
    }
  }
}

struct Link {
  cv::Point2d from, to;
  bool through;  // from end to end; else from an end to a road
  size_t end, other_end;
  double reach;
  bool bend;  // at either end
  double cost = 0;
};

constexpr size_t kNoEnd = size_t(-1);

void propose_through(const std::vector<End>& ends, const PointGrid& grid, double reach_px, std::vector<Link>& links) {
  for (size_t a = 0; a < ends.size(); ++a) {
    grid.within(ends[a].at, reach_px, [&](const cv::Point2d& at, int id) {
      const size_t b = size_t(id);
      const cv::Point2d v = at - ends[a].at;
      const double distance = cv::norm(v);
      if (b <= a || ends[b].node == ends[a].node || distance < 1) return;
      const double least = std::cos(0.2094 + std::atan(3 / std::max(distance, 3.0))) * distance;  // 12 degrees and 3 px
      if (v.dot(ends[a].heading) > least && -v.dot(ends[b].heading) > least)
        links.push_back(
            {ends[a].at, at, true, a, b, std::min(ends[a].reach, ends[b].reach), ends[a].bend || ends[b].bend});
    });
  }
}

// The first road that an end's heading meets. Points know their path by `owner`.
void propose_side(const std::vector<Path>& paths, const std::vector<End>& ends, double reach_px,
                  std::vector<Link>& links) {
  PointGrid grid(4);
  std::vector<size_t> owner;
  for (size_t i = 0; i < paths.size(); ++i) {
    for (const cv::Point2d& p : paths[i].points) {
      grid.add(p, int(owner.size()));
      owner.push_back(i);
    }
  }
  for (size_t a = 0; a < ends.size(); ++a) {
    const End& end = ends[a];
    const bool own_allowed = length_of(paths[end.path].points) > 60;
    for (double t = 1.5; t < reach_px; t += 1) {
      const cv::Point2d centre = end.at + end.heading * t;
      cv::Point2d hit;
      double least = 2;
      grid.within(centre, 1.5, [&](const cv::Point2d& at, int id) {
        const bool own = owner[size_t(id)] == end.path;
        if (own && !(own_allowed && cv::norm(at - end.at) > 0.8 * t + 4)) return;
        if ((at - end.at).dot(end.heading) <= 0.5 * t || cv::norm(at - centre) >= least) return;
        least = cv::norm(at - centre);
        hit = at;
      });
      if (least >= 2) continue;
      links.push_back({end.at, hit, false, a, kNoEnd, end.reach, end.bend});
      break;
    }
  }
}

double doubt_of(const Link& link, const Evidence& evidence) {
  const cv::Point2d v = link.to - link.from;
  const double length = cv::norm(v), theta = std::atan2(v.y, v.x);
  const int steps = std::max(2, int(length / 2));
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    const cv::Point2d p = link.from + v * ((i + 0.5) / steps);
    sum += evidence(p.x, p.y, theta);
  }
  return length * (1.05 - sum / steps);
}

}  // namespace

void close_gaps(const std::vector<Path>& paths, const PlaceIndex& index, const Evidence& evidence,
                const RoadGraphOptions& options, double share, cv::Mat& mask) {
  std::vector<End> ends = free_ends(paths, index, mask.size());
  add_bends(paths, ends);
  PointGrid grid(16);
  for (size_t i = 0; i < ends.size(); ++i) grid.add(ends[i].at, int(i));
  std::vector<Link> links;
  propose_through(ends, grid, options.through_gap_px, links);
  propose_side(paths, ends, options.side_gap_px, links);
  for (Link& link : links) link.cost = doubt_of(link, evidence);
  std::stable_sort(links.begin(), links.end(), [](const Link& a, const Link& b) { return a.cost < b.cost; });
  std::vector<bool> used(ends.size(), false);
  for (const Link& link : links) {
    const double budget = link.through ? options.through_budget_px : options.side_budget_px;
    if (link.cost > share * budget * (0.35 + 0.65 * link.reach)) continue;
    if (link.bend && link.cost > kBendDoubt * cv::norm(link.to - link.from)) continue;
    if (used[link.end] || (link.through && used[link.other_end])) continue;
    used[link.end] = true;
    if (link.through) used[link.other_end] = true;
    cv::line(mask, cv::Point(int(std::lround(link.from.x)), int(std::lround(link.from.y))),
             cv::Point(int(std::lround(link.to.x)), int(std::lround(link.to.y))), cv::Scalar(255));
  }
}

}  // namespace landfix::landmarks
