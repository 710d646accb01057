// Making all raster layers of imagery of several dates: how fast, and how large they become.
#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdlib>
#include <random>

#include "builder/build.h"
#include "builder/error.h"
#include "builder/layers/registry.h"
#include "tools/bench/sections.h"
#include "tools/bench/timing.h"
#include "tools/common/open_pack.h"

namespace landfix::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kSide_px = 4096;
constexpr int kThreads = 2;
constexpr double kMegapixelsPerSecond = 8;  ///< of every date
constexpr double kOrientationMbPerKm2 = 0.75, kStandardMbPerKm2 = 1;

constexpr int kWindow_px = 512;
constexpr int kWindows = 200;

/// Seconds of all cores that this program has had.
double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

BuildSummary build_pack(BuildOptions options, const fs::path& pack) {
  say("timing landfix build -> " + pack.string());
  Progress silent;
  options.output = pack;
  options.force = true;
  options.threads = kThreads;
  return landfix::build(options, silent);
}

double mb_per_km2(double bytes, const BuildSummary& summary) { return bytes / 1e6 / summary.area_km2; }

const LayerSummary& layer_of(const BuildSummary& summary, const std::string& name) {
  const auto found = std::ranges::find(summary.layers, name, &LayerSummary::name);
  if (found == summary.layers.end() || found->levels.empty())
    throw Error(ExitCode::kInternal, "the build made no layer " + name);
  return *found;
}

/// The drawn world of several dates, repeated to a square.
BuildOptions drawn(const Options& o, const Seasons& seasons) {
  BuildOptions options;
  for (const Seasons::Image& image : seasons.images) {
    const fs::path vrt = o.work / "seasons" / (image.file.parent_path().filename().string() + ".vrt");
    repeat(image.file, kSide_px, kSide_px, vrt);
    options.images.push_back({.path = vrt, .date = image.date});
  }
  return options;
}

void measure_all(BuildOptions images, const fs::path& pack, Report& report) {
  for (const layers::RasterLayer* layer : layers::registry())
    if (layer->info().input == layers::Input::kImages) images.layers.push_back(layer->info().name);
  const double before = processor_seconds();
  const BuildSummary all = build_pack(images, pack);
  const double on_two_cores_s = (processor_seconds() - before) / kThreads;
  const double dates = double(images.images.size()), megapixels = all.megapixels * dates;
  const std::string what = fmt::format("all raster layers, {:.1f} Mpx x {:.0f} dates", all.megapixels, dates);
  report.at_least(what, megapixels / all.seconds, "Mpx/s", kMegapixelsPerSecond);
  report.measured(what + ", by processor time", megapixels / on_two_cores_s, "Mpx/s");
  report.at_most("orientation, mapped raw: base level",
                 mb_per_km2(double(layer_of(all, "orientation").levels[0].bytes), all), "MB/km2", kOrientationMbPerKm2);
}

/// Reading of bit planes: windows at any pixel from a prepared layer, and what a compressed tile takes to prepare.
void measure_reading(const fs::path& raw, const fs::path& compressed, Report& report) {
  const Pack flown = tools::open_pack(raw.string()), stored = tools::open_pack(compressed.string());
  const uint32_t planes = *flown.find_layer("orientation"), coded = *stored.find_layer("orientation");
  const lf_info map = flown.info();
  const auto whole = [&map](const Pack& pack, uint32_t layer) {
    return *pack.box(layer, map.west_m, map.south_m, map.east_m, map.north_m, 1);
  };
  const double seconds = processor_time_of([&] { tools::check(stored.prepare(whole(stored, coded)), "prepare"); });
  report.measured("orientation, context: preparing a tile", 1e3 * seconds / stored.level(coded, 0)->tile_count, "ms");

  tools::check(flown.prepare(whole(flown, planes)), "prepare");
  const size_t row_words = kWindow_px / 64 + 1, plane_words = row_words * (kWindow_px + 1);
  std::vector<uint64_t> words(plane_words * flown.layer(planes)->channels);
  std::mt19937_64 random(3);
  const auto between = [&](double low, double high) { return low + (high - low) * double(random() >> 11) * 0x1p-53; };
  std::vector<double> times;
  for (int i = 0; i < kWindows; ++i) {
    const double west = std::floor(between(map.west_m, map.east_m - kWindow_px)),
                 south = std::floor(between(map.south_m, map.north_m - kWindow_px));
    times.push_back(processor_time_of([&] {
      const auto region = flown.box(planes, west, south, west + kWindow_px, south + kWindow_px, 1);
      tools::check(flown.read_bits(*region, words, row_words, plane_words), "window");
    }));
  }
  report.measured(fmt::format("orientation, raw: window of {0}x{0} px, median", kWindow_px), 1e3 * median(times), "ms");
}

/// What the set `standard` takes, as a whole and by layer.
void measure_standard(const std::string& name, BuildOptions images, bool has_target, const fs::path& pack,
                      Report& report) {
  images.set = "standard";
  images.gsd_m = 1;
  const BuildSummary summary = build_pack(images, pack);
  for (const LayerSummary& layer : summary.layers) {
    double bytes = 0;
    for (const LevelSummary& level : layer.levels) bytes += double(level.bytes);
    if (bytes > 0)
      report.measured(fmt::format("{}, set standard: {} ({})", name, layer.name, name_of(layer.codec)),
                      mb_per_km2(bytes, summary), "MB/km2");
  }
  const std::string row = fmt::format("{}, set standard: the pack, {:.1f} km2", name, summary.area_km2);
  const double size = mb_per_km2(double(summary.file_bytes), summary);
  if (has_target)
    report.at_most(row, size, "MB/km2", kStandardMbPerKm2);
  else
    report.measured(row, size, "MB/km2");
}

}  // namespace

void bench_layers(const Data&, const Options& o, Report& report) {
  report.section("layers",
                 fmt::format("the builder with {1} threads on a drawn world at three dates, {0}x{0} px of 1 m, RGB, "
                             "input in the page cache; sizes over the area of the image, all levels at and above 1 m",
                             kSide_px, kThreads));
  const fs::path raw = o.work / "timed.lfpack", standard = o.work / "timed_standard.lfpack";
  const BuildOptions images = drawn(o, make_seasons(o));
  measure_all(images, raw, report);
  const char* folder = std::getenv("LANDFIX_DATA");
  const fs::path real = fs::path(folder ? folder : "") / "hura_il/hura_0.5m_13km2.tif";
  const bool has_real = folder && fs::exists(real);
  if (has_real) {
    BuildOptions hura;
    hura.images.push_back({.path = real});
    measure_standard("hura_il", hura, true, standard, report);
  }
  measure_standard("drawn", images, !has_real, standard, report);
  measure_reading(raw, standard, report);
  fs::remove(raw);
  fs::remove(standard);
}

}  // namespace landfix::bench
