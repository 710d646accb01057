// Gradient boosting of decision trees: what tells classes apart, from rows of numbers with known classes.
#pragma once

#include <cstdint>
#include <span>

#include "runtime/features/boosted_trees.h"

namespace landfix::landmarks {

struct BoostingOptions {
  int trees = 70;
  int leaves = 20;      ///< per tree, at most
  double rate = 0.2;    ///< of learning
  int least_rows = 40;  ///< in a leaf
  double l2 = 1;
};

/// Trees by boosting of the logistic loss (Friedman 2001) over histograms of at most 255 quantiles per feature, grown
/// leaf by leaf. `values`: rows of `features` numbers one behind the other; `positive`: one per row. The same bytes for
/// the same rows. Throws Error (kBadInput) without rows of both classes.
features::BoostedTrees boost(std::span<const float> values, size_t features, std::span<const uint8_t> positive,
                             const BoostingOptions& options);

/// The same for several classes with the loss of the softmax; every tree serves all of them. `allowed`: per row the
/// classes that it may be of, bit k for class k; where there are several, the trees' own guess decides between them.
/// Throws Error (kBadInput) without a row that is of one class alone, for any of them.
features::BoostedTrees boost_classes(std::span<const float> values, size_t features, std::span<const uint8_t> allowed,
                                     size_t classes, const BoostingOptions& options);

}  // namespace landfix::landmarks
