#include "tools/eval/report.h"

#include <nlohmann/json.hpp>

namespace landfix::eval {

std::vector<MatcherReport> report(const std::vector<CameraTrials>& trials) {
  std::vector<MatcherReport> out;
  for (size_t m = 0; !trials.empty() && m < trials.front().matchers.size(); ++m) {
    MatcherReport& r = out.emplace_back();
    r.matcher = trials.front().matchers[m].matcher.name;
    std::vector<Trial> all;
    for (const CameraTrials& camera : trials) {
      const std::vector<Trial>& of_camera = camera.matchers[m].trials;
      r.cameras.emplace_back(camera.camera, summarize(of_camera));
      all.insert(all.end(), of_camera.begin(), of_camera.end());
    }
    r.pooled = trials.size() == 1 ? r.cameras.front().second : summarize(all);
  }
  return out;
}

nlohmann::ordered_json to_json(const std::vector<MatcherReport>& reports) {
  nlohmann::ordered_json j = nlohmann::ordered_json::array();
  for (const MatcherReport& r : reports) {
    nlohmann::ordered_json cameras = nlohmann::ordered_json::array();
    for (const auto& [camera, summary] : r.cameras) {
      nlohmann::ordered_json one = {{"camera", camera}};
      one.update(to_json(summary));
      cameras.push_back(one);
    }
    j.push_back({{"matcher", r.matcher}, {"pooled", to_json(r.pooled)}, {"cameras", cameras}});
  }
  return j;
}

std::string to_text(const std::vector<MatcherReport>& reports) {
  std::vector<TableRow> rows;
  for (const MatcherReport& r : reports) {
    for (const auto& [camera, summary] : r.cameras) rows.push_back({r.matcher, camera, &summary});
    if (r.cameras.size() > 1) rows.push_back({r.matcher, "all", &r.pooled});
  }
  return table(rows);
}

std::string to_csv(const std::vector<CameraTrials>& trials) {
  std::string text = trial_csv_header();
  for (const CameraTrials& camera : trials)
    for (const MatcherTrials& m : camera.matchers)
      for (const Trial& t : m.trials) text += trial_csv_line(m.matcher.name, t);
  return text;
}

}  // namespace landfix::eval
