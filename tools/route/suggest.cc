#include "tools/route/suggest.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "builder/error.h"

namespace landfix::route {
namespace {

constexpr double kNavigable = 0.05;  ///< chance of a fix below which a place is of no use at all
constexpr double kTighter = 0.94;    ///< radius asked of the grid, times this for each time that the score disagreed
constexpr int kTries = 4;
constexpr int kHalvings = 6;           ///< of the radius, on a logarithmic scale over a range of 64 at most
constexpr double kWorthShowing = 0.9;  ///< largest radius of the steadiest way over that of the suggested one

/// Throws unless some place of the region gives fixes.
void require_navigable(const RouteProblem& problem) {
  const Extent region = region_of(problem);
  const double agl_m = problem.above_ground ? problem.level_m : 0.5 * (problem.least_agl_m + problem.most_agl_m);
  for (double north = region.south_m; north <= region.north_m; north += problem.node_m) {
    for (double east = region.west_m; east <= region.east_m; east += problem.node_m) {
      const std::optional<double> ground = problem.above_ground ? std::nullopt : problem.heights.ground_m(east, north);
      const double above_m = ground ? problem.level_m - *ground : agl_m;
      if (view_at(*problem.map, problem.vehicle, east, north, above_m, search_m(problem.vehicle, 0, above_m))
              .fix_probability >= kNavigable)
        return;
    }
  }
  throw Error(
      ExitCode::kNoData,
      fmt::format("route: expected places where an image gives a fix, found none within {:.1f} by {:.1f} km around "
                  "the route; use a map of finer or newer imagery, or another height above ground",
                  (region.east_m - region.west_m) / 1000, (region.north_m - region.south_m) / 1000));
}

Alternative scored(const std::string& name, std::vector<Eigen::Vector2d> points, const RouteProblem& problem,
                   const ScoreOptions& options) {
  Alternative a;
  a.name = name;
  a.points = std::move(points);
  for (size_t i = 0; i + 1 < a.points.size(); ++i) a.allowed &= allowed(problem, a.points[i], a.points[i + 1]);
  try {
    const Path path =
        path_through(name, a.points, problem.level_m, problem.above_ground, problem.speed_mps, problem.heights);
    a.score = score(path, *problem.map, problem.vehicle, options);
  } catch (const Error& error) {
    a.allowed = false;
    a.refused = error.what();
  }
  return a;
}

/// The cheapest route on the grid, with as few corners as its cost allows.
std::optional<std::vector<Eigen::Vector2d>> route(const RouteProblem& problem, CostModel model, bool may_miss) {
  CostModel on_grid = model;
  if (!may_miss) on_grid.missing = std::numeric_limits<double>::infinity();
  std::optional<std::vector<Eigen::Vector2d>> points = cheapest_route(problem, on_grid);
  if (points) points = straightened(problem, model, std::move(*points));
  return points;
}

/// A route that meets the requirement by its score, or else the best that misses it.
Alternative best(const std::string& name, const RouteProblem& problem, const SuggestOptions& options, double exposure) {
  CostModel model;
  model.requirement = options.score.requirement;
  model.exposure = exposure;
  ScoreOptions quick = options.score;
  quick.flights = 0;
  for (int i = 0; i < kTries; ++i, model.requirement.radius_m *= kTighter) {
    const auto points = route(problem, model, false);
    if (!points) break;
    if (scored(name, *points, problem, quick).score.met) return scored(name, *points, problem, options.score);
  }
  model.requirement = options.score.requirement;
  const auto points = route(problem, model, true);
  if (!points) {
    throw Error(ExitCode::kBadInput,
                "route: expected a way between the places, found none that fences and altitude band "
                "allow; check both, and that no place lies in a forbidden area");
  }
  return scored(name, *points, problem, options.score);
}

/// Where no way meets the requirement: the one whose largest error is the least. Nothing where that is hardly less than
/// on the suggested way.
std::optional<Alternative> steadiest(const RouteProblem& problem, const SuggestOptions& options,
                                     const RouteScore& suggested) {
  CostModel model;
  model.requirement = options.score.requirement;
  model.exposure = options.exposure;
  double most_m = suggested.largest_radius_m, least_m = std::max(model.requirement.radius_m, most_m / 64);
  std::optional<Alternative> found;
  for (int i = 0; i < kHalvings && least_m < most_m; ++i) {
    model.requirement.radius_m = std::sqrt(least_m * most_m);
    const auto points = route(problem, model, false);
    if (!points) {
      least_m = model.requirement.radius_m;
      continue;
    }
    most_m = model.requirement.radius_m;
    Alternative a = scored("steadiest", *points, problem, options.score);
    if (!found || a.score.largest_radius_m < found->score.largest_radius_m) found = std::move(a);
  }
  if (found && found->score.largest_radius_m > kWorthShowing * suggested.largest_radius_m) found.reset();
  return found;
}

std::string why_not(const RouteScore& s, const std::optional<Alternative>& steadiest) {
  const std::string best = steadiest
                               ? fmt::format("{:.1f} m can be kept everywhere, on a way of {:.2f} km (steadiest).",
                                             steadiest->score.largest_radius_m, steadiest->score.length_m / 1000)
                               : "No other way keeps much less everywhere.";
  return fmt::format(
      "no route was found that keeps {:g} m at {:g} % everywhere. The one that misses it over the least length does so "
      "on {:.1f} % of it, the worst stretch is {:.0f} to {:.0f} m after the start ({:.0f} m, {:.0f} s: {}), where "
      "{:.1f} m are reached. {}",
      s.requirement.radius_m, 100 * s.requirement.confidence, 100 * (1 - s.meeting), s.worst.start_m, s.worst.end_m,
      s.worst.length_m(), s.worst.duration_s(), s.worst.reason, s.worst.radius_m, best);
}

}  // namespace

Suggestion suggest(const RouteProblem& problem, const SuggestOptions& options) {
  if (problem.stops.size() < 2) throw Error(ExitCode::kUsage, "route: expected a start and an end");
  for (const Stop& stop : problem.stops) {
    if (problem.map->extent().holds(stop.place.x(), stop.place.y())) continue;
    throw Error(ExitCode::kNoData,
                fmt::format("route: expected places on the map, found east {:.0f}, north {:.0f}; choose "
                            "others, or the map of this area",
                            stop.place.x(), stop.place.y()));
  }
  require_navigable(problem);
  std::vector<Eigen::Vector2d> straight;
  for (const Stop& stop : problem.stops) straight.push_back(stop.place);
  const Alternative shortest = scored("straight", straight, problem, options.score),
                    safer = best("safer", problem, options, options.safer);
  Alternative suggested = best("suggested", problem, options, options.exposure);
  // The search judges image by image on its grid, the score the whole way: another way may keep what the cheapest does
  // not.
  for (const Alternative& other : {shortest, safer})
    if (!suggested.score.met && other.allowed && other.score.met) suggested = other, suggested.name = "suggested";
  Suggestion suggestion;
  suggestion.alternatives = {shortest, suggested, safer};
  suggestion.met = suggestion.suggested().score.met;
  if (suggestion.met) return suggestion;
  const std::optional<Alternative> best_kept = steadiest(problem, options, suggestion.suggested().score);
  suggestion.explanation = why_not(suggestion.suggested().score, best_kept);
  if (best_kept) suggestion.alternatives.push_back(*best_kept);
  return suggestion;
}

nlohmann::ordered_json to_json(const Suggestion& suggestion, const tiles::Zone& zone) {
  nlohmann::ordered_json json = {{"met", suggestion.met}, {"explanation", suggestion.explanation}};
  json["alternatives"] = nlohmann::ordered_json::array();
  for (const Alternative& a : suggestion.alternatives) {
    nlohmann::ordered_json entry = {{"name", a.name}, {"allowed", a.allowed}, {"waypoints", a.points.size()}};
    if (a.refused.empty()) {
      entry["score"] = to_json(a.score, zone);
    } else {
      entry["refused"] = a.refused;
    }
    json["alternatives"].push_back(std::move(entry));
  }
  return json;
}

std::string to_text(const Suggestion& suggestion) {
  const Requirement& r = suggestion.suggested().score.requirement;
  std::string text = fmt::format("{:<12} {:>9} {:>9} {:>7} {:>7} {:>7} {:>9} {:>9} {:>8}  {}\n", "route", "length km",
                                 "waypoints", "rms m", "max rms", fmt::format("{:.0f}% m", 100 * r.confidence),
                                 "meeting", "gap m", "corridor", "worst stretch");
  for (const Alternative& a : suggestion.alternatives) {
    if (!a.refused.empty()) {
      text += fmt::format("{:<12} {}\n", a.name, a.refused);
      continue;
    }
    const RouteScore& s = a.score;
    text +=
        fmt::format("{:<12} {:>9.2f} {:>9} {:>7.1f} {:>7.1f} {:>7.1f} {:>8.1f}% {:>9.0f} {:>8}  {}{}\n", a.name,
                    s.length_m / 1000, a.points.size(), s.rms_m, s.largest_rms_m, s.largest_radius_m, 100 * s.meeting,
                    s.longest_gap.length_m(), s.in_corridor ? fmt::format("{:.1f}%", 100 * *s.in_corridor) : "-",
                    s.met ? "meets the requirement" : s.worst.reason, a.allowed ? "" : "; not allowed");
  }
  if (!suggestion.met) text += "\n" + suggestion.explanation + "\n";
  return text;
}

}  // namespace landfix::route
