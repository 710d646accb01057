#include "builder/training/platt.h"

#include <algorithm>
#include <cmath>

namespace landfix::landmarks {
namespace {

constexpr int kMostSteps = 100;
constexpr double kRidge = 1e-12, kSmallestGradient = 1e-7, kSmallestStep = 1e-10;

/// -log likelihood of one value with exponent z = a value + b, without overflow.
double loss(double z, double target) {
  return z >= 0 ? target * z + std::log1p(std::exp(-z)) : (target - 1) * z + std::log1p(std::exp(z));
}

}  // namespace

Sigmoid fit_sigmoid(const std::vector<double>& values, const std::vector<bool>& yes) {
  const double positives = double(std::count(yes.begin(), yes.end(), true));
  const double negatives = double(yes.size()) - positives;
  const double target[2] = {1 / (negatives + 2), (positives + 1) / (positives + 2)};
  Sigmoid s{0, std::log((negatives + 1) / (positives + 1))};
  const auto total = [&](const Sigmoid& at) {
    double sum = 0;
    for (size_t i = 0; i < values.size(); ++i) sum += loss(at.a * values[i] + at.b, target[yes[i]]);
    return sum;
  };
  double now = total(s);
  for (int step = 0; step < kMostSteps; ++step) {
    double aa = kRidge, ab = 0, bb = kRidge, ga = 0, gb = 0;
    for (size_t i = 0; i < values.size(); ++i) {
      const double p = 1 / (1 + std::exp(s.a * values[i] + s.b)), weight = p * (1 - p), d = target[yes[i]] - p;
      aa += values[i] * values[i] * weight, ab += values[i] * weight, bb += weight;
      ga += values[i] * d, gb += d;
    }
    if (std::max(std::abs(ga), std::abs(gb)) < kSmallestGradient) break;
    const double determinant = aa * bb - ab * ab;
    const double da = -(bb * ga - ab * gb) / determinant, db = -(aa * gb - ab * ga) / determinant;
    const double slope = ga * da + gb * db;
    double length = 1;
    for (; length >= kSmallestStep; length /= 2) {
      const Sigmoid next{s.a + length * da, s.b + length * db};
      const double then = total(next);
      if (then < now + 1e-4 * length * slope) {
        s = next, now = then;
        break;
      }
    }
    if (length < kSmallestStep) break;
  }
  return s;
}

}  // namespace landfix::landmarks
