// `landfix eval navigability`: how well a map says beforehand where images will register with it.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "builder/error.h"
#include "runtime/nav/pack_map.h"
#include "tools/common/files.h"
#include "tools/common/map_age.h"
#include "tools/common/open_pack.h"
#include "tools/eval/navigability_report.h"
#include "tools/eval/register.h"
#include "tools/landfix/commands.h"
#include "tools/landfix/eval_shared.h"

namespace landfix::tools {
namespace {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr int kLeastSamples = 20;

struct Arguments {
  std::vector<std::string> maps, cameras, dates, key_files, matchers = {"auto"};
  eval::RegisterOptions options;
  EvalOutput output;
};

struct OpenedMap {
  Pack pack;
  eval::MapFrame frame;
  NavigabilityMap navigability;
};

std::string text_of(const tiles::Footprint& f) { return fmt::format("{}/{}", f.template_m, f.search_m); }

OpenedMap open_map(const std::string& path, const Arguments& a) {
  Pack pack = open_pack(path, a.key_files);
  const tiles::Footprint asked{a.options.template_m, a.options.search_m};
  const tiles::Footprint nearest = nearest_footprint(footprints_of(pack), asked).value_or(asked);
  NavigabilityMap navigability(pack, nearest, path);
  if (nearest != asked)
    fmt::print(stderr, "{}: {} was not judged; nearest to it is {}\n", path, text_of(asked), text_of(nearest));
  if (const double judged_m = tiles::kHitShare * nearest.template_m; judged_m != a.options.hit_m)
    fmt::print(stderr, "{}: its chances are of fixes within {:g} m, --hit-m asks for {:g} m\n", path, judged_m,
               a.options.hit_m);
  eval::MapFrame frame = frame_of(pack, path);
  prepare_layers(pack, path);
  return {std::move(pack), std::move(frame), std::move(navigability)};
}

/// The day on which a camera's image was taken: as the command line says, else the sidecar, else the name of the file.
std::string date_of(const Arguments& a, size_t camera, const eval::CameraImage& image) {
  if (!a.dates.empty()) return a.dates.size() == 1 ? a.dates[0] : a.dates[camera];
  return !image.date().empty() ? image.date() : eval::date_in_name(image.name());
}

void check_arguments(const Arguments& a) {
  check(a.options);
  eval::matchers_named(a.matchers);
  if (a.maps.size() != 1 && a.maps.size() != a.cameras.size())
    throw Error(ExitCode::kUsage, fmt::format("{} --map for {} --camera: expected one for all, or one for each",
                                              a.maps.size(), a.cameras.size()));
  if (a.dates.size() > 1 && a.dates.size() != a.cameras.size())
    throw Error(ExitCode::kUsage, fmt::format("{} --camera-date for {} --camera: expected one for all, or one for each",
                                              a.dates.size(), a.cameras.size()));
  for (const std::string& date : a.dates)
    if (date != "unknown" && !days_of(date))
      throw Error(ExitCode::kUsage, fmt::format("--camera-date {}: expected a day as 2018-07-16, or unknown", date));
  if (int64_t(a.options.samples) * a.options.seeds < kLeastSamples)
    throw Error(ExitCode::kUsage, fmt::format("--samples {}: too few to say anything; expected {} or more",
                                              a.options.samples, kLeastSamples));
}

/// Matchers that the map was judged for; of "all", those that it was.
std::vector<eval::MatcherChoice> judged_matchers(const Arguments& a, const OpenedMap& map) {
  std::vector<eval::MatcherChoice> out = eval::matchers_named(a.matchers);
  const auto judged = [&](const eval::MatcherChoice& m) { return map.navigability.judges(eval::finder_of(m)); };
  if (std::ranges::count(a.matchers, "all") > 0) std::erase_if(out, [&](const auto& m) { return !judged(m); });
  for (const eval::MatcherChoice& m : out)
    if (!judged(m))
      throw Error(ExitCode::kNoData, fmt::format("{}: the map does not say how well {} does; --matcher all takes those "
                                                 "that it was judged for",
                                                 map.frame.path, m.name));
  return out;
}

eval::ForeseenCamera foreseen(const eval::MatcherTrials& trials, const eval::CameraImage& camera, const OpenedMap& map,
                              const std::string& date, double template_m) {
  const eval::Foresight foresight{map.pack,   map.navigability, eval::finder_of(trials.matcher),
                                  template_m, camera.gsd_m(),   days_of(date)};
  eval::ForeseenCamera out{camera.name(), fs::path(map.frame.path).filename().string(), 0,
                           eval::foresee(trials.trials, foresight)};
  out.not_judged = int64_t(trials.trials.size() - out.samples.size());
  if (out.samples.size() < size_t(kLeastSamples))
    throw Error(ExitCode::kNoData,
                fmt::format("{}: the map says something about {} of {} places; expected {} or more", map.frame.path,
                            out.samples.size(), trials.trials.size(), kLeastSamples));
  return out;
}

void add(eval::ForeseenCamera camera, const std::string& matcher, std::vector<eval::ForeseenMatcher>& matchers) {
  auto found = std::ranges::find(matchers, matcher, &eval::ForeseenMatcher::matcher);
  if (found == matchers.end()) found = matchers.insert(found, {matcher, {}});
  found->cameras.push_back(std::move(camera));
}

ordered_json camera_json(const eval::CameraImage& camera, const OpenedMap& map, const std::string& date) {
  const tiles::Footprint& judged = map.navigability.footprint();
  return {{"name", camera.name()},
          {"map", fs::path(map.frame.path).filename().string()},
          {"date", days_of(date) ? ordered_json(date) : ordered_json()},
          {"gsd_m", camera.gsd_m()},
          {"judged_for",
           {{"template_m", judged.template_m},
            {"search_m", judged.search_m},
            {"hit_m", tiles::kHitShare * judged.template_m}}}};
}

void run(Arguments a) {
  check_arguments(a);
  cv::setNumThreads(1);
  std::map<std::string, OpenedMap> maps;
  std::vector<eval::ForeseenMatcher> matchers;
  ordered_json cameras = ordered_json::array();
  for (size_t i = 0; i < a.cameras.size(); ++i) {
    const std::string& path = a.maps.size() == 1 ? a.maps[0] : a.maps[i];
    if (!maps.contains(path)) maps.emplace(path, open_map(path, a));
    const OpenedMap& map = maps.at(path);
    a.options.matchers = judged_matchers(a, map);
    const eval::CameraImage camera(a.cameras[i], map.frame);
    const std::string date = date_of(a, i, camera);
    fmt::print(stderr, "{} ({} of {}): {} templates of {:.0f} m at {:g} m per pixel\n", camera.name(), i + 1,
               a.cameras.size(), a.options.samples * a.options.seeds, a.options.template_m, camera.gsd_m());
    const eval::CameraTrials trials = register_camera(
        camera, int(i), map.frame, [&] { return std::make_unique<nav::PackMap>(map.pack); }, a.options);
    for (const eval::MatcherTrials& m : trials.matchers)
      add(foreseen(m, camera, map, date, a.options.template_m), m.matcher.name, matchers);
    cameras.push_back(camera_json(camera, map, date));
  }
  const std::vector<eval::NavigabilityReport> reports = eval::report(matchers);
  if (!a.output.samples_csv.empty()) write_text(a.output.samples_csv, eval::to_csv(matchers));
  const eval::RegisterOptions& o = a.options;
  write_results(a.output, eval::to_text(reports),
                {{"cameras", cameras},
                 {"options",
                  {{"template_m", o.template_m},
                   {"search_m", o.search_m},
                   {"hit_m", o.hit_m},
                   {"samples", o.samples},
                   {"seed", o.seed},
                   {"seeds", o.seeds},
                   {"rim_px", o.rim_px}}},
                 {"matchers", to_json(reports)}});
}

constexpr const char* kFooter = R"(
Templates are cut and searched as by 'landfix eval register'. Of each place the map is asked beforehand how likely a fix within
the tolerance is, between the nodes of its layer, by the footprint nearest to --template-m and --search-m; --hit-m should be
15/160 of the judged view. A chance falls with the years between the camera's image and the nearest date of the map.

Examples:
  landfix build 2009.tif 2014.tif 2016.tif --navigability 160/160 -o area.lfpack
  landfix eval navigability --map area.lfpack --camera 2018.tif --camera-date 2018-07-16
  landfix eval navigability --map a.lfpack --camera 2009.tif --map b.lfpack --camera 2018.tif --json
      each camera with its own map, and all pooled

Table: share of true fixes, AUC of the stated chance (that a true fix had a higher one than a miss), expected calibration error,
true fixes within their 95 % ellipse as foretold, rank correlation of foretold spread and actual error, each with its 95 % interval
(block bootstrap); then the AUC of entropy, standard deviation, density of edges and Fisher information of the map's gray values
on the same samples. docs/evaluation.md has the definitions.
)";

}  // namespace

