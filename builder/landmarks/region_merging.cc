#include "builder/landmarks/region_merging.h"

#include <algorithm>
#include <array>
#include <queue>
#include <tuple>

namespace landfix::landmarks {
namespace {

using Node = MergeTree::Node;

constexpr int kMostChannels = 4;

struct Link {
  int32_t other = 0, length = 0;  // region, common boundary in pixel sides
};

// A merge that may be done, cheapest on top; equal ones in the order of their regions.
struct Merge {
  double cost = 0;
  int32_t a = 0, b = 0;  // a < b
  bool operator<(const Merge& o) const { return std::tie(cost, a, b) > std::tie(o.cost, o.a, o.b); }
};

class Merging {
 public:
  Merging(const cv::Mat& colours, const cv::Mat& mask, double most, int most_px)
      : channels_(colours.channels()), most_(most), most_px_(most_px) {
    add_pixels(colours, mask);
    for (int32_t a = 0; a < int32_t(tree_.nodes.size()); ++a)
      for (const Link& link : links_[size_t(a)])
        if (a < link.other) offer(a, link);
  }

  MergeTree run() {
    while (!queue_.empty()) {
      const Merge m = queue_.top();
      queue_.pop();
      if (is_alive_[size_t(m.a)] && is_alive_[size_t(m.b)]) merge(m);
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
        for (const cv::Point before : {cv::Point(x - 1, y), cv::Point(x, y - 1)}) {
          const int32_t other = before.x < 0 || before.y < 0 ? -1 : ids.at<int32_t>(before);
          if (other < 0) continue;
          links.push_back({other, 1});
          links_[size_t(other)].push_back({id, 1});
        }
      }
    }
    is_alive_.assign(tree_.nodes.size(), true);
    children_.assign(tree_.nodes.size(), {-1, -1});
  }

  void offer(int32_t a, const Link& link) {
    const int32_t b = link.other;
    const double m = tree_.nodes[size_t(a)].count, n = tree_.nodes[size_t(b)].count;
    if (m + n > most_px_) return;
    double squares = 0;
    for (int k = 0; k < channels_; ++k) {
      const double d = double(sums_[size_t(a)][size_t(k)]) / m - double(sums_[size_t(b)][size_t(k)]) / n;
      squares += d * d;
    }
    const double cost = m * n / (m + n) * squares / link.length;
    if (cost <= most_) queue_.push({cost, std::min(a, b), std::max(a, b)});
  }

  void merge(const Merge& m) {
    const size_t a = size_t(m.a), b = size_t(m.b);
    const auto id = int32_t(tree_.nodes.size());
    Node node;
    node.count = tree_.nodes[a].count + tree_.nodes[b].count;
    node.box = tree_.nodes[a].box | tree_.nodes[b].box;
    node.strength = std::max({float(m.cost), tree_.nodes[a].strength, tree_.nodes[b].strength});
    tree_.nodes[a].parent = tree_.nodes[b].parent = id;
    is_alive_[a] = is_alive_[b] = false;
    tree_.nodes.push_back(node);
    is_alive_.push_back(true);
    children_.push_back({m.a, m.b});
    Sums sums;
    for (size_t k = 0; k < sums.size(); ++k) sums[k] = sums_[a][k] + sums_[b][k];
    sums_.push_back(sums);
    links_.push_back(joined_links(m));
    for (const Link& link : links_.back()) {
      std::vector<Link>& theirs = links_[size_t(link.other)];
      std::erase_if(theirs, [&](const Link& l) { return l.other == m.a || l.other == m.b; });
      theirs.push_back({id, link.length});
      offer(id, link);
    }
  }

  std::vector<Link> joined_links(const Merge& m) {
    std::vector<Link> all = std::move(links_[size_t(m.a)]), out;
    all.insert(all.end(), links_[size_t(m.b)].begin(), links_[size_t(m.b)].end());
    links_[size_t(m.a)] = {}, links_[size_t(m.b)] = {};
    std::ranges::sort(all, {}, &Link::other);
    for (const Link& link : all) {
      if (link.other == m.a || link.other == m.b) continue;
      if (!out.empty() && out.back().other == link.other)
        out.back().length += link.length;
      else
        out.push_back(link);
    }
    return out;
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
  std::vector<char> is_alive_;
  std::vector<std::array<int32_t, 2>> children_;
  std::priority_queue<Merge> queue_;
};

}  // namespace

MergeTree merge_regions(const cv::Mat& colours, const cv::Mat& mask, double most, int most_px) {
  return Merging(colours, mask, most, most_px).run();
}

}  // namespace landfix::landmarks
