// Trees: what they answer, and that no bytes of a file lead them astray.
#include "runtime/features/boosted_trees.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace landfix::features {
namespace {

// x0 <= 1: -2; else x1 <= 5: 1, else 3.
BoostedTrees small_trees() {
  DecisionTree tree;
  tree.splits = {{0, 1.0f, -1, 1}, {1, 5.0f, -2, -3}};
  tree.leaves = {-2, 1, 3};
  DecisionTree constant;
  constant.leaves = {0.5f};
  return {2, {-0.5f}, {tree, constant}};
}

// x0 <= 1: 1, 2, 3; else 4, 5, 6.
BoostedTrees trees_of_three_outputs() {
  DecisionTree tree;
  tree.splits = {{0, 1.0f, -1, -2}};
  tree.leaves = {1, 2, 3, 4, 5, 6};
  return {1, {0.5f, 0, -0.5f}, {tree}};
}

double logistic(double x) { return 1 / (1 + std::exp(-x)); }

TEST(BoostedTrees, AddUpTheirLeaves) {
  const BoostedTrees trees = small_trees();
  EXPECT_FLOAT_EQ(trees.probability(std::array{1.0f, 9.0f}), float(logistic(-2)));  // -0.5 - 2 + 0.5
  EXPECT_FLOAT_EQ(trees.probability(std::array{1.5f, 5.0f}), float(logistic(1)));
  EXPECT_FLOAT_EQ(trees.probability(std::array{1.5f, 5.5f}), float(logistic(3)));
}

TEST(BoostedTrees, GiveEveryOutputItsLeaf) {
  std::array<float, 3> scores{};
  trees_of_three_outputs().measure(std::array{1.0f}, scores);
  EXPECT_EQ(scores, (std::array{1.5f, 2.0f, 2.5f}));
  trees_of_three_outputs().measure(std::array{1.1f}, scores);
  EXPECT_EQ(scores, (std::array{4.5f, 5.0f, 5.5f}));
}

TEST(BoostedTrees, ComeBackFromTheirBytes) {
  std::vector<uint8_t> bytes = small_trees().serialise();
  const size_t size = bytes.size();
  bytes.push_back(7);  // what follows is not theirs
  BoostedTrees read;
  size_t used = 0;
  ASSERT_EQ(read.parse(bytes, used), TreesError::kNone);
  EXPECT_EQ(used, size);
  EXPECT_EQ(read.serialise(), small_trees().serialise());
  ASSERT_EQ(read.parse(trees_of_three_outputs().serialise(), used), TreesError::kNone);
  EXPECT_EQ(read.outputs(), 3u);
  EXPECT_EQ(read.serialise(), trees_of_three_outputs().serialise());
}

TEST(BoostedTrees, RefuseWhatIsNotTheirs) {
  std::vector<uint8_t> bytes = small_trees().serialise();
  BoostedTrees read;
  size_t used = 0;
  for (size_t n = 0; n < bytes.size(); ++n) EXPECT_EQ(read.parse({bytes.data(), n}, used), TreesError::kTruncated) << n;
  auto changed = bytes;
  changed[0] = 'X';
  EXPECT_EQ(read.parse(changed, used), TreesError::kNotTrees);
  changed = bytes;
  changed[4] = 3;
  EXPECT_EQ(read.parse(changed, used), TreesError::kVersion);
  changed = bytes;
  changed[26] = 0;  // the first split's high child (bytes 26 and 27): the split itself, a walk without end
  EXPECT_EQ(changed[28 - 2], 0);
  EXPECT_EQ(read.parse(changed, used), TreesError::kDamaged);
  EXPECT_EQ(read.size(), 0u);
}

TEST(BoostedTrees, SurviveAnyFlippedBit) {
  for (const BoostedTrees& trees : {small_trees(), trees_of_three_outputs()}) {
    const std::vector<uint8_t> bytes = trees.serialise();
    for (size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
      std::vector<uint8_t> changed = bytes;
      changed[bit / 8] ^= uint8_t(1u << (bit % 8));
      BoostedTrees read;
      size_t used = 0;
      if (read.parse(changed, used) != TreesError::kNone) continue;
      ASSERT_LE(used, bytes.size());
      const std::vector<float> values(read.features(), 2.0f);
      std::vector<float> scores(read.outputs(), NAN);
      read.measure(values, scores);
      for (const float score : scores) EXPECT_FALSE(std::isnan(score)) << bit;
    }
  }
}

}  // namespace
}  // namespace landfix::features
