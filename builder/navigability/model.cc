#include "builder/navigability/model.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <span>
#include <vector>

#include "builder/navigability/information.h"
#include "builder/navigability/model_table.h"

namespace landfix::navigability {
namespace {

static_assert(std::size(kOneDate) == size_t(nav::Method::kOrientation) &&
              std::size(kSeveralDates) == std::size(nav::kMethods));

/// No probability is closer to 0 or to 1: changes that no date shows come on top.
constexpr double kMostCertain = 0.995;

/// Share of the misses that pass the standard gate. On nine years of real farmland it was 0.092 over maps of four dates
/// and 0.053 over those of one, alike from doubtful places to good ones; in drawn worlds 0.016, whose changes are
/// tamer.
constexpr double kPassingMisses = 0.1;

/// Scale of the matches' covariances and floor in pixels: from dates that are matched with each other, from drawn views
/// of one, and from one that is matched with itself, which is far too sharp.
struct Spread {
  double scale, floor_px2;
};
constexpr Spread kBetweenDates{0.5, 0.16}, kOfViews{1, 0.4}, kOfItself{5, 0.4};

double logistic(double x) { return 1 / (1 + std::exp(-x)); }

double weighted(std::span<const double> coefficients, const std::vector<double>& values) {
  return std::inner_product(values.begin(), values.end(), coefficients.begin(), 0.0);
}

}  // namespace

double fix_probability(const Predictors& p, nav::Method method) {
  if (p.dates == 0) return 0;
  const double size = std::log(std::max(p.template_px, 1.0) / 40), structure = std::log(p.structure + kLeastStructure);
  double logit = 0;
  if (p.dates > 1)
    logit = weighted(kSeveralDates[size_t(method)],
                     {1, p.least_logit, p.mean_logit, structure, p.background, size, 1.0 / (p.dates * (p.dates - 1))});
  else if (method == nav::Method::kOrientation)
    logit = weighted(kDrawnViews, {1, structure, p.background, p.mean_logit, size, p.mean_logit * size});
  else
    logit = weighted(kOneDate[size_t(method)], {1, p.structure, p.background, p.crest, size});
  return std::clamp(logistic(logit), 1 - kMostCertain, kMostCertain);
}

double false_fix_probability(double fix) { return kPassingMisses * (1 - fix); }

std::array<double, 4> fix_covariance_m2(const Predictors& p, double gsd_m) {
  const Spread& s = p.dates > 1 ? kBetweenDates : p.views > 0 ? kOfViews : kOfItself;
  std::array<double, 4> out = p.covariance_m2;
  for (double& v : out) v *= s.scale;
  out[0] += s.floor_px2 * gsd_m * gsd_m;
  out[3] += s.floor_px2 * gsd_m * gsd_m;
  return bounded_below(out, p.least_covariance_m2);
}

}  // namespace landfix::navigability
