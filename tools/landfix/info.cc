// landfix info: what a pack holds, for people and as JSON.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>

#include "tiles/geodesy.h"
#include "tools/common/keys.h"
#include "tools/common/manifest_json.h"
#include "tools/common/open_pack.h"
#include "tools/landfix/commands.h"

namespace landfix::tools {
namespace {

using nlohmann::ordered_json;

struct InfoOptions {
  std::string pack;
  std::vector<std::string> keys;
  bool json = false;
};

std::string or_unknown(const ordered_json& value) { return value.is_null() ? "unknown" : value.get<std::string>(); }

void print_sources(const ordered_json& sources) {
  fmt::print("\nsources\n");
  for (const auto& s : sources) {
    const double gsd_m = s["gsd_m"].get<double>();  // 0: no pixels
    fmt::print("  {}  {}, {}date {}, {}\n", s["name"].get<std::string>(), s["role"].get<std::string>(),
               gsd_m > 0 ? fmt::format("{:.3g} m, ", gsd_m) : "", or_unknown(s["capture_date"]), or_unknown(s["crs"]));
    if (!s["vertical_datum"].is_null()) fmt::print("    heights: {}\n", s["vertical_datum"].get<std::string>());
    if (!s["licence"].is_null()) fmt::print("    licence: {}\n", s["licence"].get<std::string>());
    if (!s["attribution"].is_null()) fmt::print("    attribution: {}\n", s["attribution"].get<std::string>());
    fmt::print("    sha256 {}\n", s["sha256"].get<std::string>());
  }
}

void print_epochs(const ordered_json& epochs) {
  if (epochs.empty()) return;
  fmt::print("\ndates, newest first\n");
  for (const auto& e : epochs)
    fmt::print("  {}  {} image{}\n", e["date"].is_null() ? "undated   " : e["date"].get<std::string>(),
               e["sources"].size(), e["sources"].size() == 1 ? "" : "s");
}

// "landmarks    building 412, field 80, ..."; "roads        12.3 km, 45 intersections".
void print_features(const ordered_json& layer) {
  const ordered_json& features = layer["features"];
  std::vector<std::string> parts;
  if (features.is_null())
    parts = {"damaged"};
  else if (features.contains("roads_km"))
    parts = {fmt::format("{:.1f} km", features["roads_km"].get<double>()),
             fmt::format("{} intersections", features["intersections"].get<size_t>())};
  else
    for (const auto& [name, count] : features.items()) parts.push_back(fmt::format("{} {}", name, count.get<size_t>()));
  fmt::print("  {:<12} {}\n", layer["name"].get<std::string>(), fmt::join(parts, ", "));
}

void print_layers(const ordered_json& layers) {
  fmt::print("\nlayers\n");
  for (const auto& l : layers) {
    if (l.contains("features"))
      print_features(l);
    else
      fmt::print("  {:<12} {}, {} channel{}\n", l["name"].get<std::string>(), l["pixel_type"].get<std::string>(),
                 l["channels"].get<int>(), l["channels"] == 1 ? "" : "s");
    for (const auto& level : l["levels"])
      fmt::print("    level {:>3}  {:>8.5g} m  {:>7} tiles\n", level["level"].get<int>(), level["gsd_m"].get<double>(),
                 level["tiles"].get<int>());
  }
}

void print_info(const std::string& path, const ordered_json& m) {
  const auto& b = m["bounds"];
  const double width = b["east_m"].get<double>() - b["west_m"].get<double>();
  const double height = b["north_m"].get<double>() - b["south_m"].get<double>();
  fmt::print("{}\n", path);
  fmt::print("  format {}, {:.1f} MB, {}\n", m["format"].get<std::string>(), m["file_length"].get<double>() / 1e6,
             m["builder"].get<std::string>());
  fmt::print("  root {}\n", m["root"].get<std::string>());
  fmt::print("  signed by {}\n", m["public_key"].is_null() ? "nobody" : m["public_key"].get<std::string>());
  fmt::print("  grid {} (EPSG:{}), {:.0f} x {:.0f} m\n", m["zone"].get<std::string>(), m["epsg"].get<int>(), width,
             height);
  fmt::print("  easting {:.2f} to {:.2f}, northing {:.2f} to {:.2f}\n", b["west_m"].get<double>(),
             b["east_m"].get<double>(), b["south_m"].get<double>(), b["north_m"].get<double>());
  fmt::print("  longitude {:.6f} to {:.6f}, latitude {:.6f} to {:.6f}\n", b["west_deg"].get<double>(),
             b["east_deg"].get<double>(), b["south_deg"].get<double>(), b["north_deg"].get<double>());
  if (m["has_heights"].get<bool>())
    fmt::print("  heights: in the pack; a plane at {:.1f} m above the ellipsoid where they lack\n",
               m["plane_height_m"].get<double>());
  else
    fmt::print("  heights: NONE; the runtime assumes a plane at {:.1f} m above the ellipsoid\n",
               m["plane_height_m"].get<double>());
  if (m["georegistration_error_m"].is_null())
    fmt::print("  georegistration error: not stated\n");
  else
    fmt::print("  georegistration error: {:.2f} m (1 sigma per axis)\n", m["georegistration_error_m"].get<double>());
  print_layers(m["layers"]);
  print_sources(m["sources"]);
  print_epochs(m["epochs"]);
  fmt::print("\nparameters\n");
  for (const auto& [name, value] : m["parameters"].items()) fmt::print("  {} = {}\n", name, value.get<std::string>());
}

}  // namespace

void add_info(CLI::App& app) {
  auto o = std::make_shared<InfoOptions>();
  CLI::App* c = app.add_subcommand("info", "Show what a pack holds: area, layers, sources with dates and licences");
  c->add_option("pack", o->pack, "the pack")->required();
  c->add_option("--key", o->keys, "trusted public key file; refuse a pack that none of the given keys signed")
      ->allow_extra_args(false);
  c->add_flag("--json", o->json, "print JSON");
  c->footer("Examples:\n  landfix info area.lfpack\n  landfix info area.lfpack --json | jq .layers");
  c->callback([o] {
    const Pack pack = open_pack(o->pack, o->keys);
    const ordered_json manifest = manifest_json(pack);
    if (o->json)
      fmt::print("{}\n", manifest.dump(2));
    else
      print_info(o->pack, manifest);
  });
}

}  // namespace landfix::tools
