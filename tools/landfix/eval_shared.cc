#include "tools/landfix/eval_shared.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "builder/error.h"
#include "runtime/nav/pack_map.h"
#include "tools/common/files.h"
#include "tools/common/manifest_json.h"
#include "tools/common/open_pack.h"

namespace landfix::tools {

eval::MapFrame frame_of(const Pack& pack, const std::string& path) {
  const lf_info info = pack.info();
  const std::pair<double, double> range = eval::raster_levels(nav::PackMap(pack));
  if (range.first == 0)
    throw Error(ExitCode::kNoData, path +
                                       ": the pack has none of the layers gray, edge, contour and orientation; build "
                                       "it with one of them");
  return {path, zone_of(pack), {info.west_m, info.south_m, info.east_m, info.north_m}, range};
}

void write_results(const EvalOutput& o, const std::string& text, const nlohmann::ordered_json& json) {
  if (o.json_file == "-") {
    fmt::print("{}\n", json.dump(2));
    return;
  }
  fmt::print("{}", text);
  if (!o.json_file.empty()) write_text(o.json_file, json.dump(2) + "\n");
}

void add_sampling(CLI::App& command, eval::RegisterOptions& o) {
  command.add_option("--template-m", o.template_m, "Side of the templates, m")->capture_default_str();
  command.add_option("--search-m", o.search_m, "Search to every side of the truth, m")->capture_default_str();
  command.add_option("--hit-m", o.hit_m, "An answer this near to the truth is true, m")->capture_default_str();
  command.add_option("--samples", o.samples, "Templates per image and seed")->capture_default_str();
  command.add_option("--seed", o.seed, "First seed")->capture_default_str();
  command.add_option("--seeds", o.seeds, "Sets of samples, one per seed")->capture_default_str();
}

void add_threads(CLI::App& command, int& threads) {
  command.add_option("--threads", threads, "Threads; 0 for all cores")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
}

void add_output(CLI::App& command, EvalOutput& o) {
  command
      .add_flag("--json{-}", o.json_file,
                "All figures as JSON instead of the table; with a file they go there, besides the table")
      ->type_name("FILE");
}

void add_samples(CLI::App& command, EvalOutput& o) {
  command.add_option("--samples-csv", o.samples_csv, "Write a line per sample to this file")->type_name("FILE");
}

}  // namespace landfix::tools
