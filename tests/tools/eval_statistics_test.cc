// The figures of an evaluation, against cases worked out by hand.
#include <gtest/gtest.h>

#include <cmath>

#include "tools/eval/statistics.h"

namespace landfix::eval {
namespace {

Sample answered(bool hit, double probability, double gap = 0, double error_m = 1, uint64_t block = 0) {
  return {.answered = true, .hit = hit, .error_m = error_m, .probability = probability, .gap = gap, .block = block};
}

TEST(EvalStatistics, HitRateCountsUnansweredSamples) {
  const std::vector<Sample> samples = {answered(true, 0.9), answered(true, 0.8), answered(false, 0.7), {}};
  EXPECT_DOUBLE_EQ(hit_rate(samples), 0.5);
  const std::vector<int> twice_the_first = {2, 1, 1, 0};
  EXPECT_DOUBLE_EQ(hit_rate(samples, twice_the_first), 0.75);
  EXPECT_TRUE(std::isnan(hit_rate({})));
}

TEST(EvalStatistics, QuantilesAreOfHitsByNearestRank) {
  // Errors 1 to 20 m of hits and one of 1000 m that is none: half of the hits are within 10 m, 95 % within 19 m.
  std::vector<Sample> samples = {answered(false, 0.5, 0, 1000)};
  for (int i = 20; i >= 1; --i) samples.push_back(answered(true, 0.5, 0, i));
  const double shares[] = {0.5, 0.9, 0.95, 0.99};
  EXPECT_EQ(error_quantiles(samples, shares), (std::vector<double>{10, 18, 19, 20}));
  EXPECT_TRUE(std::isnan(error_quantiles(std::span(samples).first(1), shares)[0]));
}

TEST(EvalStatistics, EllipseHolds95PercentOfItsGaussian) {
  // Along an axis of sigma 2 m the ellipse ends at 2 sqrt(5.991) = 4.895 m.
  const std::array<double, 4> c = {4, 0, 0, 1};
  EXPECT_TRUE(in_95_ellipse(4.89, 0, c));
  EXPECT_FALSE(in_95_ellipse(4.90, 0, c));
  EXPECT_FALSE(in_95_ellipse(0, 2.45, c));
  // Turned by 45 degrees: variances 4 and 1 along the diagonals.
  const std::array<double, 4> turned = {2.5, 1.5, 1.5, 2.5};
  const double diagonal = std::sqrt(0.5);
  EXPECT_TRUE(in_95_ellipse(4.89 * diagonal, 4.89 * diagonal, turned));
  EXPECT_FALSE(in_95_ellipse(2.45 * diagonal, -2.45 * diagonal, turned));
  EXPECT_FALSE(in_95_ellipse(0, 0, {0, 0, 0, 0}));
  EXPECT_FALSE(in_95_ellipse(0, 0, {1, 2, 2, 1}));
}

TEST(EvalStatistics, ShareInEllipseIsOfHits) {
  std::vector<Sample> samples = {answered(true, 0.9), answered(true, 0.9), answered(false, 0.9)};
  samples[0].in_ellipse = samples[2].in_ellipse = true;
  EXPECT_DOUBLE_EQ(share_in_ellipse(samples), 0.5);
}

TEST(EvalStatistics, GateCountsWhatIsAtLeastItsThreshold) {
  const std::vector<Sample> samples = {
      answered(true, 0.95), answered(false, 0.9), answered(true, 0.9), answered(true, 0.89), {}};
  const GateOutcome out = at_threshold(samples, 0.9);
  EXPECT_EQ(out.accepted, 3);
  EXPECT_EQ(out.wrong, 1);
  EXPECT_DOUBLE_EQ(out.accept_rate, 0.6);
  EXPECT_DOUBLE_EQ(out.false_rate, 1.0 / 3);
  // The bound p solves P(at most 1 of 3) = (1 - p)^3 + 3 p (1 - p)^2 = 0.05.
  const double p = out.false_rate_bound, q = 1 - p;
  EXPECT_NEAR(q * q * q + 3 * p * q * q, 0.05, 1e-9);
}

TEST(EvalStatistics, NoFalseFixAmongManyBoundsTheRate) {
  // (1 - p)^3000 = 0.05: p = 1 - 0.05^(1/3000), the "rule of three".
  const std::vector<Sample> samples(3000, answered(true, 1));
  EXPECT_NEAR(at_threshold(samples, 0.99).false_rate_bound, 1 - std::pow(0.05, 1.0 / 3000), 1e-9);
  const std::vector<Sample> none(3, Sample{});
  EXPECT_EQ(at_threshold(none, 0).false_rate_bound, 1) << "an unanswered sample passes no gate";
  EXPECT_TRUE(std::isnan(at_threshold(none, 0).false_rate));
}

TEST(EvalStatistics, OracleTakesTheLargestShareThatKeepsTheFalseRate) {
  // By probability: 3 true, 1 false, 4 true. At most 20 % false: 7 of 8 accepted have 1 false (14 %), 4 have 25 %.
  std::vector<Sample> samples = {answered(true, 0.99),  answered(true, 0.98), answered(true, 0.97),
                                 answered(false, 0.96), answered(true, 0.95), answered(true, 0.94),
                                 answered(true, 0.93),  answered(true, 0.92)};
  samples.resize(10);
  const Ranked ranked(samples, Ranking::kProbability);
  EXPECT_DOUBLE_EQ(ranked.oracle(0.2).accept_rate, 0.8) << "of all ten samples, two of them unanswered";
  EXPECT_DOUBLE_EQ(ranked.oracle(0.2).threshold, 0.92);
  EXPECT_DOUBLE_EQ(ranked.oracle(0.01).accept_rate, 0.3);
  EXPECT_DOUBLE_EQ(ranked.oracle(0.01).threshold, 0.97);
  // Counting the true ones behind the false one 30 times each lets 1 % pass: 3 + 1 + 4 · 30 with 1 false.
  const std::vector<int> weights = {1, 1, 1, 1, 30, 30, 30, 30, 0, 0};
  EXPECT_DOUBLE_EQ(ranked.oracle(0.01, weights).accept_rate, 1);
}

TEST(EvalStatistics, OracleCannotSplitSamplesOfEqualRank) {
  const std::vector<Sample> samples = {answered(true, 0.9), answered(true, 0.5), answered(false, 0.5)};
  EXPECT_DOUBLE_EQ(Ranked(samples, Ranking::kProbability).oracle(0.01).accept_rate, 1.0 / 3);
  const std::vector<Sample> hopeless = {answered(false, 0.9), answered(true, 0.5)};
  EXPECT_DOUBLE_EQ(Ranked(hopeless, Ranking::kProbability).oracle(0.01).accept_rate, 0);
  EXPECT_TRUE(std::isinf(Ranked(hopeless, Ranking::kProbability).oracle(0.01).threshold));
}

TEST(EvalStatistics, AucCountsTiesHalf) {
  // Gaps of hits 3, 2, 2; of false matches 2, 1: wins 2 + 1.5 + 1.5 of 6 comparisons. The unanswered one is in none.
  const std::vector<Sample> samples = {answered(true, 0, 3),  answered(true, 0, 2),  answered(true, 0, 2),
                                       answered(false, 0, 2), answered(false, 0, 1), {}};
  EXPECT_DOUBLE_EQ(Ranked(samples, Ranking::kGap).auc(), 5.0 / 6);
  EXPECT_DOUBLE_EQ(Ranked(samples, Ranking::kProbability).auc(), 0.5) << "all probabilities are equal";
  EXPECT_TRUE(std::isnan(Ranked(std::span(samples).first(3), Ranking::kGap).auc()));
}

TEST(EvalStatistics, ReliabilityComparesPredictedWithObserved) {
  // Four samples of 0.95 with 3 hits, and one of 0.15 with none: errors 0.20 and 0.15, weighted 4 : 1.
  const std::vector<Sample> samples = {answered(true, 0.95),  answered(true, 0.95),  answered(true, 0.95),
                                       answered(false, 0.95), answered(false, 0.15), {}};
  const Reliability r = reliability(samples);
  EXPECT_EQ(r.bins[9].count, 4);
  EXPECT_NEAR(r.bins[9].predicted, 0.95, 1e-12);
  EXPECT_DOUBLE_EQ(r.bins[9].observed, 0.75);
  EXPECT_EQ(r.bins[1].count, 1);
  EXPECT_DOUBLE_EQ(r.bins[1].observed, 0);
  EXPECT_TRUE(std::isnan(r.bins[0].observed)) << "the unanswered sample is in no bin";
  EXPECT_NEAR(r.calibration_error, (4 * 0.20 + 1 * 0.15) / 5, 1e-12);
}

TEST(EvalStatistics, CertaintyBelongsToTheLastBin) {
  const std::vector<Sample> samples = {answered(true, 1.0)};
  EXPECT_EQ(reliability(samples).bins[9].count, 1);
}

TEST(EvalStatistics, BootstrapDrawsWholeBlocks) {
  // 100 blocks of 10 samples that are all alike inside a block, half of them hits: the hit rate is that of 100 draws,
  // 0.5 ± 1.96 · 0.05; if samples were drawn one by one it would be ± 0.031.
  std::vector<Sample> samples;
  for (int i = 0; i < 1000; ++i) samples.push_back(answered(i / 10 % 2 == 0, 0.5, 0, 1, uint64_t(i / 10)));
  const Intervals blocks = bootstrap(samples, 0.4, 2000, 7);
  EXPECT_NEAR(blocks.hit_rate.low, 0.5 - 0.098, 0.015);
  EXPECT_NEAR(blocks.hit_rate.high, 0.5 + 0.098, 0.015);
  EXPECT_NEAR(blocks.false_rate.low, 0.5 - 0.098, 0.015) << "all are accepted, so the same with signs changed";
  for (size_t i = 0; i < samples.size(); ++i) samples[i].block = i;
  const Intervals alone = bootstrap(samples, 0.4, 2000, 7);
  EXPECT_NEAR(alone.hit_rate.high - alone.hit_rate.low, 2 * 0.031, 0.006);
}

TEST(EvalStatistics, BootstrapIsTheSameForTheSameSeed) {
  std::vector<Sample> samples;
  for (int i = 0; i < 200; ++i) samples.push_back(answered(i % 3 != 0, i / 200.0, 0, 1, uint64_t(i / 5)));
  const Intervals a = bootstrap(samples, 0.5, 200, 3), b = bootstrap(samples, 0.5, 200, 3),
                  other = bootstrap(samples, 0.5, 200, 4);
  EXPECT_EQ(a.accept_rate_1pct.high, b.accept_rate_1pct.high);
  EXPECT_EQ(a.calibration_error.low, b.calibration_error.low);
  EXPECT_NE(a.calibration_error.low, other.calibration_error.low);
}

TEST(EvalStatistics, BootstrapOfOneBlockKnowsNothing) {
  const std::vector<Sample> samples = {answered(true, 0.9), answered(false, 0.9)};
  EXPECT_TRUE(std::isnan(bootstrap(samples, 0.5, 50, 1).hit_rate.low)) << "not an interval of width 0";
}

TEST(EvalStatistics, WeightsCountSamplesSeveralTimes) {
  const std::vector<Sample> once = {answered(true, 0.8), answered(false, 0.9), answered(false, 0.3)};
  const std::vector<Sample> repeated = {once[0], once[1], once[2], once[2], once[2]};
  const std::vector<int> weights = {1, 1, 3};
  // The hit is above three of four misses.
  EXPECT_DOUBLE_EQ(Ranked(once, Ranking::kProbability).auc(weights), 0.75);
  EXPECT_DOUBLE_EQ(Ranked(repeated, Ranking::kProbability).auc(), 0.75);
}

TEST(EvalStatistics, RankCorrelationIsSpearmans) {
  // Ranks 1 2 3 4 5 and 2 1 4 3 5: 1 - 6 · 4 / (5 · 24).
  const std::vector<double> a = {1, 2, 3, 4, 5}, b = {20, 10, 40, 30, 5000};
  EXPECT_NEAR(RankCorrelation(a, b).value(), 0.8, 1e-12);
  // Equal values share their rank: 1 2.5 2.5 4 and 1 2 3 4 give 4.5 / sqrt(4.5 · 5).
  const std::vector<double> c = {1, 2, 2, 3}, d = {1, 2, 3, 4};
  EXPECT_NEAR(RankCorrelation(c, d).value(), 4.5 / std::sqrt(22.5), 1e-12);
  EXPECT_TRUE(std::isnan(RankCorrelation(c, std::vector<double>(4, 7)).value())) << "nothing to rank";
  // A weight of two is a sample that is there twice, of none one that is not.
  const std::vector<double> e = {1, 2, 2, 3, 3}, f = {1, 2, 2, 1, 1};
  EXPECT_NEAR(RankCorrelation(std::vector<double>{1, 2, 3, 9}, std::vector<double>{1, 2, 1, 0})
                  .value(std::vector<int>{1, 2, 2, 0}),
              RankCorrelation(e, f).value(), 1e-12);
}

}  // namespace
}  // namespace landfix::eval
