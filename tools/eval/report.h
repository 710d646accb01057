// What the evaluations of registration have in common: figures per camera image and matcher, and pooled.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/eval/summary.h"

namespace landfix::eval {

struct MatcherTrials {
  MatcherChoice matcher;
  std::vector<Trial> trials;
};

/// The trials of one camera image, all matchers in the same order for every image.
struct CameraTrials {
  std::string camera;
  std::vector<MatcherTrials> matchers;
};

/// Figures of one matcher: for every camera image, and for all trials together.
struct MatcherReport {
  std::string matcher;
  std::vector<std::pair<std::string, Summary>> cameras;
  Summary pooled;
};

std::vector<MatcherReport> report(const std::vector<CameraTrials>& trials);

/// Array over matchers of `matcher`, `pooled` and `cameras`.
nlohmann::ordered_json to_json(const std::vector<MatcherReport>& reports);

/// A table with a line per matcher and camera image, and one for all of them.
std::string to_text(const std::vector<MatcherReport>& reports);

/// One line per trial.
std::string to_csv(const std::vector<CameraTrials>& trials);

}  // namespace landfix::eval
