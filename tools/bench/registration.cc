// Registration on one core: every matcher on patches of one scale, and the coarse-to-fine search of position, rotation
// and scale. The camera sees another date than the map.
#include "runtime/nav/registration.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <optional>
#include <random>

#include "builder/error.h"
#include "runtime/nav/pack_map.h"
#include "tools/bench/sections.h"
#include "tools/bench/timing.h"
#include "tools/common/manifest_json.h"
#include "tools/common/open_pack.h"
#include "tools/eval/camera_image.h"
#include "tools/eval/trial.h"

namespace landfix::bench {
namespace {

constexpr int kPlaces = 40;
constexpr double kHit_m = 3;
constexpr double kSigmas = 3;
constexpr double kDegree = std::numbers::pi / 180;

struct Case {
  int patch_px, search_px;    ///< the patch is sought up to search_px to each side
  double heading_deg, scale;  ///< searched to either side; 0: known
  std::optional<double> target_ms;
};
constexpr Case kKnownPose{128, 40, 0, 0, {}};
constexpr Case kSearchedPose{256, 200, 5, 0.05, 40};

/// A map and a camera that looks at it.
struct Scene {
  const nav::MapSource& map;
  const eval::CameraImage& camera;
};

/// A random place with a patch that is turned, stretched and displaced within what is searched.
eval::Question random_question(const Scene& scene, const Case& c, std::mt19937_64& random, features::GridImage& patch) {
  const auto between = [&](double low, double high) { return low + (high - low) * double(random() >> 11) * 0x1p-53; };
  const ingest::GridBounds& b = scene.camera.bounds();
  // Half the patch's diagonal lies around a place whichever way it is turned, and the search reaches beyond.
  const double margin_m = c.search_px + 0.75 * c.patch_px;
  eval::Question q;
  q.east_m = between(b.west_m + margin_m, b.east_m - margin_m);
  q.north_m = between(b.south_m + margin_m, b.north_m - margin_m);
  q.similarity = {c.heading_deg * kDegree * between(-0.8, 0.8), 1 + c.scale * between(-0.8, 0.8)};
  const double sigma_m = c.search_px / kSigmas;
  q.prior = {q.east_m + between(-0.5, 0.5) * c.search_px,
             q.north_m + between(-0.5, 0.5) * c.search_px,
             {sigma_m * sigma_m, 0, 0, sigma_m * sigma_m},
             kSigmas,
             0.5 * c.heading_deg * kDegree,
             0.5 * c.scale};
  if (!scene.camera.cut(q.east_m, q.north_m, c.patch_px, q.similarity, patch))
    throw Error(ExitCode::kInternal, "a patch reaches beyond the drawn camera image");
  return q;
}

void time_matcher(const Scene& scene, const eval::MatcherChoice& choice, const Case& c, Report& report) {
  nav::RegistrationOptions options;
  options.method = choice.method;
  options.pose_sigmas = 2;
  nav::Registrar registrar(scene.map, options);
  std::mt19937_64 random(5);
  std::vector<double> ms;
  int hits = 0;
  for (int i = 0; i <= kPlaces; ++i) {
    features::GridImage patch;
    nav::Registration found;
    const eval::Question q = random_question(scene, c, random, patch);
    const double seconds = processor_time_of([&] { registrar.run(patch, q.prior, found); });
    if (i == 0) continue;  // buffers are made
    ms.push_back(1e3 * seconds);
    hits += std::hypot(found.peak.east_m - q.east_m, found.peak.north_m - q.north_m) <= kHit_m;
  }
  std::string name = fmt::format("{} px over +-{}", c.patch_px, c.search_px);
  if (c.heading_deg > 0) name += fmt::format(", +-{:g} deg, +-{:g} %", c.heading_deg, 100 * c.scale);
  name += ": " + choice.name;
  if (c.target_ms)
    report.at_most(name, median(ms), "ms", *c.target_ms);
  else
    report.measured(name, median(ms), "ms");
  report.measured(name + ", found within 3 m", 100.0 * hits / kPlaces, "%");
}

/// Decodes what is compressed, as before a flight.
void prepare(const Pack& pack) {
  const lf_info info = pack.info();
  for (uint32_t layer = 0; layer < info.layer_count; ++layer)
    for (uint32_t i = 0; const Result<lf_level_info> level = pack.level(layer, i); ++i)
      tools::check(pack.prepare(*pack.box(layer, info.west_m, info.south_m, info.east_m, info.north_m, level->gsd_m)),
                   "the benchmark's pack");
}

}  // namespace

void bench_registration(const Data&, const Options& o, Report& report) {
  report.section(
      "registration",
      fmt::format(
          "nav::Registrar on a pack of three drawn dates, all layers prepared, the camera at a fourth "
          "date; median of {} random places, one thread, its processor time; where rotation and scale are searched, "
          "over two sigmas to either side",
          kPlaces));
  cv::setNumThreads(1);
  const Seasons seasons = make_seasons(o);
  const Pack pack = tools::open_pack(seasons.pack.string());
  prepare(pack);
  const nav::PackMap map(pack);
  const lf_info info = pack.info();
  const eval::CameraImage camera(seasons.camera.string(), {seasons.pack.string(),
                                                           tools::zone_of(pack),
                                                           {info.west_m, info.south_m, info.east_m, info.north_m},
                                                           eval::raster_levels(map)});
  for (const eval::MatcherChoice& choice : eval::matchers_named({"all"}))
    time_matcher({map, camera}, choice, kKnownPose, report);
  for (const char* name : {"orientation", "auto"})
    time_matcher({map, camera}, eval::matchers_named({name})[0], kSearchedPose, report);
}

}  // namespace landfix::bench
