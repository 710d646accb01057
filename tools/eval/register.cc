#include "tools/eval/register.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <numbers>

#include "builder/error.h"
#include "tools/synth/random.h"

namespace landfix::eval {
namespace {

constexpr int kTries = 1000;          ///< to find a place for one sample
constexpr double kLeastOnMap = 0.95;  ///< of what is searched
constexpr int kCoveragePx = 256;      ///< at least so many pixels a side tell how much that is
constexpr double kSigmas = 3;         ///< of the prior that the search region is

/// Where templates may be taken: the middle of one lies in here.
ingest::GridBounds places(const CameraImage& camera, const MapFrame& map, const RegisterOptions& o) {
  const auto shrunk = [](const ingest::GridBounds& b, double by_m) {
    return ingest::GridBounds{b.west_m + by_m, b.south_m + by_m, b.east_m - by_m, b.north_m - by_m};
  };
  const auto require = [](const ingest::GridBounds& b, double side_m, const std::string& path, const char* what) {
    if (b.empty())
      throw Error(ExitCode::kBadInput, fmt::format("{}: {} of {:.0f} m does not fit in; choose a smaller --template-m "
                                                   "or --search-m",
                                                   path, what, side_m));
  };
  const double window_m = o.template_m + 2 * o.search_m;
  const ingest::GridBounds on_image = shrunk(camera.bounds(), 0.5 * o.template_m),
                           on_map = shrunk(map.bounds, 0.5 * window_m);
  require(on_image, o.template_m, camera.name(), "the template");
  require(on_map, window_m, map.path, "a template with its search region");
  const ingest::GridBounds both{std::max(on_image.west_m, on_map.west_m), std::max(on_image.south_m, on_map.south_m),
                                std::min(on_image.east_m, on_map.east_m), std::min(on_image.north_m, on_map.north_m)};
  require(both, window_m, camera.name(), "a template with its search region on the map");
  return both;
}

/// Share of a square around a place that the map covers, by the first raster layer that it has.
double coverage(const nav::MapSource& map, double east_m, double north_m, double half_m) {
  for (const nav::Method method : nav::kMethods) {
    const auto [finest, coarsest] = map.gsd_range_m(nav::layer_of(method));
    if (finest <= 0) continue;
    double gsd = finest;
    while (2 * gsd <= coarsest && 2 * half_m >= 2 * kCoveragePx * gsd) gsd *= 2;
    features::GridImage window;
    if (map.read(nav::layer_of(method), east_m - half_m, north_m - half_m, east_m + half_m, north_m + half_m, gsd,
                 window) != nav::Status::kOk)
      return 0;
    return window.valid.empty() ? 1 : cv::countNonZero(window.valid) / double(window.valid.total());
  }
  return 0;
}

/// Two independent numbers of mean 0 and standard deviation 1 (Box and Muller 1958).
std::pair<double, double> gaussians(synth::Random& random) {
  const double radius = std::sqrt(-2 * std::log(1 - synth::unit(random.word()))),
               angle = 2 * std::numbers::pi * synth::unit(random.word());
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

uint64_t block_at(double east_m, double north_m, double side_m) {
  return uint64_t(uint32_t(int32_t(std::floor(east_m / side_m)))) << 32 |
         uint32_t(int32_t(std::floor(north_m / side_m)));
}

/// The samples of one camera image: each is a function of seed, camera and number alone.
class Sampler {
 public:
  Sampler(const CameraImage& camera, int camera_index, const MapFrame& frame, const RegisterOptions& options)
      : camera_(camera), camera_index_(camera_index), options_(options), places_(places(camera, frame, options)) {
    side_px_ = 2 * int(std::lround(0.5 * options.template_m / camera.gsd_m())) + 2 * options.rim_px;
  }

  /// Throws Error(kNoData) where no place can be found.
  void draw(int seed_index, int sample, const nav::MapSource& map, Question& question,
            features::GridImage& patch) const {
    const double half_window_m = 0.5 * options_.template_m + options_.search_m;
    synth::Random random(
        synth::key(options_.seed + uint64_t(seed_index), uint64_t(camera_index_), int64_t(sample), 0x5a));
    for (int i = 0; i < kTries; ++i) {
      const double east_m = random.between(places_.west_m, places_.east_m),
                   north_m = random.between(places_.south_m, places_.north_m);
      question = ask(seed_index, east_m, north_m, random);
      if (camera_.cut(east_m, north_m, side_px_, question.similarity, patch) &&
          coverage(map, east_m, north_m, half_window_m) >= kLeastOnMap)
        return;
    }
    throw Error(
        ExitCode::kNoData,
        fmt::format("{}: among {} places none lies wholly in the image with its search region on the map; choose "
                    "a smaller --template-m or --search-m",
                    camera_.name(), kTries));
  }

 private:
  Question ask(int seed_index, double east_m, double north_m, synth::Random& random) const {
    Question q;
    q.camera = camera_.name();
    q.seed_index = seed_index;
    q.east_m = east_m;
    q.north_m = north_m;
    const auto [rotation, scale] = gaussians(random);
    q.similarity = {rotation * options_.rotation_sigma_rad, std::max(0.5, 1 + scale * options_.scale_sigma)};
    const double pixel_m = camera_.gsd_m(), variance = std::pow(options_.search_m / kSigmas, 2);
    q.prior.east_m = east_m + pixel_m * random.between(-0.5, 0.5);
    q.prior.north_m = north_m + pixel_m * random.between(-0.5, 0.5);
    q.prior.covariance_m2 = {variance, 0, 0, variance};
    q.prior.sigmas = kSigmas;
    q.prior.heading_sigma_rad = options_.rotation_sigma_rad;
    q.prior.scale_sigma = options_.scale_sigma;
    q.hit_m = options_.hit_m;
    q.block = block_at(east_m, north_m, options_.template_m + 2 * options_.search_m);
    return q;
  }

  const CameraImage& camera_;
  int camera_index_;
  const RegisterOptions& options_;
  ingest::GridBounds places_;
  int side_px_ = 0;
};

/// What a thread keeps.
struct Worker {
  std::unique_ptr<nav::MapSource> map;
  std::vector<nav::Registrar> registrars;  ///< by matcher
  nav::Registration found;

  Worker(const OpenMap& open_map, const RegisterOptions& o) : map(open_map()) {
    for (const MatcherChoice& matcher : o.matchers) {
      nav::RegistrationOptions options;
      options.method = matcher.method;
      options.gate = o.gate;
      options.rim_px = o.rim_px;
      registrars.emplace_back(*map, options);
    }
  }
};

}  // namespace

void check(const RegisterOptions& o) {
  const auto require = [](bool sound, const char* option, double given, const char* expected) {
    if (!sound) throw Error(ExitCode::kUsage, fmt::format("{} {}: expected {}", option, given, expected));
  };
  const auto positive = [](double v) { return std::isfinite(v) && v > 0; };
  require(positive(o.template_m), "--template-m", o.template_m, "metres, more than 0");
  require(positive(o.search_m), "--search-m", o.search_m, "metres, more than 0");
  require(positive(o.hit_m), "--hit-m", o.hit_m, "metres, more than 0");
  require(o.samples > 0 && o.samples <= 1'000'000, "--samples", o.samples, "1 to 1000000");
  require(o.seeds > 0 && o.seeds <= 1000, "--seeds", o.seeds, "1 to 1000");
  require(o.rim_px >= 0 && o.rim_px <= 256, "--rim-px", o.rim_px, "0 to 256 pixels");
  require(o.rotation_sigma_rad >= 0 && o.rotation_sigma_rad <= std::numbers::pi / 4, "--rotate-deg",
          o.rotation_sigma_rad * 180 / std::numbers::pi, "0 to 45 degrees");
  require(o.scale_sigma >= 0 && o.scale_sigma <= 0.3, "--scale", o.scale_sigma, "0 to 0.3");
}

CameraTrials register_camera(const CameraImage& camera, int camera_index, const MapFrame& frame,
                             const OpenMap& open_map, const RegisterOptions& o) {
  check(o);
  const Sampler sampler(camera, camera_index, frame, o);
  CameraTrials out{camera.name(), {}};
  for (const MatcherChoice& matcher : o.matchers)
    out.matchers.push_back({matcher, std::vector<Trial>(size_t(o.samples) * size_t(o.seeds))});
  tbb::enumerable_thread_specific<Worker> workers([&] { return Worker(open_map, o); });
  tbb::task_arena arena(o.threads > 0 ? o.threads : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(tbb::blocked_range<int>(0, o.samples * o.seeds), [&](const tbb::blocked_range<int>& range) {
      Worker& worker = workers.local();
      Question question;
      features::GridImage patch;
      for (int i = range.begin(); i < range.end(); ++i) {
        sampler.draw(i / o.samples, i % o.samples, *worker.map, question, patch);
        for (size_t m = 0; m < out.matchers.size(); ++m)
          out.matchers[m].trials[size_t(i)] = answer(worker.registrars[m], patch, question, worker.found);
      }
    });
  });
  return out;
}

}  // namespace landfix::eval
