#include "tools/route/belief.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace landfix::route {
namespace {

constexpr double kNegligible = 1e-9;  ///< weight of a hypothesis that is not worth its own place

Eigen::Matrix2d symmetric(const Eigen::Matrix2d& m) { return 0.5 * (m + m.transpose()); }

/// Both as one, with the moments of the mixture: what their responses differ by is counted as noise.
Hypothesis merged(const Hypothesis& a, const Hypothesis& b) {
  const double weight = a.weight + b.weight, share = weight > 0 ? a.weight / weight : 0.5, rest = 1 - share;
  const Eigen::Matrix2d drift = a.drift - b.drift, bias = a.bias - b.bias;
  Hypothesis m;
  m.weight = weight;
  m.fixed = a.fixed;
  m.last_probability = share * a.last_probability + rest * b.last_probability;
  m.since_fix_m = std::isinf(a.since_fix_m) && std::isinf(b.since_fix_m) ? a.since_fix_m
                  : std::isinf(a.since_fix_m)                            ? b.since_fix_m
                  : std::isinf(b.since_fix_m)                            ? a.since_fix_m
                                                                         : share * a.since_fix_m + rest * b.since_fix_m;
  m.filter_m2 = share * a.filter_m2 + rest * b.filter_m2;
  m.drift = share * a.drift + rest * b.drift;
  m.bias = share * a.bias + rest * b.bias;
  m.match = share * a.match + rest * b.match;
  m.noise_m2 =
      share * a.noise_m2 + rest * b.noise_m2 + share * rest * (drift * drift.transpose() + bias * bias.transpose());
  return m;
}

/// How much is lost by taking two as one: weights times the squared distance of the logarithms of what is true and of
/// what the filter believes.
double merging_cost(const Hypothesis& a, double a_log, const Hypothesis& b, double b_log) {
  const double filter = 0.5 * std::log(a.filter_m2.trace() / b.filter_m2.trace()), error = a_log - b_log;
  return a.weight * b.weight / (a.weight + b.weight + 1e-300) * (error * error + filter * filter);
}

/// Merges neighbours by size of the error until no more than `limit` are left.
void reduce(std::vector<Hypothesis>& list, size_t limit) {
  std::stable_sort(list.begin(), list.end(), [](const Hypothesis& a, const Hypothesis& b) {
    return a.error_m2().trace() < b.error_m2().trace();
  });
  std::vector<double> logs;
  for (const Hypothesis& h : list) logs.push_back(0.5 * std::log(h.error_m2().trace()));
  while (list.size() > limit) {
    size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i + 1 < list.size(); ++i) {
      const double cost = merging_cost(list[i], logs[i], list[i + 1], logs[i + 1]);
      if (cost < least) least = cost, best = i;
    }
    list[best] = merged(list[best], list[best + 1]);
    logs[best] = 0.5 * std::log(list[best].error_m2().trace());
    list.erase(list.begin() + long(best) + 1);
    logs.erase(logs.begin() + long(best) + 1);
  }
}

/// After a fix whose error has a white part of this variance per axis, a constant one and, where `match` is not zero,
/// that times the process of the matches' errors.
Hypothesis with_fix(const Hypothesis& h, const FixUpdate& update, double white_m2, double bias_m,
                    const Eigen::Matrix2d& match) {
  const Eigen::Matrix2d keep = Eigen::Matrix2d::Identity() - update.gain, added = update.gain * match;
  Hypothesis out = h;
  out.since_fix_m = 0;
  out.filter_m2 = update.filter_m2;
  out.drift = keep * h.drift;
  out.bias = keep * h.bias + bias_m * update.gain;
  out.match = keep * h.match + added;
  const Eigen::Matrix2d both = keep * h.match * added.transpose();
  out.noise_m2 = symmetric(keep * h.noise_m2 * keep.transpose() + both + both.transpose() + added * added.transpose() +
                           white_m2 * update.gain * update.gain.transpose());
  return out;
}

}  // namespace

FixUpdate fix_update(const View& view, const Eigen::Matrix2d& filter_m2, double since_fix_m, double independent_m) {
  FixUpdate u;
  const double weight = since_fix_m < independent_m ? std::max(since_fix_m / independent_m, 1e-6) : 1;
  // As the localizer weighs: the match is tempered, the attitude's white noise is not.
  const Eigen::Matrix2d believed_m2 =
      view.match_m2 / weight + view.attitude_m * view.attitude_m * Eigen::Matrix2d::Identity();
  u.gain = filter_m2 * (filter_m2 + believed_m2).inverse();
  u.filter_m2 = symmetric((Eigen::Matrix2d::Identity() - u.gain) * filter_m2);
  return u;
}

Eigen::Matrix2d root(const Eigen::Matrix2d& covariance_m2) {
  // Of two by two, by Cayley and Hamilton.
  const double s = std::sqrt(std::max(covariance_m2.determinant(), 0.0)), t = std::sqrt(covariance_m2.trace() + 2 * s);
  return t > 0 ? Eigen::Matrix2d((covariance_m2 + s * Eigen::Matrix2d::Identity()) / t) : Eigen::Matrix2d::Zero();
}

