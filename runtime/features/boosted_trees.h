// Gradient-boosted decision trees: the probability of a class from a vector of numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace landfix::features {

enum class TreesError : uint8_t {
  kNone = 0,
  kTruncated,  ///< fewer bytes than it says
  kNotTrees,   ///< another kind of file
  kVersion,    ///< of a version that is not known
  kDamaged     ///< numbers out of their range
};

/// One tree: inner nodes in an order in which children come after their parent.
struct DecisionTree {
  struct Split {
    uint16_t feature = 0;
    float threshold = 0;        ///< values up to it go to `low`
    int16_t low = 0, high = 0;  ///< index of a split, or -1 - index of a leaf
  };
  std::vector<Split> splits;
  std::vector<float> leaves;  ///< one value per output each, at least one leaf; without splits the first serves all
};

/// One score or one per class: bias + sum of the trees' leaves.
class BoostedTrees {
 public:
  BoostedTrees() = default;
  /// `bias`: one number per output.
  BoostedTrees(uint16_t features, std::vector<float> bias, std::vector<DecisionTree> trees)
      : features_(features), bias_(std::move(bias)), trees_(std::move(trees)) {}

  /// Reads what serialise() wrote from the start of `bytes`; `used` tells how many of them. Never reads beyond. Where
  /// it fails the trees are left as they were.
  TreesError parse(std::span<const uint8_t> bytes, size_t& used);

  /// Little-endian: "LFBT", u32 version, u16 features, u16 trees, in version 2 u16 outputs (1 in version 1), f32 bias
  /// of each output; per tree u16 splits, u16 leaves, splits of {u16 feature, f32 threshold, i16 low, i16 high}, of
  /// each leaf an f32 per output. Version 1 where there is one output.
  std::vector<uint8_t> serialise() const;

  uint16_t features() const { return features_; }
  size_t outputs() const { return bias_.size(); }
  size_t size() const { return trees_.size(); }

  /// Of trees with one output: P = 1 / (1 + exp(-score)). `values`: as many as features(). Does not allocate.
  float probability(std::span<const float> values) const;

  /// `scores`: one per output. Does not allocate.
  void measure(std::span<const float> values, std::span<float> scores) const;

 private:
  uint16_t features_ = 0;
  std::vector<float> bias_{0};
  std::vector<DecisionTree> trees_;
};

/// What an error means, for messages.
const char* text_of(TreesError error);

}  // namespace landfix::features
