#include "tools/eval/statistics.h"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <cmath>
#include <limits>
#include <numeric>

#include "tools/synth/random.h"

namespace landfix::eval {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kChiSquare95 = 5.991464547107979;  ///< two degrees of freedom: -2 ln 0.05
constexpr double kBoundTail = 0.05;

int weight(Weights weights, size_t i) { return weights.empty() ? 1 : weights[i]; }

int64_t total(std::span<const Sample> samples, Weights weights) {
  return weights.empty() ? int64_t(samples.size()) : std::accumulate(weights.begin(), weights.end(), int64_t(0));
}

double share(double part, double whole) { return whole > 0 ? part / whole : kNan; }

/// The value that a share of the sorted values does not exceed.
double nearest_rank(const std::vector<double>& sorted, double share) {
  if (sorted.empty()) return kNan;
  const double rank = std::ceil(share * double(sorted.size()) - 1e-9);
  return sorted[size_t(std::clamp(rank, 1.0, double(sorted.size()))) - 1];
}

Interval interval_of(std::vector<double> values) {
  std::erase_if(values, [](double v) { return std::isnan(v); });
  std::sort(values.begin(), values.end());
  return {nearest_rank(values, 0.025), nearest_rank(values, 0.975)};
}

/// Number of each sample's block, 0 to n - 1, and n.
std::pair<std::vector<size_t>, size_t> numbered(std::span<const uint64_t> blocks) {
  std::vector<uint64_t> names(blocks.begin(), blocks.end());
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  std::vector<size_t> index;
  for (const uint64_t block : blocks)
    index.push_back(size_t(std::lower_bound(names.begin(), names.end(), block) - names.begin()));
  return {index, names.size()};
}

}  // namespace

std::vector<uint64_t> blocks_of(std::span<const Sample> samples) {
  std::vector<uint64_t> out;
  for (const Sample& s : samples) out.push_back(s.block);
  return out;
}

double hit_rate(std::span<const Sample> samples, Weights weights) {
  int64_t hits = 0;
  for (size_t i = 0; i < samples.size(); ++i) hits += samples[i].hit ? weight(weights, i) : 0;
  return share(double(hits), double(total(samples, weights)));
}

std::vector<double> error_quantiles(std::span<const Sample> samples, std::span<const double> shares) {
  std::vector<double> errors, out;
  for (const Sample& s : samples)
    if (s.hit) errors.push_back(s.error_m);
  std::sort(errors.begin(), errors.end());
  for (const double share : shares) out.push_back(nearest_rank(errors, share));
  return out;
}

double share_in_ellipse(std::span<const Sample> samples, Weights weights) {
  int64_t hits = 0, inside = 0;
  for (size_t i = 0; i < samples.size(); ++i) {
    hits += samples[i].hit ? weight(weights, i) : 0;
    inside += samples[i].hit && samples[i].in_ellipse ? weight(weights, i) : 0;
  }
  return share(double(inside), double(hits));
}

bool in_95_ellipse(double e, double n, const std::array<double, 4>& c) {
  const double determinant = c[0] * c[3] - c[1] * c[2];
  if (!(determinant > 0 && c[0] > 0)) return false;
  return c[3] * e * e - (c[1] + c[2]) * e * n + c[0] * n * n <= kChiSquare95 * determinant;
}

GateOutcome at_threshold(std::span<const Sample> samples, double threshold, Weights weights) {
  GateOutcome out;
  for (size_t i = 0; i < samples.size(); ++i) {
    if (!samples[i].answered || samples[i].probability < threshold) continue;
    out.accepted += weight(weights, i);
    out.wrong += samples[i].hit ? 0 : weight(weights, i);
  }
  out.accept_rate = share(double(out.accepted), double(total(samples, weights)));
  out.false_rate = share(double(out.wrong), double(out.accepted));
  if (out.wrong < out.accepted)
    out.false_rate_bound = boost::math::binomial_distribution<>::find_upper_bound_on_p(double(out.accepted),
                                                                                       double(out.wrong), kBoundTail);
  return out;
}

Ranked::Ranked(std::span<const Sample> samples, Ranking ranking) : samples_(samples), ranking_(ranking) {
  for (size_t i = 0; i < samples.size(); ++i)
    if (samples[i].answered) order_.push_back(i);
  std::stable_sort(order_.begin(), order_.end(), [this](size_t a, size_t b) { return key(a) > key(b); });
}

double Ranked::key(size_t i) const {
  return ranking_ == Ranking::kProbability ? samples_[i].probability : samples_[i].gap;
}

Ranked::Oracle Ranked::oracle(double max_false, Weights weights) const {
  int64_t accepted = 0, wrong = 0, best = 0;
  double threshold = std::numeric_limits<double>::infinity();
  for (size_t k = 0; k < order_.size(); ++k) {
    const size_t i = order_[k];
    accepted += weight(weights, i);
    wrong += samples_[i].hit ? 0 : weight(weights, i);
    const bool last_of_equals = k + 1 == order_.size() || key(order_[k + 1]) < key(i);
    if (!last_of_equals || accepted <= best || double(wrong) > max_false * double(accepted)) continue;
    best = accepted;
    threshold = key(i);
  }
  return {share(double(best), double(total(samples_, weights))), threshold};
}

