#include "tools/eval/register_picture.h"

#include <fmt/format.h>

#include <array>

#include "tools/eval/map_picture.h"

namespace landfix::eval {
namespace {

constexpr int kPanelPx = 620, kPanelsAcross = 3;
constexpr size_t kSmallDotsFrom = 1500;  ///< trials of a panel

/// In the order in which they are drawn: the worst lies on top.
enum Outcome { kAcceptedTrue, kRefusedFalse, kRefusedTrue, kAcceptedFalse, kOutcomes };

const std::array<LegendEntry, kOutcomes> kLegend = {{
    {LegendEntry::Mark::kDot, kBlue, "accepted, true"},
    {LegendEntry::Mark::kDot, kPale, "refused or no match, would be false"},
    {LegendEntry::Mark::kDot, kYellow, "refused though true"},
    {LegendEntry::Mark::kCross, kVermilion, "accepted, FALSE"},
}};

Outcome outcome_of(const Trial& t) {
  if (t.accepted()) return t.hit() ? kAcceptedTrue : kAcceptedFalse;
  return t.hit() ? kRefusedTrue : kRefusedFalse;
}

ingest::GridBounds bounds_of(const std::vector<CameraTrials>& trials) {
  ingest::GridBounds b;
  for (const CameraTrials& camera : trials)
    for (const MatcherTrials& m : camera.matchers)
      for (const Trial& t : m.trials)
        b.extend({t.question.east_m, t.question.north_m, t.question.east_m, t.question.north_m});
  const double margin = 0.04 * std::max(b.east_m - b.west_m, b.north_m - b.south_m) + 1;
  return {b.west_m - margin, b.south_m - margin, b.east_m + margin, b.north_m + margin};
}

cv::Mat panel(const std::vector<CameraTrials>& trials, size_t matcher, const MapPicture& background) {
  MapPicture map = background;
  map.pixels() = map.pixels().clone();
  std::array<std::vector<cv::Point2d>, kOutcomes> places;
  size_t count = 0;
  for (const CameraTrials& camera : trials)
    for (const Trial& t : camera.matchers[matcher].trials) {
      if (t.question.seed_index != 0) continue;
      places[outcome_of(t)].push_back(map.at(t.question.east_m, t.question.north_m));
      ++count;
    }
  const double radius = count < kSmallDotsFrom ? 3 : 2;
  for (size_t o = 0; o < kOutcomes; ++o)
    for (const cv::Point2d& at : places[o])
      kLegend[o].mark == LegendEntry::Mark::kCross ? draw_cross(map.pixels(), at, radius + 1.5, kLegend[o].colour)
                                                   : draw_dot(map.pixels(), at, radius, kLegend[o].colour);
  const double accepted = double(places[kAcceptedTrue].size() + places[kAcceptedFalse].size());
  draw_text(map.pixels(),
            fmt::format("{}: {:.1f} % hits, {:.1f} % accepted, {} false", trials.front().matchers[matcher].matcher.name,
                        100 * double(places[kAcceptedTrue].size() + places[kRefusedTrue].size()) / double(count),
                        100 * accepted / double(count), places[kAcceptedFalse].size()),
            {8, 20}, kInk, 0.5);
  draw_scale_bar(map.pixels(), map.px_per_m());
  return map.pixels();
}

}  // namespace

cv::Mat draw_registration(const std::vector<CameraTrials>& trials, const nav::MapSource& map) {
  const MapPicture background(map, bounds_of(trials), kPanelPx);
  std::vector<cv::Mat> panels;
  for (size_t m = 0; m < trials.front().matchers.size(); ++m) panels.push_back(panel(trials, m, background));
  return with_legend(tiled(panels, kPanelsAcross), {kLegend.begin(), kLegend.end()});
}

}  // namespace landfix::eval