double fix_probability_given(bool fixed, double last, double p, double correlation) {
  if (last < 0) return p;
  const double shared = correlation * std::sqrt(p * (1 - p) * last * (1 - last));
  if (fixed) return last > 0 ? std::clamp(p + shared / last, 0.0, 1.0) : p;
  return last < 1 ? std::clamp(p - shared / (1 - last), 0.0, 1.0) : p;
}

Belief::Belief(const ErrorModel& errors, int hypotheses) : limit_(std::max(hypotheses, 4)) {
  Hypothesis start;
  start.since_fix_m = std::numeric_limits<double>::infinity();
  start.filter_m2 = start.noise_m2 = errors.start_sigma_m * errors.start_sigma_m * Eigen::Matrix2d::Identity();
  start.drift = start.bias = start.match = Eigen::Matrix2d::Zero();
  hypotheses_.push_back(start);
}

void Belief::fly(double distance_m, double agl_m, const ErrorModel& errors) {
  const double assumed = errors.filter_noise_m2_per_m(agl_m) * distance_m;
  for (Hypothesis& h : hypotheses_) {
    h.since_fix_m += distance_m;
    h.filter_m2.diagonal().array() += assumed;
    h.drift.diagonal().array() += errors.drift_share * distance_m;
    h.noise_m2.diagonal().array() += errors.noise_m2_per_m * distance_m;
  }
}

void Belief::look(const ViewFunction& view, double correlation, double independent_m) {
  std::vector<Hypothesis> fixed, others;
  for (Hypothesis& h : hypotheses_) {
    h.match *= correlation;
    const double sigma_m = std::sqrt(std::max(h.filter_m2(0, 0), h.filter_m2(1, 1)));
    const View& v = view(sigma_m);
    const double p = fix_probability_given(h.fixed, h.last_probability, v.fix_probability, correlation);
    const double none = 1 - v.fix_probability;
    const double deceived = none > 0 ? (1 - p) * std::min(1.0, v.false_probability / none) : 0;
    const auto keep = [&](std::vector<Hypothesis>& list, Hypothesis outcome, double chance, bool is_true) {
      outcome.weight = h.weight * chance;
      outcome.fixed = is_true;
      outcome.last_probability = v.fix_probability;
      if (outcome.weight > kNegligible) list.push_back(outcome);
    };
    if (p > 0 || deceived > 0) {
      const FixUpdate u = fix_update(v, h.filter_m2, h.since_fix_m, independent_m);
      keep(fixed, with_fix(h, u, v.attitude_m * v.attitude_m, v.bias_m, root(v.match_m2)), p, true);
      const double false_m = false_sigma_m(v.search_m);
      keep(others, with_fix(h, u, false_m * false_m, 0, Eigen::Matrix2d::Zero()), deceived, false);
    }
    keep(others, h, 1 - p - deceived, false);
  }
  // Those that have just got a fix differ less than the others do.
  const size_t of_fixed = others.empty() ? size_t(limit_) : size_t(std::max(1, limit_ / 4));
  if (fixed.size() > of_fixed) reduce(fixed, of_fixed);
  if (others.size() > size_t(limit_) - of_fixed) reduce(others, size_t(limit_) - of_fixed);
  hypotheses_ = std::move(fixed);
  hypotheses_.insert(hypotheses_.end(), others.begin(), others.end());
  double sum = 0;
  for (const Hypothesis& h : hypotheses_) sum += h.weight;
  for (Hypothesis& h : hypotheses_) h.weight /= sum;
}

Eigen::Matrix2d Belief::covariance_m2() const {
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (const Hypothesis& h : hypotheses_) sum += h.weight * h.error_m2();
  return sum;
}

double Belief::filter_rms_m() const {
  double sum = 0;
  for (const Hypothesis& h : hypotheses_) sum += h.weight * h.filter_m2.trace();
  return std::sqrt(sum);
}

double Belief::within(double radius_m) const {
  double sum = 0;
  for (const Hypothesis& h : hypotheses_) sum += h.weight * within_circle(h.error_m2(), radius_m);
  return sum;
}

double Belief::radius_m(double confidence) const {
  double low = 0, high = 1;
  while (within(high) < confidence && high < 1e7) low = high, high *= 2;
  while (high - low > 1e-3) (within(0.5 * (low + high)) < confidence ? low : high) = 0.5 * (low + high);
  return high;
}

double within_circle(const Eigen::Matrix2d& c, double radius_m) {
  // With e = R (a cos φ, b sin φ), R of a Rayleigh and φ of a uniform distribution, what is left is a mean over φ.
  const double half = 0.5 * c.trace(), spread = std::hypot(0.5 * (c(0, 0) - c(1, 1)), c(0, 1));
  constexpr int kAngles = 8;
  static const std::array<double, kAngles> kCosines = [] {
    std::array<double, kAngles> cosines;
    for (int i = 0; i < kAngles; ++i) cosines[size_t(i)] = std::cos(M_PI * (i + 0.5) / kAngles);
    return cosines;
  }();
  double beyond = 0;
  for (const double cosine : kCosines) {
    const double variance = half + spread * cosine;
    if (variance > 0) beyond += std::exp(-radius_m * radius_m / (2 * variance));
  }
  return 1 - beyond / kAngles;
}

}  // namespace landfix::route
