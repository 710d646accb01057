#include "builder/landmarks/region_merging.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <queue>
#include <tuple>
#include <utility>

namespace landfix::landmarks {
namespace {

using Node = MergeTree::Node;

constexpr int kMostChannels = 4;
constexpr int kLittle = 8;  // times the pixels of what joins a region: it hardly changes

// To a neighbouring region. What it costs is kept on the side of the lesser of both.
struct Link {
  int32_t other = 0, length = 0;  // the common boundary, in pixel sides
  float queued = -1;              // what the queue says that the merge costs; older entries of it do not count
};

// A merge that may be done, cheapest on top; equal ones in the order of their regions.
struct Merge {
  float cost = 0;
  int32_t a = 0, b = 0;  // a < b
  bool operator<(const Merge& o) const { return std::tie(cost, a, b) > std::tie(o.cost, o.a, o.b); }
};

// A region keeps the number of its first pixel while others join it; `node_` says which node it is. Links are sorted.
class Merging {
 public:
  Merging(const cv::Mat& colours, const cv::Mat& mask, double most, int most_px)
      : channels_(colours.channels()), most_(most), most_px_(most_px) {
    add_pixels(colours, mask);
    for (int32_t a = 0; a < int32_t(leaves_.size()); ++a)
      for (const Link& link : std::vector<Link>(links_[size_t(a)]))
        if (a < link.other) offer(a, link.other);
  }

  MergeTree run() {
    while (!queue_.empty()) {
      const Merge m = queue_.top();
      queue_.pop();
      const Link* link = find(m.a, m.b);
      if (!link || link->queued != m.cost) continue;
      // The regions may have grown since.
      if (cost_of(m.a, *link) > m.cost)
        offer(m.a, m.b);
      else
        merge(m);
    }
    order_pixels();
    return std::move(tree_);
  }

 private:
  using Sums = std::array<int64_t, kMostChannels>;

  void add_pixels(const cv::Mat& colours, const cv::Mat& mask) {
    cv::Mat ids(mask.size(), CV_32S, cv::Scalar(-1));
    for (int y = 0; y < mask.rows; ++y) {
      for (int x = 0; x < mask.cols; ++x) {
        if (!mask.at<uint8_t>(y, x)) continue;
        const auto id = int32_t(tree_.nodes.size());
        ids.at<int32_t>(y, x) = id;
        Node node;
        node.count = 1, node.box = {x, y, 1, 1};
        tree_.nodes.push_back(node);
        leaves_.push_back(y * mask.cols + x);
        Sums sums{};
        for (int k = 0; k < channels_; ++k) sums[size_t(k)] = colours.ptr<int16_t>(y, x)[k];
        sums_.push_back(sums);
        std::vector<Link>& links = links_.emplace_back();
        for (const cv::Point before : {cv::Point(x, y - 1), cv::Point(x - 1, y)}) {  // in the order of their numbers
          const int32_t other = before.x < 0 || before.y < 0 ? -1 : ids.at<int32_t>(before);
          if (other < 0) continue;
          links.push_back({other, 1, -1});
          links_[size_t(other)].push_back({id, 1, -1});
        }
      }
    }
    node_.resize(leaves_.size());
    std::iota(node_.begin(), node_.end(), 0);
    children_.assign(leaves_.size(), {-1, -1});
  }

  std::vector<Link>::iterator place(int32_t a, int32_t b) {
    return std::ranges::lower_bound(links_[size_t(a)], b, {}, &Link::other);
  }
  Link* find(int32_t a, int32_t b) {
    const auto at = place(a, b);
    return at != links_[size_t(a)].end() && at->other == b ? &*at : nullptr;
  }
  const Node& node_of(int32_t a) const { return tree_.nodes[size_t(node_[size_t(a)])]; }

  float cost_of(int32_t a, const Link& link) const {
    const double m = node_of(a).count, n = node_of(link.other).count;
    double squares = 0;
    for (size_t k = 0; k < size_t(channels_); ++k) {
      const double d = double(sums_[size_t(a)][k]) / m - double(sums_[size_t(link.other)][k]) / n;
      squares += d * d;
    }
    return float(m * n / (m + n) * squares / link.length);
  }

