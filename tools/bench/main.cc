// landfix_bench: compares packs with what a user would otherwise use, in one run, and writes bench.json.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>

#include "builder/error.h"
#include "tools/bench/sections.h"
#include "tools/bench/timing.h"

namespace {

using namespace landfix::bench;

constexpr const char* kFooter =
    "Targets are printed beside the values, with \"met\" or \"missed\". A missed target does not fail, a result that "
    "differs from the\n"
    "peer's does (exit code 1). The first run makes its data in the work folder, about 1.2 GB; later runs use them "
    "again.";

struct Section {
  std::string name;
  void (*run)(const Data&, const Options&, Report&);
  bool needs_data = true;
};
const Section kSections[] = {{"opening", bench_opening},        {"windows", bench_windows},
                             {"lookups", bench_lookups},        {"correlation", bench_correlation},
                             {"kernels", bench_kernels, false}, {"registration", bench_registration, false},
                             {"layers", bench_layers, false},   {"landmarks", bench_landmarks, false},
                             {"building", bench_build_time}};

}  // namespace

int main(int argc, char** argv) {
  Options o;
  CLI::App app{
      "Windows, lookups, correlation, kernels and builds against GDAL, gdal2tiles.py and OpenCV; registration and "
      "layers against their targets."};
  app.add_option("-o,--output", o.output, "Results as JSON")->capture_default_str();
  app.add_option("--work", o.work, "Folder for data and logs; kept")->capture_default_str();
  app.add_option("--landfix", o.landfix, "The program to time")->capture_default_str();
  app.add_option("--size", o.size_px, "Side of the image of windows and lookups, pixels of 1 m")
      ->check(CLI::Range(2048, 65536))
      ->capture_default_str();
  app.add_option("--build-size", o.build_size_px, "Side of the image that is built, pixels of 1 m")
      ->check(CLI::Range(512, 65536))
      ->capture_default_str();
  app.add_option("--windows", o.windows, "Windows to read")->check(CLI::Range(10, 100000))->capture_default_str();
  app.add_option("--seed", o.seed, "Where the windows lie")->capture_default_str();
  std::vector<std::string> only, names;
  for (const Section& section : kSections) names.push_back(section.name);
  app.add_option("--only", only, "Sections to run, with commas; all if not given")
      ->delimiter(',')
      ->check(CLI::IsMember(names));
  app.footer(kFooter);
  CLI11_PARSE(app, argc, argv);
  try {
    const Clock::time_point start = Clock::now();
    Report report;
    const auto chosen = [&](const Section& s) { return only.empty() || std::ranges::count(only, s.name) > 0; };
    const bool needs_data = std::ranges::any_of(kSections, [&](const Section& s) { return chosen(s) && s.needs_data; });
    const Data data = needs_data ? make_data(o) : Data{};
    describe_setup(o, report);
    for (const Section& section : kSections) {
      if (chosen(section)) section.run(data, o, report);
    }
    report.summarize();
    report.write(o.output);
    fmt::print("{:.0f} s; results in {}\n", seconds_since(start), o.output.string());
    return report.results_agree() ? 0 : int(landfix::ExitCode::kInternal);
  } catch (const landfix::Error& e) {
    fmt::print(stderr, "landfix_bench: {}\n", e.what());
    return int(e.code());
  } catch (const std::exception& e) {
    fmt::print(stderr, "landfix_bench: {}\n", e.what());
    return int(landfix::ExitCode::kInternal);
  }
}
