#include "tools/route/score.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

#include "builder/error.h"
#include "tools/route/belief.h"
#include "tools/route/simulate.h"

namespace landfix::route {
namespace {

constexpr double kPoorFix = 0.5;       ///< below it no fix is expected of an image
constexpr double kWorstShare = 0.9;    ///< of the largest radius, where all of the route meets the requirement
constexpr double kTellingShare = 0.2;  ///< of the poor length that a reason must hold for to be named
constexpr double kDrawnImages = 4000;  ///< of the flights that are drawn

/// What is said about the points that are poor.
class Reasons {
 public:
  void add(const ScoredPoint& point, double length_m) {
    poor_m_ += length_m;
    for (uint32_t i = 0; i < lengths_m_.size(); ++i)
      if (point.reasons & (1u << i)) lengths_m_[i] += length_m;
    if (!repeat_ && point.repeat) repeat_ = point.repeat;
  }
  std::string text() const {
    if (poor_m_ <= 0) return {};
    uint32_t bits = 0;
    for (uint32_t i = 0; i < lengths_m_.size(); ++i)
      if (lengths_m_[i] > kTellingShare * poor_m_) bits |= 1u << i;
    const std::string named = words(bits, repeat_);
    return named.empty() ? "few fixes" : named;
  }

 private:
  std::array<double, 16> lengths_m_{};
  double poor_m_ = 0;
  std::optional<Repeat> repeat_;
};

double step_m(const RouteScore& score, size_t i) {
  return score.points[i].station.distance_m - (i > 0 ? score.points[i - 1].station.distance_m : 0);
}
bool meets(const RouteScore& score, size_t i) { return score.points[i].within >= score.requirement.confidence; }
bool poor(const RouteScore& score, size_t i) { return !meets(score, i) || score.points[i].fix_probability < kPoorFix; }

Stretch stretch(const RouteScore& score, size_t first, size_t last) {
  Stretch s;
  s.start_m = first > 0 ? score.points[first - 1].station.distance_m : 0;
  s.start_s = first > 0 ? score.points[first - 1].station.time_s : 0;
  s.end_m = score.points[last].station.distance_m;
  s.end_s = score.points[last].station.time_s;
  Reasons reasons;
  for (size_t i = first; i <= last; ++i) {
    s.radius_m = std::max(s.radius_m, score.points[i].radius_m);
    if (poor(score, i)) reasons.add(score.points[i], step_m(score, i));
  }
  s.reason = reasons.text();
  return s;
}

Stretch worst_stretch(const RouteScore& score) {
  size_t worst = 0;
  for (size_t i = 1; i < score.points.size(); ++i)
    if (score.points[i].radius_m > score.points[worst].radius_m) worst = i;
  const auto belongs = [&](size_t i) {
    return score.met ? score.points[i].radius_m >= kWorstShare * score.points[worst].radius_m : !meets(score, i);
  };
  size_t first = worst, last = worst;
  while (first > 0 && belongs(first - 1)) --first;
  while (last + 1 < score.points.size() && belongs(last + 1)) ++last;
  return stretch(score, first, last);
}

Stretch longest_gap(const RouteScore& score) {
  Stretch longest;
  size_t first = 0;
  for (size_t i = 0; i < score.points.size(); ++i) {
    if (score.points[i].fix_probability >= kPoorFix) {
      first = i + 1;
      continue;
    }
    const double start_m = first > 0 ? score.points[first - 1].station.distance_m : 0;
    const bool ends = i + 1 == score.points.size() || score.points[i + 1].fix_probability >= kPoorFix;
    if (ends && score.points[i].station.distance_m - start_m > longest.length_m()) longest = stretch(score, first, i);
  }
  return longest;
}

ScoredPoint point_of(const Image& image, const Belief& belief, const Requirement& requirement) {
  ScoredPoint p;
  p.station = image.station();
  const View& view = image.view(belief.filter_rms_m() / M_SQRT2);
  p.fix_probability = view.fix_probability;
  p.false_probability = view.false_probability;
  p.reasons = view.reasons;
  p.repeat = view.repeat;
  p.covariance_m2 = belief.covariance_m2();
  p.rms_m = std::sqrt(p.covariance_m2.trace());
  p.radius_m = belief.radius_m(requirement.confidence);
  p.within = belief.within(requirement.radius_m);
  return p;
}

void score_legs(const Path& path, RouteScore& score) {
  std::vector<Reasons> reasons(path.legs().size());
  for (const Leg& leg : path.legs()) score.legs.emplace_back().leg = leg;
  for (size_t i = 0; i < score.points.size(); ++i) {
    const ScoredPoint& p = score.points[i];
    LegScore& leg = score.legs[p.station.leg];
    const double length_m = step_m(score, i);
    leg.rms_m = std::max(leg.rms_m, p.rms_m);
    leg.radius_m = std::max(leg.radius_m, p.radius_m);
    leg.fix_probability += length_m * p.fix_probability;
    if (meets(score, i)) leg.meeting += length_m;
    if (poor(score, i)) reasons[p.station.leg].add(p, length_m);
  }
  std::vector<double> lengths_m(path.legs().size(), 0);
  for (size_t i = 0; i < score.points.size(); ++i) lengths_m[score.points[i].station.leg] += step_m(score, i);
  for (size_t i = 0; i < score.legs.size(); ++i) {
    const double length_m = lengths_m[i] > 0 ? lengths_m[i] : 1;
    score.legs[i].fix_probability /= length_m;
    score.legs[i].meeting /= length_m;
    score.legs[i].reason = reasons[i].text();
  }
}

void summarise(const Path& path, const Vehicle& vehicle, RouteScore& score) {
  double time_s = 0, sum2 = 0, meeting = 0, within = 0, agl = 0, on_map = 0;
  for (size_t i = 0; i < score.points.size(); ++i) {
    const ScoredPoint& p = score.points[i];
    const double length_m = step_m(score, i);
    const double seconds = p.station.time_s - (i > 0 ? score.points[i - 1].station.time_s : 0);
    time_s += seconds;
    within += seconds * p.within;
    sum2 += length_m * p.rms_m * p.rms_m;
    agl += length_m * p.station.agl_m;
    if (meets(score, i)) meeting += length_m;
    if (!(p.reasons & (kOffMap | kNoImage))) on_map += length_m;
    score.largest_rms_m = std::max(score.largest_rms_m, p.rms_m);
    score.largest_radius_m = std::max(score.largest_radius_m, p.radius_m);
  }
  score.length_m = path.length_m();
  score.duration_s = path.duration_s();
  score.rms_m = std::sqrt(sum2 / score.length_m);
  score.meeting = meeting / score.length_m;
  score.within = time_s > 0 ? within / time_s : 0;
  score.on_map = on_map / score.length_m;
  score.mean_agl_m = agl / score.length_m;
  score.footprint_m = vehicle.footprint_m(score.mean_agl_m);
  score.met = true;
  for (size_t i = 0; i < score.points.size(); ++i) score.met &= meets(score, i);
}

}  // namespace

Requirement parse_requirement(const std::string& text) {
  double radius = 0, percent = 0;
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, radius);
  const bool middle = first.ec == std::errc() && std::string_view(first.ptr, end).starts_with("m@");
  const auto second = middle ? std::from_chars(first.ptr + 2, end, percent) : first;
  if (!middle || second.ec != std::errc() || std::string_view(second.ptr, end) != "%" ||
      !(radius > 0 && radius < 1e6) || !(percent > 0 && percent < 100)) {
    throw Error(ExitCode::kUsage, fmt::format("expected a requirement like 10m@95%, found \"{}\"", text));
  }
  return {radius, percent / 100};
}

