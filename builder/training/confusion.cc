#include "builder/training/confusion.h"

#include <algorithm>
#include <cmath>

namespace landfix::landmarks {

void Judgement::add(features::LandmarkLabel truth, const features::LandmarkAnswer& answer) {
  ++confusion[size_t(truth)][size_t(answer.label)];
  answers.emplace_back(answer.confidence, answer.label == truth);
}

double Judgement::calibration_error() const {
  constexpr int kBins = 10;
  std::array<double, kBins> excess{};
  for (const auto& [probability, right] : answers)
    excess[size_t(std::clamp(int(probability * kBins), 0, kBins - 1))] += double(probability) - right;
  double sum = 0;
  for (const double e : excess) sum += std::abs(e);
  return answers.empty() ? NAN : sum / double(answers.size());
}

}  // namespace landfix::landmarks
