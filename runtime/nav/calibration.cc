#include "runtime/nav/calibration.h"

#include <algorithm>
#include <cmath>

namespace landfix::nav {
namespace {

/// Logistic regression on (1, gap, gap / spread, value, log of the independent pixels).
struct Coefficients {
  double constant, gap, significance, value, samples;
};

// clang-format off
constexpr Coefficients kCoefficients[] = {
    {-2, 20, 0.5, 0, 0},  // gray
    {-2, 20, 0.5, 0, 0},  // edge
    {-2, 20, 0.5, 0, 0},  // contour
    {-2, 40, 0.5, 0, 0},  // orientation
};
constexpr double kStandardThreshold = 0.9, kStrictThreshold = 0.99;
// clang-format on

double logit(double p) { return std::log(p / (1 - p)); }
double logistic(double x) { return 1 / (1 + std::exp(-std::clamp(x, -30.0, 30.0))); }

}  // namespace

double probability_of(Method method, const Evidence& e) {
  const Coefficients& c = kCoefficients[size_t(method)];
  const double significance = e.gap / std::max(e.spread, 1e-6);
  return logistic(c.constant + c.gap * e.gap + c.significance * std::min(significance, 20.0) + c.value * e.value +
                  c.samples * std::log(std::max(e.independent_pixels, 1.0)));
}

double combined_probability(double first, double second, bool agree) {
  const double a = logit(first), b = logit(second);
  return agree ? logistic(std::max(a, b) + 0.5 * std::max(std::min(a, b), 0.0) + 1) : logistic(std::max(a, b) - 0.5);
}

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
