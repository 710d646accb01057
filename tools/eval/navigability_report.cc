#include "tools/eval/navigability_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace landfix::eval {
namespace {

using nlohmann::ordered_json;

Estimate take(double value, const Interval& interval) { return {value, interval}; }

std::array<Estimate, kTextures> texture_estimates(std::span<const Foreseen> all) {
  std::array<std::vector<Sample>, kTextures> samples;
  for (const Foreseen& f : all) {
    if (!f.textures) continue;
    for (size_t t = 0; t < kTextures; ++t) {
      samples[t].push_back(f.sample());
      samples[t].back().probability = (*f.textures)[t];
    }
  }
  std::vector<Ranked> ranked;
  std::vector<Figure> figures;
  for (const std::vector<Sample>& of_texture : samples) ranked.emplace_back(of_texture, Ranking::kProbability);
  for (const Ranked& r : ranked) figures.push_back([&r](Weights w) { return r.auc(w); });
  const std::vector<Interval> intervals = bootstrap(blocks_of(samples[0]), figures);
  std::array<Estimate, kTextures> out;
  for (size_t t = 0; t < kTextures; ++t) out[t] = take(ranked[t].auc(), intervals[t]);
  return out;
}

double mean_age(std::span<const Foreseen> samples) {
  double sum = 0;
  for (const Foreseen& f : samples) sum += f.age_years.value_or(NAN);
  return sum / double(samples.size());
}

/// Of true fixes alone.
void add_errors(std::span<const Foreseen> all, NavigabilityFigures& out) {
  std::vector<Sample> hits;
  std::vector<double> sigmas, errors;
  double expected = 0, actual = 0;
  for (const Foreseen& f : all) {
    const Sample s = f.sample();
    if (!s.hit) continue;
    hits.push_back(s);
    sigmas.push_back(f.sigma_m());
    errors.push_back(s.error_m);
    expected += 2 * sigmas.back() * sigmas.back();
    actual += s.error_m * s.error_m;
  }
  const RankCorrelation correlation(sigmas, errors);
  const Figure figures[] = {[&](Weights w) { return share_in_ellipse(hits, w); },
                            [&](Weights w) { return correlation.value(w); }};
  const std::vector<Interval> intervals = bootstrap(blocks_of(hits), figures);
  out.hits = int64_t(hits.size());
  out.in_ellipse = take(share_in_ellipse(hits), intervals[0]);
  out.rank_correlation = take(correlation.value(), intervals[1]);
  out.expected_rms_m = std::sqrt(expected / double(hits.size()));
  out.actual_rms_m = std::sqrt(actual / double(hits.size()));
}

ordered_json json_of(const Estimate& e) {
  return {{"value", e.value}, {"interval_95", {e.interval.low, e.interval.high}}};
}

ordered_json json_of(const NavigabilityFigures& f) {
  ordered_json j = {{"samples", f.samples},
                    {"true_fixes", f.hits},
                    {"blocks", f.blocks},
                    {"mean_age_years", f.mean_age_years},
                    {"auc", json_of(f.auc)},
                    {"expected_calibration_error", json_of(f.calibration_error)},
                    {"in_95pct_ellipse", json_of(f.in_ellipse)},
                    {"rank_correlation", json_of(f.rank_correlation)},
                    {"rms_error_m", {{"expected", f.expected_rms_m}, {"actual", f.actual_rms_m}}}};
  for (size_t t = 0; t < kTextures; ++t) j["auc_of"][kTextureNames[t]] = json_of(f.textures[t]);
  for (size_t b = 0; b < kReliabilityBins; ++b) {
    const ReliabilityBin& bin = f.reliability.bins[b];
    j["calibration"].push_back({{"from", double(b) / kReliabilityBins},
                                {"to", double(b + 1) / kReliabilityBins},
                                {"count", bin.count},
                                {"predicted", bin.predicted},
                                {"observed", bin.observed}});
  }
  return j;
}

std::string text_of(const Estimate& e) {
  const auto number = [](double v) { return std::isnan(v) ? std::string("-") : fmt::format("{:.3f}", v); };
  return fmt::format("{} {:>13}", number(e.value),
                     fmt::format("({}..{})", number(e.interval.low), number(e.interval.high)));
}

constexpr const char* kRow =
    "{:<11}  {:<{}}  {:>6}  {:>6}  {:>20}  {:>20}  {:>20}  {:>20}  {:>6}  {:>6}  {:>6}  {:>6}\n";

std::string row(const std::string& matcher, const std::string& camera, size_t width, const NavigabilityFigures& f) {
  const auto short_of = [](const Estimate& e) { return std::isnan(e.value) ? "-" : fmt::format("{:.3f}", e.value); };
  return fmt::format(fmt::runtime(kRow), matcher, camera, width, f.samples,
                     fmt::format("{:.1f}", 100.0 * double(f.hits) / double(f.samples)), text_of(f.auc),
                     text_of(f.calibration_error), text_of(f.in_ellipse), text_of(f.rank_correlation),
                     short_of(f.textures[0]), short_of(f.textures[1]), short_of(f.textures[2]),
                     short_of(f.textures[3]));
}

std::string calibration_text(const std::string& matcher, const NavigabilityFigures& f) {
  std::string text = fmt::format("\n{}: chances as stated, and the share of true fixes\n", matcher);
  for (size_t b = 0; b < kReliabilityBins; ++b) {
    const ReliabilityBin& bin = f.reliability.bins[b];
    if (bin.count > 0)
      text +=
          fmt::format("  {:.1f} to {:.1f}  {:>6} samples  stated {:.3f}  true {:.3f}\n", double(b) / kReliabilityBins,
                      double(b + 1) / kReliabilityBins, bin.count, bin.predicted, bin.observed);
  }
  text += fmt::format("  true fixes: expected {:.2f} m rms, were {:.2f} m\n", f.expected_rms_m, f.actual_rms_m);
  if (f.hits == 0 || f.hits == f.samples)
    text += fmt::format("  {} of the samples is a true fix: there is nothing to tell apart, and no AUC\n",
                        f.hits == 0 ? "none" : "every one");
  return text;
}

}  // namespace

