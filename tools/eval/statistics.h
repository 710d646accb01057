// What a set of registrations with known truth says about a matcher and about the gate behind it. Pure functions.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace landfix::eval {

/// One registration against the truth.
struct Sample {
  bool answered = false;    ///< a match was found, whatever a gate says of it; else the rest below is 0
  bool hit = false;         ///< near enough to the truth to count as true
  double error_m = 0;       ///< distance of the match from the truth
  double probability = 0;   ///< stated for the match to be true
  double gap = 0;           ///< to the highest rival
  bool in_ellipse = false;  ///< the truth lies in the 95 % ellipse that was stated for a true match
  uint64_t block = 0;       ///< samples of one block share ground, and are not independent
};

/// How often each sample counts: one number per sample, or empty for once each.
using Weights = std::span<const int>;

/// Of every sample.
std::vector<uint64_t> blocks_of(std::span<const Sample> samples);

/// Of all samples, unanswered ones included. NaN without samples.
double hit_rate(std::span<const Sample> samples, Weights weights = {});

/// Smallest errors that the given shares of the hits do not exceed (nearest rank); NaN without hits.
std::vector<double> error_quantiles(std::span<const Sample> samples, std::span<const double> shares);

/// Share of hits with the truth in the stated 95 % ellipse; NaN without hits.
double share_in_ellipse(std::span<const Sample> samples, Weights weights = {});

/// Whether an error (east, north) lies in the ellipse that holds 95 % of a Gaussian: its squared Mahalanobis distance
/// is at most 5.991, the 95 % quantile of chi-square with two degrees of freedom. False for a covariance that is not
/// positive definite.
bool in_95_ellipse(double error_east_m, double error_north_m, const std::array<double, 4>& covariance_m2);

/// What a gate lets through.
struct GateOutcome {
  int64_t accepted = 0, wrong = 0;
  double accept_rate = 0;  ///< of all samples; NaN without samples
  double false_rate = 0;   ///< of the accepted; NaN without any
  double false_rate_bound =
      1;  ///< one-sided 95 % upper bound of it, exact for independent samples (Clopper and Pearson 1934)
};

/// A gate on the probability: answered samples of at least `threshold` pass.
GateOutcome at_threshold(std::span<const Sample> samples, double threshold, Weights weights = {});

enum class Ranking { kProbability, kGap };

/// Samples in the order in which a gate would let them through. `samples` must outlive it.
class Ranked {
 public:
  Ranked(std::span<const Sample> samples, Ranking ranking);

  struct Oracle {
    double accept_rate = 0;  ///< of all samples
    double threshold = 0;    ///< that does it; infinite where nothing can be accepted
  };
  /// The best threshold in hindsight: the largest share of all samples that one can accept with at most `max_false` of
  /// the accepted false. Samples of equal rank are accepted together.
  Oracle oracle(double max_false, Weights weights = {}) const;

  /// Probability that a hit ranks above a false match, ties counting half (Mann and Whitney 1947); of answered samples;
  /// NaN unless there are both.
  double auc(Weights weights = {}) const;

 private:
  double key(size_t index) const;
  std::span<const Sample> samples_;
  Ranking ranking_;
  std::vector<size_t> order_;  ///< of answered samples
};

inline constexpr size_t kReliabilityBins = 10;

struct ReliabilityBin {
  int64_t count = 0;
  double predicted = 0;  ///< mean probability stated; NaN in an empty bin
  double observed = 0;   ///< share of hits; NaN in an empty bin
};

/// Answered samples by the probability stated for them, in bins of equal width.
struct Reliability {
  std::array<ReliabilityBin, kReliabilityBins> bins;
  double calibration_error = 0;  ///< expected: mean of |predicted - observed| over the samples; NaN without any
};
Reliability reliability(std::span<const Sample> samples, Weights weights = {});

/// Correlation of the ranks of two quantities (Spearman 1904), equal values sharing the mean of their ranks.
class RankCorrelation {
 public:
  /// `a` and `b`: of one length, no NaN.
  RankCorrelation(std::span<const double> a, std::span<const double> b);

  /// -1 to 1; NaN where one of them has fewer than two different values.
  double value(Weights weights = {}) const;

 private:
  struct Ranking {
    std::vector<size_t> order;  ///< ascending
    std::vector<bool> ties;     ///< of order[k]: equal to order[k - 1]
  };
  static Ranking ranking_of(std::span<const double> values);
  static std::vector<double> ranks(const Ranking& ranking, Weights weights);
  Ranking a_, b_;
};

/// A 95 % confidence interval.
struct Interval {
  double low = 0, high = 0;
};

/// Something that is computed from weighted samples.
using Figure = std::function<double(Weights)>;

/// Percentile intervals of figures by a block bootstrap (Künsch 1989): whole blocks are drawn with replacement, since
/// neighbouring samples show the same ground. `blocks`: of every sample. The same for the same seed. NaN for a single
/// block, and where no resample has a value.
std::vector<Interval> bootstrap(std::span<const uint64_t> blocks, std::span<const Figure> figures, int resamples = 1000,
                                uint64_t seed = 1);

struct Intervals {
  Interval hit_rate, accept_rate_1pct, false_rate, calibration_error;
};

/// The same of the figures of registration. `threshold`: of the gate for the false rate. `accept_rate_1pct`: oracle by
/// probability. Intervals of the calibration error lie somewhat high, as the error itself does: chance deviations count
/// in it whatever their sign.
Intervals bootstrap(std::span<const Sample> samples, double threshold, int resamples = 1000, uint64_t seed = 1);

}  // namespace landfix::eval
