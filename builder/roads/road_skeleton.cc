#include "builder/roads/road_skeleton.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

namespace landfix::landmarks {
namespace {

// Clockwise from north.
const std::array<cv::Point, 8> kAround = {{{0, -1}, {1, -1}, {1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}}};

bool removable(const cv::Mat& padded, const cv::Point& p, int phase) {
  std::array<bool, 8> n;
  for (size_t i = 0; i < 8; ++i) n[i] = padded.at<uint8_t>(p + kAround[i]) != 0;
  const auto count = std::count(n.begin(), n.end(), true);
  int rises = 0;
  for (size_t i = 0; i < 8; ++i) rises += !n[i] && n[(i + 1) % 8];
  if (count < 2 || count > 6 || rises != 1) return false;
  return phase == 0 ? !(n[0] && n[2] && n[4]) && !(n[2] && n[4] && n[6])
                    : !(n[0] && n[2] && n[6]) && !(n[0] && n[4] && n[6]);
}

std::vector<cv::Point> pixels_of(const cv::Mat& mask) {
  std::vector<cv::Point> pixels;
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x)
      if (mask.at<uint8_t>(y, x) != 0) pixels.push_back({x, y});
  return pixels;
}

// Pixels and their neighbours; a diagonal counts where no pixel lies beside it.
struct PixelGraph {
  std::vector<cv::Point> pixels;
  std::vector<std::vector<int>> neighbours;
};

PixelGraph graph_of(const cv::Mat& thinned) {
  PixelGraph g;
  g.pixels = pixels_of(thinned);
  g.neighbours.resize(g.pixels.size());
  cv::Mat index(thinned.size(), CV_32SC1, cv::Scalar(-1));
  for (size_t i = 0; i < g.pixels.size(); ++i) index.at<int>(g.pixels[i]) = int(i);
  const cv::Rect all({0, 0}, thinned.size());
  const auto at = [&](const cv::Point& p) { return all.contains(p) ? index.at<int>(p) : -1; };
  for (size_t i = 0; i < g.pixels.size(); ++i) {
    for (size_t k = 0; k < 8; ++k) {
      const int other = at(g.pixels[i] + kAround[k]);
      if (other < 0) continue;
      const bool beside =
          k % 2 == 1 && (at(g.pixels[i] + kAround[k - 1]) >= 0 || at(g.pixels[i] + kAround[(k + 1) % 8]) >= 0);
      if (!beside) g.neighbours[i].push_back(other);
    }
  }
  return g;
}

// Follows the line from `first` over `second` to the next node or back to `first`.
std::vector<int> follow(const PixelGraph& g, int first, int second) {
  std::vector<int> line = {first, second};
  while (g.neighbours[size_t(line.back())].size() == 2 && line.back() != first) {
    const std::vector<int>& n = g.neighbours[size_t(line.back())];
    line.push_back(n[0] == line[line.size() - 2] ? n[1] : n[0]);
  }
  return line;
}

Path path_of(const PixelGraph& g, const std::vector<int>& line, std::map<int, int>& nodes) {
  const auto node = [&](int pixel) { return nodes.try_emplace(pixel, int(nodes.size())).first->second; };
  Path p;
  p.from = node(line.front());
  p.to = node(line.back());
  for (const int pixel : line) p.points.emplace_back(g.pixels[size_t(pixel)]);
  return p;
}

// Appends `b` to `a` at the node they share.
Path joined(Path a, Path b, int node) {
  if (a.to != node) {
    std::swap(a.from, a.to);
    std::reverse(a.points.begin(), a.points.end());
  }
  if (b.from != node) {
    std::swap(b.from, b.to);
    std::reverse(b.points.begin(), b.points.end());
  }
  a.points.insert(a.points.end(), b.points.begin() + 1, b.points.end());
  a.to = b.to;
  return a;
}

}  // namespace

double length_of(const std::vector<cv::Point2d>& points) {
  double sum = 0;
  for (size_t i = 1; i < points.size(); ++i) sum += cv::norm(points[i] - points[i - 1]);
  return sum;
}

size_t node_count(const std::vector<Path>& paths) {
  int most = -1;
  for (const Path& p : paths) most = std::max({most, p.from, p.to});
  return size_t(most + 1);
}

std::vector<int> degrees_of(const std::vector<Path>& paths) {
  std::vector<int> degrees(node_count(paths), 0);
  for (const Path& p : paths) {
    ++degrees[size_t(p.from)];
    ++degrees[size_t(p.to)];
  }
  return degrees;
}

bool at_border(const cv::Point2d& p, const cv::Size& size, double margin) {
  return std::min({p.x, p.y, size.width - 1 - p.x, size.height - 1 - p.y}) < margin;
}

