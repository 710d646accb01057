// How a classifier's answers compare with the labels.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "runtime/features/landmark_classifier.h"

namespace landfix::landmarks {

/// Counts: rows are the truth, columns the answers, in the order of features::kLandmarkLabelNames.
using Confusion = std::array<std::array<int, features::kLandmarkLabels>, features::kLandmarkLabels>;

struct Judgement {
  Confusion confusion{};
  std::vector<std::pair<float, bool>> answers;  ///< stated probability, and whether the answer was right

  void add(features::LandmarkLabel truth, const features::LandmarkAnswer& answer);
  /// Expected calibration error: mean difference of stated probability and share of right answers over ten equal bins
  /// of probability, weighted by their answers (Naeini 2015); NaN of none.
  double calibration_error() const;
};

}  // namespace landfix::landmarks