RouteScore score(const Path& path, const NavigabilityMap& map, const Vehicle& vehicle, const ScoreOptions& options) {
  RouteScore score;
  score.name = path.name();
  score.requirement = options.requirement;
  Belief belief(vehicle.errors);
  for (const Image& image : images_along(path, map, vehicle)) {
    const double agl_m = image.station().agl_m;
    belief.fly(image.flown_m(), agl_m, vehicle.errors);
    belief.look([&](double sigma_m) -> const View& { return image.view(sigma_m); },
                outcome_correlation(image.flown_m(), vehicle.footprint_m(agl_m)), vehicle.independent_m(agl_m));
    score.points.push_back(point_of(image, belief, options.requirement));
  }
  summarise(path, vehicle, score);
  score_legs(path, score);
  score.worst = worst_stretch(score);
  score.longest_gap = longest_gap(score);
  score.corridor_m = options.corridor_m;
  if (options.flights > 0) {
    const Flights flights = simulate(images_along(path, map, vehicle, path.length_m() / kDrawnImages), vehicle,
                                     {options.flights, options.seed, options.requirement.radius_m, options.corridor_m});
    score.in_corridor = flights.in_corridor;
    score.corridor_error = std::sqrt(flights.in_corridor * (1 - flights.in_corridor) / options.flights);
  }
  return score;
}

}  // namespace landfix::route
