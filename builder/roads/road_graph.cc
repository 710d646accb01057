#include "builder/roads/road_graph.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "builder/roads/road_planar.h"

namespace landfix::landmarks {
namespace {

constexpr double kRounds[] = {0.35, 0.7, 1.0, 1.0};  // of the budgets: what is sure is linked first
constexpr double kNearPlace = 2.5;
constexpr int kTrimmed = 5;  // points of a line's end that the intersection's bulge has bent

// Places above `low` grown to chains; those with too little of it are left out.
cv::Mat chains(const PlaceIndex& index, const cv::Size& size, const RoadGraphOptions& options) {
  cv::Mat mask(size, CV_8UC1, cv::Scalar(0)), labels;
  for (const RoadPlace& p : index.places()) mask.at<uint8_t>(p.y, p.x) = 255;
  cv::dilate(mask, mask, cv::Mat::ones(3, 3, CV_8UC1));
  const int count = cv::connectedComponents(mask, labels, 8, CV_32S);
  std::vector<double> sum(size_t(count), 0), sure(size_t(count), 0);
  for (const RoadPlace& p : index.places()) {
    const size_t label = size_t(labels.at<int>(p.y, p.x));
    sum[label] += double(p.probability - options.low);
    sure[label] += p.probability > options.high;
  }
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const size_t label = size_t(labels.at<int>(y, x));
      if (sum[label] <= options.least_chain || sure[label] < options.least_chain) mask.at<uint8_t>(y, x) = 0;
    }
  }
  return mask;
}

// How many lines of one direction lie within kStripes_px to one side of a place.
int parallels(const RoadPlace& place, int side, const PlaceIndex& index) {
  constexpr int kStripes_px = 60;
  const cv::Point2d across(-side * std::sin(double(place.theta_rad)), side * std::cos(double(place.theta_rad)));
  int count = 0, last = 0;  // where the last line was
  for (int d = 4; d <= kStripes_px; d += 2) {
    const RoadPlace* p = index.nearest(cv::Point2d(place.x, place.y) + across * d, 1.5);
    if (p == nullptr || std::abs(std::remainder(double(p->theta_rad - place.theta_rad), std::numbers::pi)) > 0.26)
      continue;
    count += d - last > 4;
    last = d;
  }
  return count;
}

// Furrows, rows of plants and waves: lines at equal distances, closer than streets are.
std::vector<RoadPlace> without_stripes(const PlaceIndex& index) {
  constexpr int kOnOneSide = 3, kOnBoth = 5;
  std::vector<RoadPlace> out;
  for (const RoadPlace& p : index.places()) {
    const int left = parallels(p, -1, index), right = parallels(p, 1, index);
    if (std::max(left, right) < kOnOneSide && left + right < kOnBoth) out.push_back(p);
  }
  return out;
}

void draw(const std::vector<Path>& paths, cv::Mat& mask) {
  for (const Path& path : paths)
    for (size_t i = 1; i < path.points.size(); ++i)
      cv::line(mask, cv::Point(path.points[i - 1]), cv::Point(path.points[i]), cv::Scalar(255));
}

std::vector<Path> linked(const PlaceIndex& index, const cv::Size& size, const Evidence& evidence,
                         const RoadGraphOptions& options) {
  cv::Mat mask = chains(index, size, options);
  thin(mask);
  std::vector<Path> paths = prune(join(trace(mask)), options.spur_px, size);
  for (size_t round = 0; round < std::size(kRounds); ++round) {
    mask.setTo(0);
    close_gaps(paths, index, evidence, options, kRounds[round], mask);
    draw(paths, mask);
    thin(mask);
    paths = prune(join(trace(mask)), round + 1 < std::size(kRounds) ? 6 : 10, size);
  }
  return paths;
}

// Dead ends and pieces must be long for how likely they are, but for those that leave the map.
std::vector<Path> without_dead_ends(std::vector<Path> paths, const PlaceIndex& index, const cv::Size& size,
                                    const RoadGraphOptions& options) {
  for (int round = 0; round < 2; ++round) {
    const std::vector<int> degrees = degrees_of(paths);
    std::vector<Path> out;
    for (Path& p : paths) {
      const bool from_free = degrees[size_t(p.from)] == 1, to_free = degrees[size_t(p.to)] == 1;
      const bool leaves =
          (from_free && at_border(p.points.front(), size, 6)) || (to_free && at_border(p.points.back(), size, 6));
      const double mean = index.mean_probability(p), worth = length_of(p.points) * mean;
      const double least = from_free && to_free ? options.least_component_px : options.least_dead_end_px;
      if (mean < 0.2 || ((from_free || to_free) && !leaves && worth < least)) continue;
      out.push_back(std::move(p));
    }
    paths = join(std::move(out));
  }
  return paths;
}

std::vector<Path> without_small_components(std::vector<Path> paths, const PlaceIndex& index, double least) {
  std::vector<Path> out;
  for (const std::vector<size_t>& group : components_of(paths)) {
    double worth = 0;
    for (const size_t i : group) worth += length_of(paths[i].points) * index.mean_probability(paths[i]);
    if (worth < least) continue;
    for (const size_t i : group) out.push_back(std::move(paths[i]));
  }
  return out;
}

