// What a vehicle asks in passing: opening, heights, tiles, regions, coordinates.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <fstream>
#include <random>

#include "tools/bench/sections.h"
#include "tools/bench/timing.h"
#include "tools/common/open_pack.h"

namespace landfix::bench {
namespace {

constexpr int kOpenings = 500;
constexpr size_t kQuestions = 1 << 14;  ///< places asked in turn; a power of two

struct Place {
  double east_m, north_m;
};

std::vector<Place> random_places(const lf_info& map) {
  std::mt19937_64 random(7);
  const auto between = [&](double low, double high) { return low + (high - low) * double(random() >> 11) * 0x1p-53; };
  std::vector<Place> places(kQuestions);
  for (Place& p : places)
    p = {between(map.west_m + 600, map.east_m - 600), between(map.south_m + 600, map.north_m - 600)};
  return places;
}

/// Resident bytes of the mappings of a file, as /proc/self/smaps tells.
double resident_bytes(const std::filesystem::path& file) {
  const std::string path = std::filesystem::canonical(file).string();
  std::ifstream smaps("/proc/self/smaps");
  double kilobytes = 0;
  bool inside = false;
  for (std::string line; std::getline(smaps, line);) {
    if (line.find('-') < line.find(':') && line.find('-') < line.find(' ')) inside = line.ends_with(path);
    if (inside && line.starts_with("Rss:")) kilobytes += std::stod(line.substr(4));
  }
  return kilobytes * 1024;
}

/// Collects nanoseconds per question.
class Collect : public benchmark::BenchmarkReporter {
 public:
  explicit Collect(Report& report) : report_(report) {}
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs)
      if (run.aggregate_name == "median") report_.measured(run.run_name.function_name, run.GetAdjustedRealTime(), "ns");
  }

 private:
  Report& report_;
};

/// `ask(place)` for one place after another.
template <typename Ask>
void ask_about(const std::string& name, const std::vector<Place>& places, Ask ask) {
  benchmark::RegisterBenchmark(name.c_str(),
                               [&places, ask](benchmark::State& state) {
                                 size_t i = 0;
                                 for (auto _ : state) benchmark::DoNotOptimize(ask(places[i++ % kQuestions]));
                               })
      ->MinTime(0.1)
      ->Repetitions(5);
}

void prepare_all(const Pack& pack, const char* layer, double gsd_m) {
  const lf_info map = pack.info();
  const Region all = *pack.box(*pack.find_layer(layer), map.west_m, map.south_m, map.east_m, map.north_m, gsd_m);
  tools::check(pack.prepare(all), layer);
}

}  // namespace

void bench_opening(const Data& d, const Options&, Report& report) {
  report.section("opening", fmt::format("lf_open and lf_close, {} times, page cache warm; memory from /proc/self/smaps",
                                        kOpenings));
  std::vector<double> seconds;
  for (int i = 0; i < kOpenings; ++i) seconds.push_back(time_of([&] { tools::open_pack(d.pack.string()); }));
  report.at_most("open: median", median(seconds) * 1e3, "ms", 1);
  report.measured("open: p99", quantile(seconds, 0.99) * 1e3, "ms");
  const Pack pack = tools::open_pack(d.pack.string());
  report.measured("file", double(pack.info().file_length) / 1e6, "MB");
  report.at_most("resident memory of the mapping after opening",
                 100 * resident_bytes(d.pack) / double(pack.info().file_length), "% of file", 1);
}

void bench_lookups(const Data& d, const Options&, Report& report) {
  report.section("lookups",
                 fmt::format("one thread, {} random places in turn, tiles prepared; median of five runs", kQuestions));
  const Pack pack = tools::open_pack(d.pack.string());
  prepare_all(pack, "gray", 1);
  prepare_all(pack, "height", 1);
  const uint32_t gray = *pack.find_layer("gray");
  const std::vector<Place> places = random_places(pack.info());

  const auto tile_of = [](double position_m) { return int32_t(position_m / 256); };
  ask_about("height of the ground", places, [&](const Place& p) { return pack.height(p.east_m, p.north_m)->height_m; });
  ask_about("tile view", places,
            [&](const Place& p) { return pack.tile(gray, 0, tile_of(p.east_m), tile_of(p.north_m))->pixels; });
  ask_about("region of an ellipse", places, [&](const Place& p) {
    return pack.region(gray, {p.east_m, p.north_m, 400, 100, 900, 3}, 1)->width;
  });
  ask_about("grid from geodetic (50 N, 15 E)", places,
            [&](const Place& p) { return pack.grid_from_geodetic(0.85 + p.east_m * 1e-9, 0.262)->east_m; });
  ask_about("geodetic from grid", places,
            [&](const Place& p) { return pack.geodetic_from_grid(p.east_m, p.north_m)->latitude_rad; });
  Collect collect(report);
  benchmark::RunSpecifiedBenchmarks(&collect);
}

}  // namespace landfix::bench