  void offer(int32_t first, int32_t second) {
    const int32_t a = std::min(first, second), b = std::max(first, second);
    Link& link = *find(a, b);
    link.queued = -1;
    if (node_of(a).count + node_of(b).count > most_px_) return;
    const float cost = cost_of(a, link);
    if (double(cost) > most_) return;
    link.queued = cost;
    queue_.push({cost, a, b});
  }

  void merge(const Merge& m) {
    // The one with fewer neighbours joins the other.
    const bool swaps = links_[size_t(m.a)].size() < links_[size_t(m.b)].size();
    const int32_t stays = swaps ? m.b : m.a, goes = swaps ? m.a : m.b;
    const Node &a = node_of(stays), &b = node_of(goes);
    const bool is_small = b.count * kLittle < a.count;
    Node node;
    node.count = a.count + b.count;
    node.box = a.box | b.box;
    node.strength = std::max({m.cost, a.strength, b.strength});
    children_.push_back({node_[size_t(stays)], node_[size_t(goes)]});
    for (const int32_t child : children_.back()) tree_.nodes[size_t(child)].parent = int32_t(tree_.nodes.size());
    node_[size_t(stays)] = int32_t(tree_.nodes.size());
    tree_.nodes.push_back(node);
    for (size_t k = 0; k < sums_[0].size(); ++k) sums_[size_t(stays)][k] += sums_[size_t(goes)][k];
    const std::vector<Link> moved = std::exchange(links_[size_t(goes)], {});
    links_[size_t(stays)].erase(place(stays, goes));
    for (const Link& link : moved) {
      if (link.other == stays) continue;
      links_[size_t(link.other)].erase(place(link.other, goes));
      for (const auto& [one, other] : {std::pair(stays, link.other), std::pair(link.other, stays)}) {
        const auto at = place(one, other);
        if (at != links_[size_t(one)].end() && at->other == other)
          at->length += link.length;
        else
          links_[size_t(one)].insert(at, {other, link.length, -1});
      }
      if (is_small) offer(stays, link.other);
    }
    // A little more changes the cost of the other links by little: they are looked at again when their turn comes.
    if (is_small) return;
    for (size_t i = 0; i < links_[size_t(stays)].size(); ++i) offer(stays, links_[size_t(stays)][i].other);
  }

  // Parents come after their children: from the last node on, each gives its children their share of its range.
  void order_pixels() {
    tree_.pixels.resize(leaves_.size());
    int32_t next = 0;
    for (size_t i = tree_.nodes.size(); i-- > 0;) {
      Node& node = tree_.nodes[i];
      if (node.parent < 0) node.first = next, next += node.count;
      if (const auto [a, b] = children_[i]; a >= 0) {
        tree_.nodes[size_t(a)].first = node.first;
        tree_.nodes[size_t(b)].first = node.first + tree_.nodes[size_t(a)].count;
      } else {
        tree_.pixels[size_t(node.first)] = leaves_[i];
      }
    }
  }

  const int channels_;
  const double most_;
  const int most_px_;
  MergeTree tree_;
  std::vector<int32_t> leaves_;
  std::vector<Sums> sums_;
  std::vector<std::vector<Link>> links_;
  std::vector<int32_t> node_;
  std::vector<std::array<int32_t, 2>> children_;
  std::priority_queue<Merge> queue_;
};

}  // namespace

cv::Mat log_colours(const cv::Mat& image) {
  cv::Mat table(1, 256, CV_16S), out;
  const double scale = 100 * std::sqrt(3.0 / image.channels());
  for (int v = 0; v < 256; ++v) table.at<int16_t>(v) = int16_t(std::lround(scale * std::log(v + 8.0)));
  cv::LUT(image, table, out);
  return out;
}

MergeTree merge_regions(const cv::Mat& colours, const cv::Mat& mask, double most, int most_px) {
  return Merging(colours, mask, most, most_px).run();
}

}  // namespace landfix::landmarks
