#include "tools/eval/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "runtime/nav/calibration.h"

namespace landfix::eval {
namespace {

using nlohmann::ordered_json;

/// Of numbers in any order, nearest rank; NaN for none.
double quantile(std::vector<double> values, double share) {
  if (values.empty()) return NAN;
  const auto rank = std::max<ptrdiff_t>(ptrdiff_t(std::ceil(share * double(values.size()))) - 1, 0);
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[size_t(rank)];
}

Summary::Oracle oracle(std::span<const Sample> samples, Ranking ranking) {
  const Ranked ranked(samples, ranking);
  return {ranked.oracle(0.01), ranked.oracle(0.001), ranked.auc()};
}

void add_seeds(std::span<const Trial> trials, std::span<const Sample> samples, Summary& s) {
  std::map<int, std::vector<Sample>> by_seed;
  for (size_t i = 0; i < trials.size(); ++i) by_seed[trials[i].question.seed_index].push_back(samples[i]);
  const auto over = [&](auto&& figure) {
    OverSeeds o{0, INFINITY, -INFINITY};
    for (const auto& [seed, of_seed] : by_seed) {
      const double value = figure(of_seed);
      o.mean += value / double(by_seed.size());
      o.low = std::min(o.low, value);
      o.high = std::max(o.high, value);
    }
    return o;
  };
  s.seeds_hit_rate = over([](const auto& of_seed) { return hit_rate(of_seed); });
  s.seeds_accept_rate_1pct =
      over([](const auto& of_seed) { return Ranked(of_seed, Ranking::kProbability).oracle(0.01).accept_rate; });
  s.seeds_accept_rate_1pct_by_gap =
      over([](const auto& of_seed) { return Ranked(of_seed, Ranking::kGap).oracle(0.01).accept_rate; });
}

void add_pose(std::span<const Trial> trials, Summary& s) {
  double rotation2 = 0, scale2 = 0;
  int64_t hits = 0;
  for (const Trial& t : trials) {
    if (!t.hit()) continue;
    ++hits;
    rotation2 += std::pow(t.similarity.rotation_rad - t.question.similarity.rotation_rad, 2);
    scale2 += std::pow(t.similarity.scale / t.question.similarity.scale - 1, 2);
  }
  s.rotation_rms_rad = std::sqrt(rotation2 / double(hits));
  s.scale_rms = std::sqrt(scale2 / double(hits));
}

ordered_json json_of(const Interval& i) { return {i.low, i.high}; }

ordered_json json_of(const OverSeeds& o) { return {{"mean", o.mean}, {"lowest", o.low}, {"highest", o.high}}; }

ordered_json json_of(const Summary::Oracle& o) {
  const auto one = [](const Ranked::Oracle& r) {
    return ordered_json{{"accept_rate", r.accept_rate},
                        {"threshold", std::isfinite(r.threshold) ? ordered_json(r.threshold) : ordered_json()}};
  };
  return {{"at_1pct_false", one(o.at_1pct)}, {"at_0.1pct_false", one(o.at_01pct)}, {"auc", o.auc}};
}

ordered_json json_of(const GateOutcome& g, double threshold) {
  return {{"threshold", threshold},     {"accepted", g.accepted},
          {"false", g.wrong},           {"accept_rate", g.accept_rate},
          {"false_rate", g.false_rate}, {"false_rate_upper_bound_95", g.false_rate_bound}};
}

ordered_json json_of(const Reliability& r) {
  ordered_json bins = ordered_json::array();
  for (size_t b = 0; b < kReliabilityBins; ++b) {
    const double low = double(b) / kReliabilityBins, high = double(b + 1) / kReliabilityBins;
    bins.push_back({{"from", low},
                    {"to", high},
                    {"count", r.bins[b].count},
                    {"predicted", r.bins[b].predicted},
                    {"observed", r.bins[b].observed}});
  }
  return bins;
}

std::string percent(double share) { return std::isnan(share) ? "-" : fmt::format("{:.1f}", 100 * share); }

/// Of a false-fix rate: fine enough to tell 0.1 % from less.
std::string fine_percent(double share) { return std::isnan(share) ? "-" : fmt::format("{:.2f}", 100 * share); }

std::string number(double value, int digits) { return std::isnan(value) ? "-" : fmt::format("{:.{}f}", value, digits); }

}  // namespace

Summary summarize(std::span<const Trial> trials) {
  Summary s;
  std::vector<Sample> samples;
  std::set<uint64_t> blocks;
  std::vector<double> ms;
  for (const Trial& t : trials) {
    samples.push_back(sample_of(t));
    blocks.insert(t.question.block);
    ms.push_back(t.milliseconds);
    t.answered() ? ++s.answered : ++s.refused[std::string(word_of(t.status))];
  }
  const double standard = nav::threshold_of(nav::Gate::kStandard), strict = nav::threshold_of(nav::Gate::kStrict);
  s.samples = int64_t(samples.size());
  s.blocks = blocks.size();
  s.hit_rate = hit_rate(samples);
  s.error_quantiles_m = error_quantiles(samples, kErrorShares);
  s.in_ellipse = share_in_ellipse(samples);
  s.by_probability = oracle(samples, Ranking::kProbability);
  s.by_gap = oracle(samples, Ranking::kGap);
  s.standard = at_threshold(samples, standard);
  s.strict = at_threshold(samples, strict);
  s.reliability = reliability(samples);
  s.intervals = bootstrap(samples, standard);
  add_seeds(trials, samples, s);
  add_pose(trials, s);
  s.median_ms = quantile(ms, 0.5);
  s.percentile95_ms = quantile(ms, 0.95);
  return s;
}

ordered_json to_json(const Summary& s) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  ordered_json j = {{"samples", s.samples}, {"answered", s.answered}, {"refused", s.refused}, {"blocks", s.blocks}};
  j["hit_rate"] = s.hit_rate;
  for (size_t i = 0; i < std::size(kErrorShares); ++i)
    j["error_of_hits_m"][fmt::format("{:.0f}%", 100 * kErrorShares[i])] = s.error_quantiles_m[i];
  j["hits_in_95pct_ellipse"] = s.in_ellipse;
  j["oracle"] = {{"by_probability", json_of(s.by_probability)}, {"by_gap", json_of(s.by_gap)}};
  j["gate"] = {{"standard", json_of(s.standard, nav::threshold_of(nav::Gate::kStandard))},
               {"strict", json_of(s.strict, nav::threshold_of(nav::Gate::kStrict))}};
  j["expected_calibration_error"] = s.reliability.calibration_error;
  j["reliability"] = json_of(s.reliability);
  j["interval_95"] = {{"hit_rate", json_of(s.intervals.hit_rate)},
                      {"accept_rate_at_1pct_false", json_of(s.intervals.accept_rate_1pct)},
                      {"standard_false_rate", json_of(s.intervals.false_rate)},
                      {"expected_calibration_error", json_of(s.intervals.calibration_error)}};
  j["over_seeds"] = {{"hit_rate", json_of(s.seeds_hit_rate)},
                     {"accept_rate_at_1pct_false_by_probability", json_of(s.seeds_accept_rate_1pct)},
                     {"accept_rate_at_1pct_false_by_gap", json_of(s.seeds_accept_rate_1pct_by_gap)}};
  j["pose_error_of_hits_rms"] = {{"rotation_deg", s.rotation_rms_rad * kDegrees}, {"scale", s.scale_rms}};
  j["milliseconds"] = {{"median", s.median_ms}, {"95%", s.percentile95_ms}};
  return j;
}

