#include "runtime/nav/calibration.h"

#include <algorithm>
#include <cmath>

#include "runtime/nav/calibration_table.h"

namespace landfix::nav {
namespace {

/// Of the logits of two methods, where the second is asked because the first is not sure. Measured on the samples of
/// tools/calibrate: agreement is worth less than independence would give, as both see the same pixels.
constexpr double kAgreement = 0.5, kDoubt = 0.4;

/// No probability is closer to 0 or to 1: the samples, some ten thousand, cannot tell better.
constexpr double kMostCertain = 0.9999;

/// How fast, in spreads of the scores, a gap decides between a peak and one rival.
constexpr double kDecision = 2;

/// By Method: 95 % of the true matches of the samples lie in their ellipse of 95 %, or more.
constexpr double kVarianceFactors[] = {2.5, 8, 3, 1.3};

double logit(double p) { return std::log(p / (1 - p)); }
double logistic(double x) { return std::clamp(1 / (1 + std::exp(-x)), 1 - kMostCertain, kMostCertain); }

}  // namespace

double probability_of(Method method, const Evidence& e) {
  const double(&c)[6] = kCalibration[size_t(method)];
  const double gap = std::max(e.gap, 0.0), spread = std::max(e.spread, 1e-6),
               significance = std::min(gap / spread, kLargestSignificance),
               height = std::clamp(e.value / spread, 0.0, kLargestHeight);
  const double p =
      logistic(c[0] + c[1] * gap + c[2] * significance + c[3] * height -
               c[4] * std::log(std::max(e.similarities, 1.0)) + c[5] * std::log(std::max(e.sigma_px, 0.1)));
  // However sharp the peak: where a rival is as high, it is at best even.
  return std::min(p, 1 - 0.5 * std::exp(-kDecision * significance));
}

double combined_probability(double first, double second, bool agree) {
  const double surer = logit(std::max(first, second)), other = std::max(logit(std::min(first, second)), 0.0);
  return logistic(surer + (agree ? kAgreement : -kDoubt * other));
}

double variance_factor(Method method) { return kVarianceFactors[size_t(method)]; }

double threshold_of(Gate gate) {
  switch (gate) {
    case Gate::kNone:
      return 0;
    case Gate::kStandard:
      return kStandardThreshold;
    case Gate::kStrict:
      return kStrictThreshold;
  }
  return 1;
}

}  // namespace landfix::nav
