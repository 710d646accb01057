// The figures of a set of trials, as JSON and as a table.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "tools/eval/statistics.h"
#include "tools/eval/trial.h"

namespace landfix::eval {

/// A figure computed for every seed on its own.
struct OverSeeds {
  double mean = 0, low = 0, high = 0;
};

struct Summary {
  int64_t samples = 0, answered = 0;
  std::map<std::string, int64_t> refused;  ///< unanswered samples by word_of(status)
  size_t blocks = 0;                       ///< pieces of ground that count as independent
  double hit_rate = 0;
  std::vector<double> error_quantiles_m;  ///< of hits, at kErrorShares
  double in_ellipse = 0;                  ///< hits within the stated 95 % ellipse
  struct Oracle {
    Ranked::Oracle at_1pct, at_01pct;
    double auc = 0;
  } by_probability, by_gap;
  GateOutcome standard, strict;  ///< at the shipped thresholds
  Reliability reliability;
  Intervals intervals;  ///< of the standard gate
  OverSeeds seeds_hit_rate, seeds_accept_rate_1pct, seeds_accept_rate_1pct_by_gap;
  double rotation_rms_rad = 0, scale_rms = 0;  ///< error of what was found, of hits; NaN where there are none
  double median_ms = 0, percentile95_ms = 0;
};

inline constexpr double kErrorShares[] = {0.5, 0.9, 0.95, 0.99};

Summary summarize(std::span<const Trial> trials);

/// Keys are documented in docs/evaluation.md; what is not known is null.
nlohmann::ordered_json to_json(const Summary& summary);

/// One line per row: a name and its figures, under a line of headings.
struct TableRow {
  std::string matcher, camera;
  const Summary* summary;
};
std::string table(std::span<const TableRow> rows);

}  // namespace landfix::eval