void thin(cv::Mat& mask) {
  cv::Mat padded;
  cv::copyMakeBorder(mask, padded, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  std::vector<cv::Point> active = pixels_of(padded);
  for (bool changed = true; changed;) {
    changed = false;
    for (int phase = 0; phase < 2; ++phase) {
      std::vector<cv::Point> gone, left;
      for (const cv::Point& p : active) (removable(padded, p, phase) ? gone : left).push_back(p);
      for (const cv::Point& p : gone) padded.at<uint8_t>(p) = 0;
      active = std::move(left);
      changed |= !gone.empty();
    }
  }
  padded({1, 1, mask.cols, mask.rows}).copyTo(mask);
}

std::vector<Path> trace(const cv::Mat& thinned) {
  const PixelGraph g = graph_of(thinned);
  std::map<int, int> nodes;
  std::vector<Path> paths;
  std::set<std::pair<int, int>> walked;
  std::vector<bool> seen(g.pixels.size(), false);
  for (int i = 0; i < int(g.pixels.size()); ++i) {
    if (g.neighbours[size_t(i)].size() == 2) continue;
    for (const int next : g.neighbours[size_t(i)]) {
      if (walked.contains({i, next})) continue;
      const std::vector<int> line = follow(g, i, next);
      walked.insert({line[0], line[1]});
      walked.insert({line[line.size() - 1], line[line.size() - 2]});
      for (const int pixel : line) seen[size_t(pixel)] = true;
      paths.push_back(path_of(g, line, nodes));
    }
  }
  for (int i = 0; i < int(g.pixels.size()); ++i) {
    if (seen[size_t(i)] || g.neighbours[size_t(i)].size() != 2) continue;
    const std::vector<int> line = follow(g, i, g.neighbours[size_t(i)][0]);
    for (const int pixel : line) seen[size_t(pixel)] = true;
    if (line.size() > 20) paths.push_back(path_of(g, line, nodes));
  }
  return paths;
}

std::vector<Path> join(std::vector<Path> paths) {
  std::vector<std::vector<size_t>> at(node_count(paths));
  for (size_t i = 0; i < paths.size(); ++i) {
    at[size_t(paths[i].from)].push_back(i);
    at[size_t(paths[i].to)].push_back(i);
  }
  std::vector<bool> gone(paths.size(), false);
  for (int node = 0; node < int(at.size()); ++node) {
    const std::vector<size_t> two = at[size_t(node)];
    if (two.size() != 2 || two[0] == two[1]) continue;  // a ring stays one
    paths[two[0]] = joined(std::move(paths[two[0]]), std::move(paths[two[1]]), node);
    gone[two[1]] = true;
    std::vector<size_t>& beyond = at[size_t(paths[two[0]].to)];
    std::replace(beyond.begin(), beyond.end(), two[1], two[0]);
  }
  std::vector<Path> out;
  for (size_t i = 0; i < paths.size(); ++i)
    if (!gone[i]) out.push_back(std::move(paths[i]));
  return out;
}

std::vector<Path> prune(std::vector<Path> paths, double spur_px, const cv::Size& size) {
  for (int round = 0; round < 3; ++round) {
    std::vector<int> degrees = degrees_of(paths);
    std::vector<size_t> order(paths.size());
    std::iota(order.begin(), order.end(), size_t(0));
    std::stable_sort(order.begin(), order.end(),
                     [&](size_t a, size_t b) { return paths[a].points.size() < paths[b].points.size(); });
    std::vector<bool> gone(paths.size(), false);
    bool any = false;
    for (const size_t i : order) {
      const Path& p = paths[i];
      const bool from_free = degrees[size_t(p.from)] == 1, to_free = degrees[size_t(p.to)] == 1;
      if (from_free == to_free || length_of(p.points) >= spur_px) continue;
      if (at_border(from_free ? p.points.front() : p.points.back(), size, 4)) continue;
      gone[i] = any = true;
      --degrees[size_t(p.from)];
      --degrees[size_t(p.to)];
    }
    if (!any) break;
    std::vector<Path> left;
    for (size_t i = 0; i < paths.size(); ++i)
      if (!gone[i]) left.push_back(std::move(paths[i]));
    paths = join(std::move(left));
  }
  return paths;
}

NodeSets::NodeSets(size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }

int NodeSets::root(int node) {
  while (parent_[size_t(node)] != node) node = parent_[size_t(node)] = parent_[size_t(parent_[size_t(node)])];
  return node;
}

std::vector<std::vector<size_t>> components_of(const std::vector<Path>& paths) {
  NodeSets sets(node_count(paths));
  for (const Path& p : paths) sets.unite(p.from, p.to);
  std::map<int, std::vector<size_t>> groups;
  for (size_t i = 0; i < paths.size(); ++i) groups[sets.root(paths[i].from)].push_back(i);
  std::vector<std::vector<size_t>> out;
  for (auto& [root, group] : groups) out.push_back(std::move(group));
  return out;
}

}  // namespace landfix::landmarks
