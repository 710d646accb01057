// landfix export navigability: where a map can be trusted, as files for GIS programs and for the eye.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "builder/error.h"
#include "tools/common/map_age.h"
#include "tools/common/navigability_file.h"
#include "tools/common/open_pack.h"
#include "tools/landfix/commands.h"

namespace landfix::tools {
namespace {

struct Arguments {
  std::string pack, output, footprint, matcher = "auto", date;
  std::vector<std::string> keys;
  bool json = false;
};

enum class Format { kRaster, kSquares, kPicture };

Format format_of(const std::string& output) {
  const std::string extension = std::filesystem::path(output).extension().string();
  if (extension == ".tif" || extension == ".tiff") return Format::kRaster;
  if (extension == ".gpkg") return Format::kSquares;
  if (extension == ".png") return Format::kPicture;
  throw Error(ExitCode::kUsage,
              output + ": the name must end in .tif (a pixel per node), .gpkg (a square per node) or .png (a picture)");
}

tiles::Footprint footprint_of(const Arguments& a, const Pack& pack) {
  const std::vector<tiles::Footprint> judged = footprints_of(pack);
  if (a.footprint.empty()) return judged.empty() ? tiles::Footprint() : judged.front();
  const std::optional<tiles::Footprint> asked = tiles::footprint_named(a.footprint);
  if (!asked)
    throw Error(ExitCode::kUsage,
                fmt::format("--footprint {}: expected VIEW/SEARCH in metres, such as 160/320", a.footprint));
  return *asked;
}

void run(const Arguments& a) {
  const Format format = format_of(a.output);
  const std::optional<int> day = days_of(a.date);
  if (!a.date.empty() && !day)
    throw Error(ExitCode::kUsage, fmt::format("--date {}: expected a day as 2018-07-16", a.date));
  const Pack pack = open_pack(a.pack, a.keys);
  const NavigabilityMap map(pack, footprint_of(a, pack), a.pack);
  const NavigabilityView view{pack, map, *finder_named(a.matcher), day};
  const std::vector<JudgedNode> nodes = nodes_of(view, a.pack);
  if (nodes.empty())
    throw Error(ExitCode::kNoData,
                fmt::format("{}: the map does not say how well {} does; take another --matcher", a.pack, a.matcher));
  switch (format) {
    case Format::kRaster:
      write_navigability_raster(a.output, view, nodes);
      break;
    case Format::kSquares:
      write_navigability_squares(a.output, view, nodes);
      break;
    case Format::kPicture:
      write_navigability_picture(a.output, view, nodes, a.pack);
      break;
  }
  const tiles::Footprint& f = map.footprint();
  if (a.json)
    fmt::print("{}\n", nlohmann::ordered_json{{"output", a.output},
                                              {"template_m", f.template_m},
                                              {"search_m", f.search_m},
                                              {"matcher", a.matcher},
                                              {"nodes", nodes.size()}}
                           .dump(2));
  else
    fmt::print("{}: {} nodes of {:g} m, view {:g} m, up to {:g} m off\n", a.output, nodes.size(),
               map.spacing_m(), f.template_m, f.search_m);
}

}  // namespace

void add_export_navigability(CLI::App& export_command) {
  auto arguments = std::make_shared<Arguments>();
  Arguments& a = *arguments;
  CLI::App* c = export_command.add_subcommand("navigability", "Write where a pack can be navigated by");
  c->add_option("pack", a.pack, "the pack, built with --navigability")->required();
  c->add_option("-o,--output", a.output,
                ".tif: cloud-optimised GeoTIFF, a pixel per node, with a .qml beside it; .gpkg: a square per node with "
                "reasons in words; .png: a picture over the map")
      ->required();
  c->add_option("--footprint", a.footprint,
                "VIEW/SEARCH in metres: which of those that the pack was judged for (default: the smallest)");
  c->add_option("--matcher", a.matcher, "whose chances are shown: auto, orientation, gray, edge or contour")
      ->check(CLI::IsMember({"auto", "orientation", "gray", "edge", "contour"}))
      ->capture_default_str();
  c->add_option("--date", a.date, "day of the flight: chances fall with the age of the map (default: as in the pack)")
      ->type_name("2018-07-16");
  c->add_option("--key", a.keys, "trusted public key file")->allow_extra_args(false);
  c->add_flag("--json", a.json, "print JSON");
  c->footer(
      "Examples:\n"
      "  landfix export navigability area.lfpack -o navigability.png\n"
      "  landfix export navigability area.lfpack -o navigability.tif --footprint 320/320\n"
      "  landfix export navigability area.lfpack -o navigability.gpkg --date 2026-06-01\n\n"
      "QGIS takes the style with its legend from the .gpkg, or from the .qml beside the .tif.");
  c->callback([arguments] { run(*arguments); });
}

}  // namespace landfix::tools
