// How well a map's navigability foretells registration: figures, as JSON, table and samples.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "tools/eval/navigability.h"

namespace landfix::eval {

/// A figure with its 95 % interval by block bootstrap; NaN where it is not defined.
struct Estimate {
  double value = 0;
  Interval interval;
};

struct NavigabilityFigures {
  int64_t samples = 0, hits = 0;
  size_t blocks = 0;  ///< pieces of ground that count as independent
  Estimate auc;       ///< that a true fix was given a higher chance than a miss
  Reliability reliability;
  Estimate calibration_error;
  Estimate in_ellipse;                          ///< of true fixes: error within the 95 % ellipse
  Estimate rank_correlation;                    ///< of true fixes: standard deviation and error (Spearman)
  double expected_rms_m = 0, actual_rms_m = 0;  ///< distances of true fixes
  double mean_age_years = 0;                    ///< NaN where it is not known for all
  /// AUC by kTextureNames, of the samples of which it is known.
  std::array<Estimate, kTextures> textures;
};

NavigabilityFigures figures_of(std::span<const Foreseen> samples);

/// What a camera image asked a map, by one matcher.
struct ForeseenCamera {
  std::string camera, map;
  int64_t not_judged = 0;  ///< samples at places that the map says nothing about
  std::vector<Foreseen> samples;
};
struct ForeseenMatcher {
  std::string matcher;
  std::vector<ForeseenCamera> cameras;
};

struct NavigabilityReport {
  std::string matcher;
  std::vector<std::pair<const ForeseenCamera*, NavigabilityFigures>> cameras;  ///< of what the report was made of
  NavigabilityFigures pooled;
};
/// `matchers` must outlive the reports.
std::vector<NavigabilityReport> report(const std::vector<ForeseenMatcher>& matchers);

/// Array over matchers of `matcher`, `pooled` and `cameras`; keys are documented in docs/evaluation.md, what is not
/// defined is null.
nlohmann::ordered_json to_json(const std::vector<NavigabilityReport>& reports);

/// A table with a line per matcher and camera, and the calibration of all cameras together.
std::string to_text(const std::vector<NavigabilityReport>& reports);

/// One line per sample.
std::string to_csv(const std::vector<ForeseenMatcher>& matchers);

}  // namespace landfix::eval
