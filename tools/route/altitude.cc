#include "tools/route/altitude.h"

#include <fmt/format.h>

#include <cmath>
#include <tuple>

#include "builder/error.h"

namespace landfix::route {
namespace {

AltitudeRow row(const Path& path, double agl_m, const NavigabilityMap& map, const Vehicle& vehicle,
                const ScoreOptions& options) {
  AltitudeRow row;
  row.agl_m = agl_m;
  row.footprint_m = vehicle.footprint_m(agl_m);
  row.camera_gsd_m = vehicle.camera_gsd_m(agl_m);
  row.score = score(path, map, vehicle, options);
  for (const LegScore& leg : row.score.legs)
    row.fix_probability += leg.fix_probability * (leg.leg.end_m - leg.leg.start_m) / row.score.length_m;
  return row;
}

/// Less is better. Shares to a thousandth, so that noise in the last digits decides nothing.
auto rank(const AltitudeRow& row) {
  return std::tuple(-std::round(row.score.meeting * 1000), row.score.largest_radius_m);
}

}  // namespace

AltitudeComparison compare_altitudes(const PathAt& path_at, const std::vector<double>& heights_agl_m,
                                     const NavigabilityMap& map, const Vehicle& vehicle, const ScoreOptions& options) {
  if (heights_agl_m.empty())
    throw Error(ExitCode::kUsage, "route: expected heights above ground to compare, found none");
  AltitudeComparison comparison;
  for (const double agl_m : heights_agl_m) {
    if (!(agl_m > 0 && std::isfinite(agl_m)))
      throw Error(ExitCode::kUsage, fmt::format("route: expected heights above ground, found {} m", agl_m));
    comparison.rows.push_back(row(path_at(agl_m), agl_m, map, vehicle, options));
    if (rank(comparison.rows.back()) < rank(comparison.rows[comparison.best]))
      comparison.best = comparison.rows.size() - 1;
  }
  return comparison;
}

nlohmann::ordered_json to_json(const AltitudeComparison& comparison) {
  const auto rounded = [](double value) { return std::round(value * 1000) / 1000; };
  nlohmann::ordered_json json;
  json["best_agl_m"] = comparison.rows[comparison.best].agl_m;
  json["altitudes"] = nlohmann::ordered_json::array();
  for (const AltitudeRow& r : comparison.rows) {
    json["altitudes"].push_back({{"agl_m", r.agl_m},
                                 {"footprint_m", rounded(r.footprint_m)},
                                 {"camera_gsd_m", rounded(r.camera_gsd_m)},
                                 {"mean_fix_probability", rounded(r.fix_probability)},
                                 {"rms_m", rounded(r.score.rms_m)},
                                 {"largest_radius_m", rounded(r.score.largest_radius_m)},
                                 {"share_meeting", rounded(r.score.meeting)},
                                 {"expected_share_within", rounded(r.score.within)},
                                 {"longest_gap_m", rounded(r.score.longest_gap.length_m())},
                                 {"worst_reason", r.score.worst.reason}});
  }
  return json;
}

std::string to_text(const AltitudeComparison& comparison) {
  const Requirement& r = comparison.rows[comparison.best].score.requirement;
  std::string text =
      fmt::format("{:>8} {:>7} {:>8} {:>6} {:>6} {:>7} {:>8} {:>7}  {}\n", "height m", "view m", "pixel m", "fixes",
                  "rms m", fmt::format("{:.0f}% m", 100 * r.confidence), "meeting", "gap m", "worst");
  for (size_t i = 0; i < comparison.rows.size(); ++i) {
    const AltitudeRow& row = comparison.rows[i];
    text += fmt::format("{:>8.0f} {:>7.0f} {:>8.2f} {:>5.0f}% {:>6.1f} {:>7.1f} {:>7.1f}% {:>7.0f}  {}{}\n", row.agl_m,
                        row.footprint_m, row.camera_gsd_m, 100 * row.fix_probability, row.score.rms_m,
                        row.score.largest_radius_m, 100 * row.score.meeting, row.score.longest_gap.length_m(),
                        row.score.worst.reason, i == comparison.best ? "  <- best" : "");
  }
  return text;
}

}  // namespace landfix::route