std::string table(std::span<const TableRow> rows) {
  size_t camera = 6;
  for (const TableRow& r : rows) camera = std::max(camera, r.camera.size());
  constexpr const char* kFormat =
      "{:<11}  {:<{}}  {:>6}  {:>13}  {:>7}  {:>7}  {:>5}  {:>5}  {:>6}  {:>6}  {:>6}  {:>6}  {:>6}  {:>6}  {:>5}  "
      "{:>5}  {:>7}\n";
  std::string text = fmt::format(fmt::runtime(kFormat), "matcher", "camera", camera, "hits", "(95 %)", "med.", "95 %",
                                 "acc1", "acc.1", "AUC", "AUC", "std.", "std.", "strict", "strict", "ECE", "in", "ms");
  text += fmt::format(fmt::runtime(kFormat), "", "", camera, "%", "", "m", "m", "%", "%", "prob.", "gap", "acc.%",
                      "false%", "acc.%", "false%", "", "95%", "median");
  for (const TableRow& row : rows) {
    const Summary& s = *row.summary;
    text += fmt::format(fmt::runtime(kFormat), row.matcher, row.camera, camera, percent(s.hit_rate),
                        fmt::format("({}-{})", percent(s.intervals.hit_rate.low), percent(s.intervals.hit_rate.high)),
                        number(s.error_quantiles_m[0], 2), number(s.error_quantiles_m[2], 2),
                        percent(s.by_probability.at_1pct.accept_rate), percent(s.by_probability.at_01pct.accept_rate),
                        number(s.by_probability.auc, 3), number(s.by_gap.auc, 3), percent(s.standard.accept_rate),
                        fine_percent(s.standard.false_rate), percent(s.strict.accept_rate),
                        fine_percent(s.strict.false_rate), number(s.reliability.calibration_error, 3),
                        percent(s.in_ellipse), number(s.median_ms, 1));
  }
  return text;
}

}  // namespace landfix::eval