NavigabilityFigures figures_of(std::span<const Foreseen> all) {
  std::vector<Sample> samples;
  for (const Foreseen& f : all) samples.push_back(f.sample());
  NavigabilityFigures out;
  std::vector<uint64_t> blocks = blocks_of(samples);
  const Ranked ranked(samples, Ranking::kProbability);
  const Figure figures[] = {[&](Weights w) { return ranked.auc(w); },
                            [&](Weights w) { return reliability(samples, w).calibration_error; }};
  const std::vector<Interval> intervals = bootstrap(blocks, figures);
  out.samples = int64_t(samples.size());
  out.auc = take(ranked.auc(), intervals[0]);
  out.reliability = reliability(samples);
  out.calibration_error = take(out.reliability.calibration_error, intervals[1]);
  out.mean_age_years = mean_age(all);
  out.textures = texture_estimates(all);
  add_errors(all, out);
  std::ranges::sort(blocks);
  out.blocks = size_t(std::unique(blocks.begin(), blocks.end()) - blocks.begin());
  return out;
}

std::vector<NavigabilityReport> report(const std::vector<ForeseenMatcher>& matchers) {
  std::vector<NavigabilityReport> out;
  for (const ForeseenMatcher& m : matchers) {
    NavigabilityReport& r = out.emplace_back();
    r.matcher = m.matcher;
    std::vector<Foreseen> all;
    for (const ForeseenCamera& camera : m.cameras) {
      r.cameras.emplace_back(&camera, figures_of(camera.samples));
      all.insert(all.end(), camera.samples.begin(), camera.samples.end());
    }
    r.pooled = m.cameras.size() == 1 ? r.cameras.front().second : figures_of(all);
  }
  return out;
}

ordered_json to_json(const std::vector<NavigabilityReport>& reports) {
  ordered_json j = ordered_json::array();
  for (const NavigabilityReport& r : reports) {
    ordered_json cameras = ordered_json::array();
    for (const auto& [camera, figures] : r.cameras) {
      ordered_json one = {{"camera", camera->camera}, {"map", camera->map}, {"not_judged", camera->not_judged}};
      one.update(json_of(figures));
      cameras.push_back(one);
    }
    j.push_back({{"matcher", r.matcher}, {"pooled", json_of(r.pooled)}, {"cameras", cameras}});
  }
  return j;
}

std::string to_text(const std::vector<NavigabilityReport>& reports) {
  size_t width = 6;
  for (const NavigabilityReport& r : reports)
    for (const auto& [camera, figures] : r.cameras) width = std::max(width, camera->camera.size());
  std::string text = fmt::format(fmt::runtime(kRow), "matcher", "camera", width, "places", "true %", "AUC (95 %)",
                                 "ECE (95 %)", "in 95 % (95 %)", "Spearman (95 %)", "entr.", "dev.", "edges", "Fisher");
  for (const NavigabilityReport& r : reports) {
    for (const auto& [camera, figures] : r.cameras) text += row(r.matcher, camera->camera, width, figures);
    if (r.cameras.size() > 1) text += row(r.matcher, "all", width, r.pooled);
  }
  for (const NavigabilityReport& r : reports) text += calibration_text(r.matcher, r.pooled);
  return text;
}

std::string to_csv(const std::vector<ForeseenMatcher>& matchers) {
  std::string text =
      "map,camera,matcher,seed,east_m,north_m,block,status,hit,error_east_m,error_north_m,fix_probability,age_years,"
      "covariance_ee_m2,covariance_en_m2,covariance_nn_m2";
  for (const char* name : kTextureNames) text += fmt::format(",{}", name);
  text += "\n";
  for (const ForeseenMatcher& m : matchers)
    for (const ForeseenCamera& camera : m.cameras)
      for (const Foreseen& f : camera.samples) {
        const Trial& t = f.trial;
        const Question& q = t.question;
        text += fmt::format("{},{},{},{},{:.3f},{:.3f},{:x},{},{:d},", camera.map, camera.camera, m.matcher,
                            q.seed_index, q.east_m, q.north_m, q.block, word_of(t.status), t.hit());
        text += t.answered() ? fmt::format("{:.3f},{:.3f},", t.east_m - q.east_m, t.north_m - q.north_m) : ",,";
        text += fmt::format("{:.6f},{},{:.5f},{:.5f},{:.5f}", f.expected.fix_probability,
                            f.age_years ? fmt::format("{:.3f}", *f.age_years) : "", f.expected.covariance_m2[0],
                            f.expected.covariance_m2[1], f.expected.covariance_m2[3]);
        for (size_t k = 0; k < kTextures; ++k)
          text += f.textures ? fmt::format(",{:.6f}", (*f.textures)[k]) : std::string(",");
        text += "\n";
      }
  return text;
}

}  // namespace landfix::eval
