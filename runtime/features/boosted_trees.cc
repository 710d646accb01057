#include "runtime/features/boosted_trees.h"

#include <bit>
#include <cmath>

namespace landfix::features {
namespace {

constexpr uint32_t kMagic = 0x5442464c;                  // "LFBT"
constexpr uint32_t kOneOutput = 1, kSeveralOutputs = 2;  // versions
constexpr size_t kMostOutputs = 64;

class Reader {
 public:
  explicit Reader(std::span<const uint8_t> bytes) : bytes_(bytes) {}
  uint32_t take(size_t count) {
    if (bytes_.size() - at_ < count) {
      ok_ = false;
      return 0;
    }
    uint32_t value = 0;
    for (size_t i = 0; i < count; ++i) value |= uint32_t(bytes_[at_++]) << (8 * i);
    return value;
  }
  uint16_t u16() { return uint16_t(take(2)); }
  uint32_t u32() { return take(4); }
  float f32() { return std::bit_cast<float>(take(4)); }
  bool ok() const { return ok_; }
  size_t at() const { return at_; }
  size_t left() const { return bytes_.size() - at_; }

 private:
  std::span<const uint8_t> bytes_;
  size_t at_ = 0;
  bool ok_ = true;
};

void put(std::vector<uint8_t>& out, uint32_t value, size_t count) {
  for (size_t i = 0; i < count; ++i) out.push_back(uint8_t(value >> (8 * i)));
}

// Children come after their parent, so that no walk is endless.
bool leads_on(int16_t child, size_t parent, const DecisionTree& tree, size_t leaves) {
  return child < 0 ? size_t(-1 - child) < leaves : size_t(child) > parent && size_t(child) < tree.splits.size();
}

bool sound(const DecisionTree& tree, uint16_t features, size_t outputs) {
  const size_t leaves = tree.leaves.size() / outputs;
  if (leaves == 0) return false;
  for (size_t i = 0; i < tree.splits.size(); ++i) {
    const DecisionTree::Split& s = tree.splits[i];
    if (s.feature >= features || !std::isfinite(s.threshold)) return false;
    if (!leads_on(s.low, i, tree, leaves) || !leads_on(s.high, i, tree, leaves)) return false;
  }
  for (const float leaf : tree.leaves)
    if (!std::isfinite(leaf)) return false;
  return true;
}

TreesError read_tree(Reader& in, uint16_t features, size_t outputs, DecisionTree& tree) {
  const size_t splits = in.u16(), leaves = in.u16();
  if (!in.ok() || splits * 10 + leaves * outputs * 4 > in.left()) return TreesError::kTruncated;
  tree.splits.resize(splits);
  tree.leaves.resize(leaves * outputs);
  for (DecisionTree::Split& s : tree.splits) {
    s.feature = in.u16();
    s.threshold = in.f32();
    s.low = int16_t(in.u16());
    s.high = int16_t(in.u16());
  }
  for (float& leaf : tree.leaves) leaf = in.f32();
  return sound(tree, features, outputs) ? TreesError::kNone : TreesError::kDamaged;
}

}  // namespace

TreesError BoostedTrees::parse(std::span<const uint8_t> bytes, size_t& used) {
  Reader in(bytes);
  const uint32_t magic = in.u32(), version = in.u32();
  if (!in.ok()) return TreesError::kTruncated;
  if (magic != kMagic) return TreesError::kNotTrees;
  if (version != kOneOutput && version != kSeveralOutputs) return TreesError::kVersion;
  const uint16_t features = in.u16(), count = in.u16();
  const size_t outputs = version == kOneOutput ? 1 : in.u16();
  if (!in.ok()) return TreesError::kTruncated;
  if (outputs == 0 || outputs > kMostOutputs || (version == kSeveralOutputs && outputs == 1))
    return TreesError::kDamaged;
  std::vector<float> bias(outputs);
  for (float& value : bias) value = in.f32();
  if (!in.ok()) return TreesError::kTruncated;
  for (const float value : bias)
    if (!std::isfinite(value)) return TreesError::kDamaged;
  std::vector<DecisionTree> trees;
  for (uint16_t i = 0; i < count; ++i) {
    DecisionTree tree;
    if (const TreesError e = read_tree(in, features, outputs, tree); e != TreesError::kNone) return e;
    trees.push_back(std::move(tree));
  }
  *this = BoostedTrees(features, std::move(bias), std::move(trees));
  used = in.at();
  return TreesError::kNone;
}

std::vector<uint8_t> BoostedTrees::serialise() const {
  std::vector<uint8_t> out;
  put(out, kMagic, 4);
  put(out, outputs() == 1 ? kOneOutput : kSeveralOutputs, 4);
  put(out, features_, 2);
  put(out, uint32_t(trees_.size()), 2);
  if (outputs() > 1) put(out, uint32_t(outputs()), 2);
  for (const float value : bias_) put(out, std::bit_cast<uint32_t>(value), 4);
  for (const DecisionTree& tree : trees_) {
    put(out, uint32_t(tree.splits.size()), 2);
    put(out, uint32_t(tree.leaves.size() / outputs()), 2);
    for (const DecisionTree::Split& s : tree.splits) {
      put(out, s.feature, 2);
      put(out, std::bit_cast<uint32_t>(s.threshold), 4);
      put(out, uint16_t(s.low), 2);
      put(out, uint16_t(s.high), 2);
    }
    for (const float leaf : tree.leaves) put(out, std::bit_cast<uint32_t>(leaf), 4);
  }
  return out;
}

float BoostedTrees::probability(std::span<const float> values) const {
  float score = 0;
  measure(values, {&score, 1});
  return 1 / (1 + std::exp(-score));
}

void BoostedTrees::measure(std::span<const float> values, std::span<float> scores) const {
  const size_t outputs = bias_.size();
  for (size_t k = 0; k < outputs; ++k) scores[k] = bias_[k];
  for (const DecisionTree& tree : trees_) {
    int at = tree.splits.empty() ? -1 : 0;
    while (at >= 0) {
      const DecisionTree::Split& s = tree.splits[size_t(at)];
      at = values[s.feature] <= s.threshold ? s.low : s.high;
    }
    const float* leaf = &tree.leaves[size_t(-1 - at) * outputs];
    for (size_t k = 0; k < outputs; ++k) scores[k] += leaf[k];
  }
}

const char* text_of(TreesError error) {
  switch (error) {
    case TreesError::kNone:
      return "no error";
    case TreesError::kTruncated:
      return "the file ends early";
    case TreesError::kNotTrees:
      return "not a model of trees";
    case TreesError::kVersion:
      return "a version that is not known";
    case TreesError::kDamaged:
      return "numbers out of their range";
  }
  return "unknown error";
}

}  // namespace landfix::features