double Ranked::auc(Weights weights) const {
  double hits = 0, wrong = 0, wins = 0;
  for (size_t k = 0; k < order_.size();) {
    double equal_hits = 0, equal_wrong = 0;
    const double value = key(order_[k]);
    for (; k < order_.size() && key(order_[k]) == value; ++k)
      (samples_[order_[k]].hit ? equal_hits : equal_wrong) += weight(weights, order_[k]);
    wins += equal_wrong * (hits + 0.5 * equal_hits);
    hits += equal_hits;
    wrong += equal_wrong;
  }
  return share(wins, hits * wrong);
}

Reliability reliability(std::span<const Sample> samples, Weights weights) {
  struct Sums {
    double predicted = 0, hits = 0;
  };
  Reliability out;
  std::array<Sums, kReliabilityBins> sums;
  int64_t answered = 0;
  for (size_t i = 0; i < samples.size(); ++i) {
    const Sample& s = samples[i];
    if (!s.answered) continue;
    const size_t bin = std::min(size_t(std::max(s.probability, 0.0) * kReliabilityBins), kReliabilityBins - 1);
    const int w = weight(weights, i);
    out.bins[bin].count += w;
    sums[bin].predicted += w * s.probability;
    sums[bin].hits += s.hit ? w : 0;
    answered += w;
  }
  double error = 0;
  for (size_t b = 0; b < kReliabilityBins; ++b) {
    out.bins[b].predicted = share(sums[b].predicted, double(out.bins[b].count));
    out.bins[b].observed = share(sums[b].hits, double(out.bins[b].count));
    error += std::abs(sums[b].predicted - sums[b].hits);
  }
  out.calibration_error = share(error, double(answered));
  return out;
}

RankCorrelation::RankCorrelation(std::span<const double> a, std::span<const double> b)
    : a_(ranking_of(a)), b_(ranking_of(b)) {}

RankCorrelation::Ranking RankCorrelation::ranking_of(std::span<const double> values) {
  Ranking out;
  out.order.resize(values.size());
  std::iota(out.order.begin(), out.order.end(), size_t(0));
  std::stable_sort(out.order.begin(), out.order.end(), [&](size_t i, size_t k) { return values[i] < values[k]; });
  for (size_t k = 0; k < out.order.size(); ++k)
    out.ties.push_back(k > 0 && values[out.order[k]] == values[out.order[k - 1]]);
  return out;
}

std::vector<double> RankCorrelation::ranks(const Ranking& ranking, Weights weights) {
  std::vector<double> out(ranking.order.size());
  double below = 0;
  for (size_t k = 0; k < ranking.order.size();) {
    const size_t first = k;
    double equal = 0;
    do equal += weight(weights, ranking.order[k]);
    while (++k < ranking.order.size() && ranking.ties[k]);
    for (size_t i = first; i < k; ++i) out[ranking.order[i]] = below + 0.5 * equal;
    below += equal;
  }
  return out;
}

double RankCorrelation::value(Weights weights) const {
  const std::vector<double> a = ranks(a_, weights), b = ranks(b_, weights);
  double count = 0;
  for (size_t i = 0; i < a.size(); ++i) count += weight(weights, i);
  const double mean = 0.5 * count;  // of the ranks of either
  double aa = 0, ab = 0, bb = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const double w = weight(weights, i);
    aa += w * (a[i] - mean) * (a[i] - mean);
    ab += w * (a[i] - mean) * (b[i] - mean);
    bb += w * (b[i] - mean) * (b[i] - mean);
  }
  return share(ab, std::sqrt(aa * bb));
}

std::vector<Interval> bootstrap(std::span<const uint64_t> blocks, std::span<const Figure> figures, int resamples,
                                uint64_t seed) {
  const auto [block, count] = numbered(blocks);
  if (count < 2) return std::vector<Interval>(figures.size(), {kNan, kNan});
  std::vector<std::vector<double>> values(figures.size());
  std::vector<int> drawn(count), weights(blocks.size());
  for (int r = 0; r < resamples; ++r) {
    synth::Random random(synth::key(seed, uint64_t(r)));
    std::fill(drawn.begin(), drawn.end(), 0);
    for (size_t i = 0; i < count; ++i) ++drawn[size_t(synth::unit(random.word()) * double(count))];
    for (size_t i = 0; i < blocks.size(); ++i) weights[i] = drawn[block[i]];
    for (size_t f = 0; f < figures.size(); ++f) values[f].push_back(figures[f](weights));
  }
  std::vector<Interval> out;
  for (std::vector<double>& of_figure : values) out.push_back(interval_of(std::move(of_figure)));
  return out;
}

Intervals bootstrap(std::span<const Sample> samples, double threshold, int resamples, uint64_t seed) {
  const Ranked ranked(samples, Ranking::kProbability);
  const std::array<Figure, 4> figures = {[&](Weights w) { return hit_rate(samples, w); },
                                         [&](Weights w) { return ranked.oracle(0.01, w).accept_rate; },
                                         [&](Weights w) { return at_threshold(samples, threshold, w).false_rate; },
                                         [&](Weights w) { return reliability(samples, w).calibration_error; }};
  const std::vector<Interval> all = bootstrap(blocks_of(samples), figures, resamples, seed);
  return {all[0], all[1], all[2], all[3]};
}

}  // namespace landfix::eval