// Branches that lie close to each other become one node.
std::vector<Path> with_whole_junctions(std::vector<Path> paths, double junction_px) {
  const std::vector<int> degrees = degrees_of(paths);
  NodeSets sets(degrees.size());
  for (const Path& p : paths)
    if (p.from != p.to && degrees[size_t(p.from)] >= 3 && degrees[size_t(p.to)] >= 3 &&
        length_of(p.points) < junction_px)
      sets.unite(p.from, p.to);
  std::vector<Path> out;
  for (Path& p : paths) {
    p.from = sets.root(p.from);
    p.to = sets.root(p.to);
    if (p.from != p.to || length_of(p.points) >= 3 * junction_px) out.push_back(std::move(p));
  }
  return join(std::move(out));
}

// A road's line as an intersection sees it: the points from 6 to 28 pixels along.
struct Leg {
  cv::Point2d mean, normal;
  double weight;
};

Leg leg_of(const std::vector<cv::Point2d>& line) {
  std::vector<cv::Point2d> part;
  double s = 0;
  for (size_t i = 0; i < line.size(); ++i) {
    if (i > 0) s += cv::norm(line[i] - line[i - 1]);
    if (s >= 6 && s <= 28) part.push_back(line[i]);
  }
  if (part.size() < 5) part.assign(line.begin(), line.begin() + ptrdiff_t(std::min<size_t>(line.size(), 12)));
  cv::Point2d mean(0, 0);
  for (const cv::Point2d& p : part) mean += p * (1.0 / double(part.size()));
  double xx = 0, xy = 0, yy = 0;
  for (const cv::Point2d& p : part) {
    xx += (p.x - mean.x) * (p.x - mean.x);
    xy += (p.x - mean.x) * (p.y - mean.y);
    yy += (p.y - mean.y) * (p.y - mean.y);
  }
  const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
  return {mean, {-std::sin(angle), std::cos(angle)}, std::min(1.0, double(part.size()) / 15)};
}

// The point nearest to all legs, at most 8 pixels from where the lines meet.
cv::Point2d meeting_point(const std::vector<std::vector<cv::Point2d>>& lines) {
  constexpr double kStay = 0.02, kFarthest = 8;
  cv::Point2d start(0, 0);
  for (const auto& line : lines) start += line.front() * (1.0 / double(lines.size()));
  double xx = kStay, xy = 0, yy = kStay;
  cv::Point2d right = start * kStay;
  for (const auto& line : lines) {
    const Leg leg = leg_of(line);
    xx += leg.weight * leg.normal.x * leg.normal.x;
    xy += leg.weight * leg.normal.x * leg.normal.y;
    yy += leg.weight * leg.normal.y * leg.normal.y;
    right += leg.normal * (leg.weight * leg.normal.dot(leg.mean));
  }
  const double determinant = xx * yy - xy * xy;
  const cv::Point2d at((yy * right.x - xy * right.y) / determinant, (xx * right.y - xy * right.x) / determinant);
  const cv::Point2d moved = at - start;
  const double distance = cv::norm(moved);
  return distance > kFarthest ? start + moved * (kFarthest / distance) : at;
}

// A Gaussian of 3 pixels; the ends stay.
std::vector<cv::Point2d> smoothed(const std::vector<cv::Point2d>& line) {
  constexpr int kRadius = 9;
  constexpr double kSigma = 3;
  const int n = int(line.size());
  if (n < 5) return line;
  const auto at = [&](int i) {  // mirrored at the ends' points
    if (i < 0) return line.front() * 2 - line[size_t(std::min(n - 1, -i))];
    if (i >= n) return line.back() * 2 - line[size_t(std::max(0, 2 * (n - 1) - i))];
    return line[size_t(i)];
  };
  std::vector<cv::Point2d> out;
  for (int i = 0; i < n; ++i) {
    cv::Point2d sum(0, 0);
    double weights = 0;
    for (int k = -kRadius; k <= kRadius; ++k) {
      const double w = std::exp(-0.5 * k * k / (kSigma * kSigma));
      sum += at(i + k) * w;
      weights += w;
    }
    out.push_back(sum * (1 / weights));
  }
  return out;
}

std::vector<cv::Point2d> simplified(const std::vector<cv::Point2d>& line, double error_px) {
  // In single precision only relative to the line's start.
  std::vector<cv::Point2f> relative, kept;
  for (const cv::Point2d& p : line) relative.emplace_back(p - line.front());
  cv::approxPolyDP(relative, kept, error_px, false);
  std::vector<cv::Point2d> out;
  for (const cv::Point2f& p : kept) out.push_back(line.front() + cv::Point2d(p));
  return out;
}

std::map<int, cv::Point2d> junctions(const std::vector<Path>& paths) {
  std::map<int, std::vector<std::vector<cv::Point2d>>> lines;
  for (const Path& p : paths) {
    lines[p.from].push_back(p.points);
    lines[p.to].emplace_back(p.points.rbegin(), p.points.rend());
  }
  std::map<int, cv::Point2d> out;
  for (const auto& [node, of_node] : lines)
    if (of_node.size() >= 3) out[node] = meeting_point(of_node);
  return out;
}

