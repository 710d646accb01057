// landfix export: landmarks and roads of a pack as a file for GIS programs, and its subcommands.
#include <fmt/format.h>

#include <array>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/common/open_pack.h"
#include "tools/common/vector_file.h"
#include "tools/landfix/commands.h"

namespace landfix::tools {
namespace {

struct ExportOptions {
  std::string pack, layer, output;
  std::vector<std::string> keys;
  bool json = false;
};

void export_layer(const ExportOptions& o) {
  const Pack pack = open_pack(o.pack, o.keys);
  const size_t features = write_vector_file(o.output, pack, o.layer, o.pack);
  if (o.json)
    fmt::print("{}\n",
               nlohmann::ordered_json{{"layer", o.layer}, {"output", o.output}, {"features", features}}.dump(2));
  else
    fmt::print("{}: {} {}\n", o.output, features, o.layer);
}

}  // namespace

void add_export(CLI::App& app) {
  auto o = std::make_shared<ExportOptions>();
  CLI::App* c = app.add_subcommand("export", "Write landmarks, roads or navigability of a pack as files");
  // Required, but not where a subcommand has options of its own.
  const std::array<CLI::Option*, 3> required = {
      c->add_option("pack", o->pack, "the pack"),
      c->add_option("--layer", o->layer, "landmarks, roads or intersections"),
      c->add_option("-o,--output", o->output,
                    ".gpkg: on the pack's grid; .geojson: in degrees, with a .qml beside it")};
  c->add_option("--key", o->keys, "trusted public key file")->allow_extra_args(false);
  c->add_flag("--json", o->json, "print JSON");
  c->footer(
      "Examples:\n"
      "  landfix export area.lfpack --layer landmarks -o landmarks.gpkg\n"
      "  landfix export area.lfpack --layer roads -o roads.geojson\n"
      "  landfix export navigability area.lfpack -o navigability.png\n\n"
      "QGIS takes the style from the file, or from the .qml beside it.");
  add_export_navigability(*c);
  c->callback([o, c, required] {
    if (!c->get_subcommands().empty()) return;
    for (const CLI::Option* option : required)
      if (option->empty()) throw CLI::RequiredError(option->get_name());
    export_layer(*o);
  });
}

}  // namespace landfix::tools