void add_eval_navigability(CLI::App& eval_command) {
  auto arguments = std::make_shared<Arguments>();
  Arguments& a = *arguments;
  eval::RegisterOptions& o = a.options;
  o.template_m = 160, o.search_m = 160, o.seeds = 1;
  CLI::App* sub =
      eval_command.add_subcommand("navigability", "Compare what a map foretells about registration with what happens");
  sub->add_option("--map", a.maps, "Map pack with navigability: one for all cameras, or one for each, in their order")
      ->required()
      ->type_name("PACK");
  sub->add_option("--camera", a.cameras, "Georeferenced image that serves as the camera (may be repeated)")
      ->required()
      ->type_name("IMAGE");
  sub->add_option(
         "--camera-date", a.dates,
         "When the images were taken: one day for all, or one for each; unknown: chances are taken as they are "
         "[by the sidecar, else by a date in the file's name]")
      ->type_name("2018-07-16");
  sub->add_option("--key", a.key_files, "Trusted public key file of the maps (may be repeated)")
      ->allow_extra_args(false);
  sub->add_option("--matcher", a.matchers, "all, auto, gray, edge, contour or orientation (may be repeated)")
      ->allow_extra_args(false)
      ->capture_default_str();
  add_sampling(*sub, o);
  sub->add_option("--rim-px", o.rim_px, "Pixels around the template that serve the operators and do not vote")
      ->capture_default_str();
  add_threads(*sub, o.threads);
  add_samples(*sub, a.output);
  add_output(*sub, a.output);
  sub->footer(kFooter);
  sub->callback([arguments] { run(*arguments); });
}

}  // namespace landfix::tools