// Smoothed, its ends at the junctions, simplified.
std::vector<cv::Point2d> final_line(const Path& path, const std::map<int, cv::Point2d>& at, double error_px) {
  std::vector<cv::Point2d> line = smoothed(path.points);
  const auto first = at.find(path.from), last = at.find(path.to);
  const size_t trim = size_t(std::min<ptrdiff_t>(kTrimmed, (std::ssize(line) - 1) / 2));
  if (first != at.end()) {
    line.erase(line.begin(), line.begin() + ptrdiff_t(trim));
    line.insert(line.begin(), first->second);
  }
  if (last != at.end()) {
    line.erase(line.end() - ptrdiff_t(std::min(trim, line.size() - 1)), line.end());
    line.push_back(last->second);
  }
  return simplified(line, error_px);
}

std::vector<RoadLine> lines_of(const std::vector<Path>& paths, const PlaceIndex& index, double error_px) {
  const std::map<int, cv::Point2d> at = junctions(paths);
  std::vector<RoadLine> lines;
  for (const Path& path : paths)
    lines.push_back({final_line(path, at, error_px), index.width_px(path), index.mean_probability(path)});
  return lines;
}

tiles::RoadGraph graph_of(const PlanarRoads& roads, const PixelFrame& frame) {
  const auto on_grid = [&](const cv::Point2d& p) {
    return tiles::RoadPoint{frame.west_m + (p.x + 0.5) * frame.gsd_m, frame.north_m - (p.y + 0.5) * frame.gsd_m};
  };
  tiles::RoadGraph graph;
  std::vector<int> arms(roads.nodes.size(), 0);
  for (const PlanarRoads::Edge& e : roads.edges) {
    ++arms[e.from];
    ++arms[e.to];
    tiles::RoadEdge edge;
    edge.from = uint32_t(e.from);
    edge.to = uint32_t(e.to);
    edge.width_m = e.line.width_px * frame.gsd_m;
    edge.confidence = e.line.probability;
    for (size_t i = 1; i + 1 < e.line.points.size(); ++i) edge.vertices.push_back(on_grid(e.line.points[i]));
    graph.edges.push_back(std::move(edge));
  }
  for (size_t i = 0; i < roads.nodes.size(); ++i) {
    const tiles::RoadPoint p = on_grid(roads.nodes[i]);
    graph.nodes.push_back({p.east_m, p.north_m,
                           arms[i] >= 3   ? tiles::RoadNodeKind::kIntersection
                           : arms[i] == 2 ? tiles::RoadNodeKind::kJoint
                                          : tiles::RoadNodeKind::kEnd});
  }
  return graph;
}

}  // namespace

PlaceIndex::PlaceIndex(std::span<const RoadPlace> places, float low) {
  for (const RoadPlace& p : places)
    if (p.probability > low) places_.push_back(p);
  // The index visits places in the order in which they were added: that must not depend on the blocks.
  std::sort(places_.begin(), places_.end(),
            [](const RoadPlace& a, const RoadPlace& b) { return std::tie(a.y, a.x) < std::tie(b.y, b.x); });
  for (size_t i = 0; i < places_.size(); ++i) grid_.add({double(places_[i].x), double(places_[i].y)}, int(i));
}

const RoadPlace* PlaceIndex::nearest(const cv::Point2d& p, double radius) const {
  const int found = grid_.nearest(p, radius);
  return found < 0 ? nullptr : &places_[size_t(found)];
}

double PlaceIndex::mean_probability(const Path& path) const {
  double sum = 0;
  for (const cv::Point2d& p : path.points) {
    const RoadPlace* place = nearest(p, kNearPlace);
    if (place != nullptr) sum += double(place->probability);
  }
  return sum / double(path.points.size());
}

double PlaceIndex::width_px(const Path& path) const {
  std::vector<float> widths;
  for (const cv::Point2d& p : path.points)
    if (const RoadPlace* place = nearest(p, kNearPlace)) widths.push_back(place->width_px);
  if (widths.empty()) return 0;
  std::nth_element(widths.begin(), widths.begin() + ptrdiff_t(widths.size() / 2), widths.end());
  return double(widths[widths.size() / 2]);
}

tiles::RoadGraph link_roads(std::span<const RoadPlace> places, const cv::Size& size, const Evidence& evidence,
                            const PixelFrame& frame, const RoadGraphOptions& options) {
  const PlaceIndex index(without_stripes(PlaceIndex(places, options.low)), options.low);
  std::vector<Path> paths = linked(index, size, evidence, options);
  paths = without_dead_ends(std::move(paths), index, size, options);
  paths = without_small_components(std::move(paths), index, options.least_component_px);
  paths = with_whole_junctions(join(std::move(paths)), options.junction_px);
  return graph_of(planar_roads(lines_of(paths, index, options.simplify_px), options.roundabout_px), frame);
}

}  // namespace landfix::landmarks
