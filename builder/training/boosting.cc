#include "builder/training/boosting.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "builder/error.h"

namespace landfix::landmarks {
namespace {

constexpr int kBins = 255;

// Values as numbers of bins: bin b holds the values up to limits[b] and above limits[b - 1].
struct Binned {
  std::vector<std::vector<float>> limits;  // per feature
  std::vector<uint8_t> rows;               // features x rows
};

Binned bin(std::span<const float> values, size_t features) {
  Binned out;
  const size_t rows = values.size() / features;
  out.limits.resize(features);
  out.rows.resize(values.size());
  std::vector<float> column(rows);
  for (size_t f = 0; f < features; ++f) {
    for (size_t i = 0; i < rows; ++i) column[i] = values[i * features + f];
    std::sort(column.begin(), column.end());
    std::vector<float>& limits = out.limits[f];
    for (int b = 1; b < kBins; ++b) {
      const float limit = column[rows * size_t(b) / kBins];
      if ((limits.empty() || limit > limits.back()) && limit < column.back()) limits.push_back(limit);
    }
    for (size_t i = 0; i < rows; ++i)
      out.rows[i * features + f] =
          uint8_t(std::lower_bound(limits.begin(), limits.end(), values[i * features + f]) - limits.begin());
  }
  return out;
}

// Per output the sums of gradients and of second derivatives, then the number of rows.
using Sum = std::vector<double>;

struct Leaf {
  std::vector<uint32_t> rows;
  std::vector<double> histogram;  // features x kBins sums
  Sum sum;
  double gain = 0;  // of its best split; 0: there is none
  size_t feature = 0;
  int bin = 0;
  int parent = -1;  // split whose child this is
  bool high = false;
};

class Booster {
 public:
  /// `allowed`: of one output bit 0 says that the row is positive.
  Booster(std::span<const float> values, size_t features, std::span<const uint8_t> allowed, size_t outputs,
          const BoostingOptions& options)
      : features_(features),
        outputs_(outputs),
        width_(2 * outputs + 1),
        allowed_(allowed),
        options_(options),
        data_(bin(values, features)),
        score_(allowed.size() * outputs),
        gradient_(allowed.size() * width_) {}

  features::BoostedTrees run() {
    const std::vector<double> bias = biases();
    for (size_t i = 0; i < allowed_.size(); ++i) std::copy(bias.begin(), bias.end(), &score_[i * outputs_]);
    std::vector<features::DecisionTree> trees;
    for (int i = 0; i < options_.trees; ++i) trees.push_back(grow());
    return {uint16_t(features_), {bias.begin(), bias.end()}, std::move(trees)};
  }

 private:
  std::vector<double> biases() const {
    std::vector<double> count(outputs_);
    for (const uint8_t bits : allowed_)
      for (size_t k = 0; k < outputs_; ++k) count[k] += bits == 1u << k;
    if (outputs_ == 1) return {std::log(count[0] / (double(allowed_.size()) - count[0]))};
    for (double& c : count) c = std::log(c / double(allowed_.size()));
    return count;
  }

  void measure_gradients() {
    std::vector<double> p(outputs_);
    for (size_t i = 0; i < allowed_.size(); ++i) {
      const double* score = &score_[i * outputs_];
      double* sum = &gradient_[i * width_];
      if (outputs_ == 1) {
        p[0] = 1 / (1 + std::exp(-score[0]));
        sum[0] = p[0] - double(allowed_[i]);
      } else {
        const double top = *std::max_element(score, score + outputs_);
        double all = 0, within = 0;
        for (size_t k = 0; k < outputs_; ++k) {
          all += p[k] = std::exp(score[k] - top);
          within += (allowed_[i] >> k & 1) * p[k];
        }
        for (size_t k = 0; k < outputs_; ++k) sum[k] = p[k] / all - (allowed_[i] >> k & 1) * p[k] / within;
        for (double& value : p) value /= all;
      }
      for (size_t k = 0; k < outputs_; ++k) sum[outputs_ + k] = p[k] * (1 - p[k]);
      sum[2 * outputs_] = 1;
    }
  }

  void add(double* to, const double* sum) const {
    for (size_t k = 0; k < width_; ++k) to[k] += sum[k];
  }

  std::vector<double> histogram_of(const std::vector<uint32_t>& rows) const {
    std::vector<double> h(features_ * kBins * width_);
    for (const uint32_t row : rows)
      for (size_t f = 0; f < features_; ++f)
        add(&h[(f * kBins + data_.rows[row * features_ + f]) * width_], &gradient_[row * width_]);
    return h;
  }

  double worth(const double* s) const {
    double sum = 0;
    for (size_t k = 0; k < outputs_; ++k) sum += s[k] * s[k] / (s[outputs_ + k] + options_.l2);
    return sum;
  }

