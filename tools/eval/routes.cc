#include "tools/eval/routes.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "builder/error.h"
#include "tools/fly/noise.h"
#include "tools/fly/summary.h"

namespace landfix::eval {
namespace {

constexpr double kTurnRadiusM = 40;
constexpr int kTriesPerRoute = 1000;
constexpr double kRight = 0.25;  ///< a prediction is right where it is off by no more than this share

/// Places so far inside that the camera sees the scene in spite of sway and turns.
route::Extent inside(const route::Extent& area, const route::Vehicle& vehicle, double agl_m) {
  const double margin_m = vehicle.footprint_m(agl_m) + kTurnRadiusM;
  return {area.west_m + margin_m, area.south_m + margin_m, area.east_m - margin_m, area.north_m - margin_m};
}

std::vector<route::Stop> draw_stops(const route::Extent& area, double length_m, fly::NoiseStream& random) {
  for (int i = 0; i < kTriesPerRoute; ++i) {
    const double east = random.uniform(), north = random.uniform(), bearing = 2 * M_PI * random.uniform();
    const Eigen::Vector2d from(std::lerp(area.west_m, area.east_m, east), std::lerp(area.south_m, area.north_m, north));
    const Eigen::Vector2d to = from + length_m * Eigen::Vector2d(std::sin(bearing), std::cos(bearing));
    if (area.holds(to.x(), to.y())) return {{from}, {to}};
  }
  throw Error(ExitCode::kNoData,
              fmt::format("expected room for routes of {:.0f} m where map and scene overlap, found {:.0f} by {:.0f} m; "
                          "choose shorter ones",
                          length_m, area.east_m - area.west_m, area.north_m - area.south_m));
}

/// Flies a way again and again; sums over all images after the last with GNSS.
void fly_way(const RoutesScene& s, const RoutesOptions& options, uint64_t seed, FlownRoute& out) {
  const fly::Route way = fly::Route::through(out.points, kTurnRadiusM);
  std::vector<terrain::Scene> scenes;
  for (const fly::SceneSource& source : s.sources) scenes.push_back(fly::load_scene(source, s.zone, way, s.flight));
  struct Sums {
    double squares = 0;
    size_t images = 0, within = 0;
  };
  std::vector<Sums> runs(size_t(options.runs));
  tbb::parallel_for(size_t(0), runs.size(), [&](size_t run) {
    const auto map = s.open_map();
    for (const fly::Record& r : fly::fly(scenes[run % scenes.size()], *map, way, s.flight, seed + run)) {
      if (r.gnss) continue;
      const double error_m = fly::error_m(r);
      runs[run].squares += error_m * error_m;
      ++runs[run].images;
      runs[run].within += error_m <= s.score.requirement.radius_m;
    }
  });
  Sums all;
  for (const Sums& run : runs) {
    all.squares += run.squares;
    all.images += run.images;
    all.within += run.within;
  }
  if (all.images == 0) throw Error(ExitCode::kBadInput, "the routes are too short for a single image");
  out.rms_m = std::sqrt(all.squares / double(all.images));
  out.within = double(all.within) / double(all.images);
}

/// Of the ways that meet the requirement the shortest, by the search that suggests, but with nothing else to care for.
double shortest_m(const route::RouteProblem& problem, const route::Requirement& requirement) {
  const route::CostModel model{requirement, 0, std::numeric_limits<double>::infinity()};
  const auto points = cheapest_route(problem, model);
  return points ? cost_of(problem, model, straightened(problem, model, *points)).length_m : NAN;
}

RouteTrial fly_trial(const RoutesScene& scene, const RoutesOptions& options, uint64_t seed) {
  RouteTrial trial;
  const route::Suggestion suggestion = suggest(scene.problem, {.score = scene.score});
  for (const size_t i : {0, 1}) {
    const route::Alternative& way = suggestion.alternatives[i];
    if (!way.refused.empty()) throw Error(ExitCode::kBadInput, way.refused);
    FlownRoute& flown = i == 0 ? trial.straight : trial.suggested;
    if (i == 1 && way.points == trial.straight.points) {
      flown = trial.straight;
      continue;
    }
    flown.points = way.points;
    flown.said = way.score;
    fly_way(scene, options, seed, flown);
  }
  trial.can_be_met = suggestion.met;
  trial.shortest_m = shortest_m(scene.problem, scene.score.requirement);
  return trial;
}

double ratio(const FlownRoute& r) { return r.said.rms_m / r.rms_m; }

std::string row(const RouteTrial& t) {
  const auto way = [](const FlownRoute& r) {
    return fmt::format("{:>8.2f} {:>6.2f} {:>6.2f} {:>6.2f} {:>8.1f}% {:>6.1f}%", r.said.length_m / 1000, r.said.rms_m,
                       r.rms_m, ratio(r), 100 * r.said.within, 100 * r.within);
  };
  return fmt::format("{}  {}  {:>6.2f} {}\n", way(t.straight), way(t.suggested),
                     t.suggested.said.length_m / t.shortest_m, t.can_be_met ? "yes" : "no");
}

struct Tally {
  size_t ways = 0, right = 0;          ///< straight and suggested ones; whose RMS was predicted
  size_t can_be_met = 0, reached = 0;  ///< of the pairs of places; whose flights kept the requirement's share
  double straight = 0, suggested = 0;  ///< mean share of the time within the radius, where it can be met
  double longest = 0;                  ///< suggested length over the shortest, where it can be met
};

Tally tally_of(const std::vector<RouteTrial>& trials) {
  Tally s;
  for (const RouteTrial& t : trials) {
    for (const FlownRoute* way : {&t.straight, &t.suggested}) {
      if (way == &t.suggested && way->points == t.straight.points) continue;
      ++s.ways;
      s.right += std::abs(ratio(*way) - 1) <= kRight;
    }
    if (!t.can_be_met) continue;
    ++s.can_be_met;
    s.reached += t.suggested.within >= t.suggested.said.requirement.confidence;
    s.straight += t.straight.within;
    s.suggested += t.suggested.within;
    if (!std::isnan(t.shortest_m)) s.longest = std::max(s.longest, t.suggested.said.length_m / t.shortest_m);
  }
  if (s.can_be_met == 0) return s;
  s.straight /= double(s.can_be_met);
  s.suggested /= double(s.can_be_met);
  return s;
}

nlohmann::ordered_json flown_json(const FlownRoute& r) {
  nlohmann::ordered_json points = nlohmann::ordered_json::array();
  for (const Eigen::Vector2d& p : r.points) points.push_back({p.x(), p.y()});
  return {{"points", points},
          {"length_m", r.said.length_m},
          {"met", r.said.met},
          {"predicted_rms_m", r.said.rms_m},
          {"flown_rms_m", r.rms_m},
          {"predicted_share_within", r.said.within},
          {"flown_share_within", r.within}};
}

}  // namespace

std::vector<RouteTrial> fly_routes(const RoutesScene& scene, const route::Extent& area, const RoutesOptions& options,
                                   const std::function<void(const std::string&)>& progress) {
  const route::Extent room = inside(area, scene.problem.vehicle, scene.flight.agl_m);
  if (!(room.west_m < room.east_m && room.south_m < room.north_m))
    throw Error(ExitCode::kNoData, "map and scene share no ground that the camera could fly over; choose others");
  RoutesScene here = scene;
  here.problem.fences = route::Fences({}, {{{room.west_m, room.south_m},
                                            {room.east_m, room.south_m},
                                            {room.east_m, room.north_m},
                                            {room.west_m, room.north_m}}});
  fly::NoiseStream random(options.seed, fly::Stream::kConstant);
  std::vector<RouteTrial> trials;
  tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
  for (int i = 0; i < options.routes; ++i) {
    here.problem.stops = draw_stops(room, options.length_m, random);
    arena.execute([&] { trials.push_back(fly_trial(here, options, options.seed + uint64_t(i) * 0x10000)); });
    progress(fmt::format("route {} of {}: {}", i + 1, options.routes, row(trials.back())));
  }
  return trials;
}

std::string to_text(const std::vector<RouteTrial>& trials) {
  std::string text = fmt::format("{:^45}  {:^45}\n", "straight", "suggested");
  for (int i = 0; i < 2; ++i)
    text += fmt::format("{:>8} {:>6} {:>6} {:>6} {:>9} {:>7}  ", "km", "rms", "flown", "ratio", "in radius", "flown");
  text += "/ shortest, met\n";
  for (const RouteTrial& t : trials) text += row(t);
  const Tally s = tally_of(trials);
  text += fmt::format("\nroot mean square predicted to a quarter: {} of {} ways\n", s.right, s.ways);
  if (s.can_be_met == 0) return text + "nowhere a way was found that meets the requirement\n";
  text += fmt::format(
      "where a way meets the requirement ({} of {}): time within the radius {:.1f} % on the straight ways, {:.1f} % on "
      "the suggested, enough on {} of them; longest {:.2f} times the shortest\n",
      s.can_be_met, trials.size(), 100 * s.straight, 100 * s.suggested, s.reached, s.longest);
  return text;
}

nlohmann::ordered_json to_json(const std::vector<RouteTrial>& trials) {
  const Tally s = tally_of(trials);
  nlohmann::ordered_json json = {{"ways", s.ways},
                                 {"predicted_to_a_quarter", s.right},
                                 {"routes", trials.size()},
                                 {"routes_that_can_meet", s.can_be_met},
                                 {"routes_that_met_in_flight", s.reached},
                                 {"straight_share_within", s.straight},
                                 {"suggested_share_within", s.suggested},
                                 {"longest_over_shortest", s.longest}};
  json["trials"] = nlohmann::ordered_json::array();
  for (const RouteTrial& t : trials) {
    json["trials"].push_back({{"straight", flown_json(t.straight)},
                              {"suggested", flown_json(t.suggested)},
                              {"can_be_met", t.can_be_met},
                              {"shortest_m", t.shortest_m}});
  }
  return json;
}

}  // namespace landfix::eval