  void find_split(Leaf& leaf) const {
    leaf.gain = 0;
    Sum low(width_), high(width_);
    for (size_t f = 0; f < features_; ++f) {
      std::fill(low.begin(), low.end(), 0);
      for (int b = 0; b < int(data_.limits[f].size()); ++b) {
        add(low.data(), &leaf.histogram[(f * kBins + size_t(b)) * width_]);
        for (size_t k = 0; k < width_; ++k) high[k] = leaf.sum[k] - low[k];
        if (low.back() < options_.least_rows || high.back() < options_.least_rows) continue;
        const double gain = worth(low.data()) + worth(high.data()) - worth(leaf.sum.data());
        if (gain <= leaf.gain + 1e-9) continue;
        leaf.gain = gain;
        leaf.feature = f;
        leaf.bin = b;
      }
    }
  }

  Leaf root() const {
    Leaf leaf;
    leaf.rows.resize(allowed_.size());
    std::iota(leaf.rows.begin(), leaf.rows.end(), 0u);
    leaf.sum.resize(width_);
    for (const uint32_t row : leaf.rows) add(leaf.sum.data(), &gradient_[row * width_]);
    leaf.histogram = histogram_of(leaf.rows);
    find_split(leaf);
    return leaf;
  }

  // Splits a leaf into itself (low) and what is returned (high). Only the smaller half is counted anew.
  Leaf split(Leaf& leaf, int number) const {
    Leaf high;
    std::vector<uint32_t> low;
    for (const uint32_t row : leaf.rows)
      (data_.rows[row * features_ + leaf.feature] <= leaf.bin ? low : high.rows).push_back(row);
    const bool low_smaller = low.size() < high.rows.size();
    std::vector<double> smaller = histogram_of(low_smaller ? low : high.rows);
    for (size_t i = 0; i < smaller.size(); ++i) leaf.histogram[i] -= smaller[i];
    high.histogram = std::move(smaller);
    if (low_smaller) std::swap(high.histogram, leaf.histogram);
    high.sum.resize(width_);
    for (const uint32_t row : high.rows) add(high.sum.data(), &gradient_[row * width_]);
    for (size_t k = 0; k < width_; ++k) leaf.sum[k] -= high.sum[k];
    leaf.rows = std::move(low);
    leaf.parent = high.parent = number;
    leaf.high = false;
    high.high = true;
    find_split(leaf);
    find_split(high);
    return high;
  }

  features::DecisionTree grow() {
    measure_gradients();
    std::vector<Leaf> leaves;
    leaves.push_back(root());
    features::DecisionTree tree;
    const auto attach = [&](const Leaf& leaf, int16_t index) {
      if (leaf.parent < 0) return;
      features::DecisionTree::Split& s = tree.splits[size_t(leaf.parent)];
      (leaf.high ? s.high : s.low) = index;
    };
    while (int(leaves.size()) < options_.leaves) {
      const auto best =
          std::max_element(leaves.begin(), leaves.end(), [](const Leaf& a, const Leaf& b) { return a.gain < b.gain; });
      if (best->gain <= 0) break;
      const int number = int(tree.splits.size());
      attach(*best, int16_t(number));
      tree.splits.push_back(
          {uint16_t(best->feature), data_.limits[best->feature][size_t(best->bin)], int16_t(0), int16_t(0)});
      Leaf high = split(*best, number);
      leaves.push_back(std::move(high));
    }
    for (size_t i = 0; i < leaves.size(); ++i) {
      const Leaf& leaf = leaves[i];
      attach(leaf, int16_t(-1 - int(i)));
      for (size_t k = 0; k < outputs_; ++k) {
        const float value = float(-options_.rate * leaf.sum[k] / (leaf.sum[outputs_ + k] + options_.l2));
        tree.leaves.push_back(value);
        for (const uint32_t row : leaf.rows) score_[row * outputs_ + k] += double(value);
      }
    }
    return tree;
  }

  const size_t features_, outputs_, width_;
  const std::span<const uint8_t> allowed_;
  const BoostingOptions options_;
  const Binned data_;
  std::vector<double> score_;
  std::vector<double> gradient_;
};

}  // namespace

features::BoostedTrees boost(std::span<const float> values, size_t features, std::span<const uint8_t> positive,
                             const BoostingOptions& options) {
  const size_t yes = std::accumulate(positive.begin(), positive.end(), size_t(0));
  if (yes == 0 || yes == positive.size())
    throw Error(ExitCode::kBadInput,
                "expected examples of a class and of others to learn from, found only one of them");
  return Booster(values, features, positive, 1, options).run();
}

features::BoostedTrees boost_classes(std::span<const float> values, size_t features, std::span<const uint8_t> allowed,
                                     size_t classes, const BoostingOptions& options) {
  for (size_t k = 0; k < classes; ++k)
    if (std::find(allowed.begin(), allowed.end(), uint8_t(1u << k)) == allowed.end())
      throw Error(ExitCode::kBadInput, "expected examples of every class to learn from, found one class without any");
  return Booster(values, features, allowed, classes, options).run();
}

}  // namespace landfix::landmarks
