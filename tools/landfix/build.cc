// landfix build: images and heights in, a map pack out.
#include "builder/build.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <csignal>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "builder/error.h"
#include "builder/ingest/zone.h"
#include "builder/layer_set.h"
#include "builder/layers/registry.h"
#include "tiles/grid.h"
#include "tools/landfix/commands.h"

namespace landfix::tools {
namespace {

using nlohmann::ordered_json;

constexpr char kExamples[] = R"(
Examples:
  landfix build town.tif -o town.lfpack
      one image, no heights: the runtime assumes a plane; --plane-height 412.5 says where
  landfix build west.tif east.tif --dem dtm.tif --dem-datum egm96 -o area.lfpack
      overlapping images (the first listed wins) with terrain above the EGM96 geoid
  landfix build 2009.tif 2018.tif --date 2009.tif=2009-08-18 --date 2018.tif=2018-07-16 -o farm.lfpack
      two capture dates: the newest that has data is shown
  landfix build cir.tif --bands cir.tif=nir,red,green --bbox 34.92,31.29,34.97,31.32 --gsd 0.5 -o part.lfpack
  landfix build town.tif --codec gray=jpeg --jpeg-quality 85 -o part.lfpack
  landfix build 2009.tif 2018.tif --date 2009.tif=2009-08-18 --date 2018.tif=2018-07-16 --set standard -o small.lfpack
      about 1 MB/km2 at 1 m: what matching in flight needs, compressed; the runtime decodes it before the flight
  landfix build 2009.tif 2018.tif --date 2009.tif=2009-08-18 --date 2018.tif=2018-07-16 --align -o farm.lfpack
      the dates lie a constant shift apart (the build reports it): take it out before they are fused
  landfix build town.tif --vectors buildings.gpkg:footprints=building roads.gpkg -o town.lfpack
      with the landmarks and roads that OpenStreetMap or an agency knows

Beside an image, FILE.json may say {"date": "2018-07-16", "licence": "...", "attribution": "...",
"bands": "red,green,blue,nir", "georegistration_error_m": 1.5}; the command line goes before it.
The work in progress lies in OUTPUT.build. After Ctrl-C, a kill or a full disk, the same command continues there.)";

std::atomic<bool> stop_requested = false;

struct CommandLine {
  std::vector<std::string> images, dates, bands, nodata, codecs, footprints, layers, vectors;
  std::string dem, dem_datum, zone, output;
  double gsd_m = 0, georegistration_error_m = -1;
  bool json = false;
  BuildOptions options;
};

// "NAME=VALUE" of an option.
std::pair<std::string, std::string> split(const std::string& option, const std::string& text) {
  const size_t at = text.rfind('=');
  if (at == std::string::npos || at == 0 || at + 1 == text.size())
    throw Error(ExitCode::kUsage, fmt::format("{} {}: expected NAME=VALUE", option, text));
  return {text.substr(0, at), text.substr(at + 1)};
}

// The image that FILE of "FILE=VALUE" means: by its path as given, else by its name without the folder.
ingest::SourceOptions& image_named(std::vector<ingest::SourceOptions>& images, const std::string& option,
                                   const std::string& file) {
  ingest::SourceOptions* found = nullptr;
  for (ingest::SourceOptions& image : images) {
    if (image.path == file) return image;
    if (std::filesystem::path(image.path).filename() != file) continue;
    if (found)
      throw Error(ExitCode::kUsage, fmt::format("{} {}: several images have this name; give the path", option, file));
    found = &image;
  }
  if (!found) throw Error(ExitCode::kUsage, fmt::format("{} {}: none of the images has this name", option, file));
  return *found;
}

double number_of(const std::string& option, const std::string& text) {
  double value;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc() || end != text.data() + text.size())
    throw Error(ExitCode::kUsage, fmt::format("{} {}: expected a number", option, text));
  return value;
}

tiles::Codec codec_of(const std::string& layer, const std::string& name) {
  for (const tiles::Codec codec :
       {tiles::Codec::kRaw, tiles::Codec::kJpeg, tiles::Codec::kZstd, tiles::Codec::kContext})
    if (name == name_of(codec)) return codec;
  throw Error(ExitCode::kUsage, fmt::format("--codec {}={}: expected raw, jpeg, zstd or context", layer, name));
}

// "160/320": a view of 160 m, searched for up to 320 m to every side; "standard": three views, each with two radii.
void add_footprints(const std::string& text, std::vector<tiles::Footprint>& out) {
  if (text == "standard") {
    for (const double view_m : {160.0, 240.0, 320.0})
      for (const double search_m : {160.0, 320.0}) out.push_back({view_m, search_m});
    return;
  }
  const std::optional<tiles::Footprint> footprint = tiles::footprint_named(text);
  if (!footprint)
    throw Error(ExitCode::kUsage,
                fmt::format("--navigability {}: expected VIEW/SEARCH in metres, such as 160/320, or standard", text));
  out.push_back(*footprint);
}

BuildOptions options_of(const CommandLine& line) {
  BuildOptions options = line.options;
  for (const std::string& path : line.images) options.images.push_back({path, {}, {}, {}});
  for (const std::string& text : line.dates) {
    const auto [file, date] = split("--date", text);
    image_named(options.images, "--date", file).date = date;
  }
  for (const std::string& text : line.bands) {
    const auto [file, bands] = split("--bands", text);
    image_named(options.images, "--bands", file).bands = bands;
  }
  for (const std::string& text : line.nodata) {
    const auto [file, value] = split("--nodata", text);
    image_named(options.images, "--nodata", file).nodata = number_of("--nodata", value);
  }
  for (const std::string& text : line.codecs) {
    const auto [layer, codec] = split("--codec", text);
    options.codecs[layer] = codec_of(layer, codec);
  }
  if (!line.dem.empty()) options.elevation = ingest::SourceOptions{line.dem, {}, {}, line.dem_datum};
  if (line.dem.empty() && !line.dem_datum.empty())
    throw Error(ExitCode::kUsage, "--dem-datum: there is no --dem to go with it");
  if (!line.zone.empty()) options.zone = ingest::parse_zone(line.zone);
  if (line.gsd_m != 0) options.gsd_m = line.gsd_m;
  if (line.georegistration_error_m >= 0) options.georegistration_error_m = line.georegistration_error_m;
  for (const std::string& text : line.vectors) options.vectors.push_back(landmarks::parse_input(text));
  for (const std::string& text : line.footprints) add_footprints(text, options.footprints);
  options.layers = line.layers;
  options.output = line.output;
  options.stop = &stop_requested;
  return options;
}

ordered_json json_of(const std::string& output, const BuildSummary& s) {
  ordered_json out = {{"pack", output},
                      {"bytes", s.file_bytes},
                      {"zone", ingest::zone_text(s.zone)},
                      {"gsd_m", s.gsd_m},
                      {"area_km2", s.area_km2},
                      {"mb_per_km2", double(s.file_bytes) / 1e6 / s.area_km2},
                      {"tiles", s.tiles},
                      {"stored_tiles", s.stored_tiles},
                      {"seconds", s.seconds},
                      {"megapixels", s.megapixels},
                      {"megapixels_per_second", s.megapixels / s.seconds},
                      {"resumed_jobs", s.resumed_jobs},
                      {"warnings", s.warnings},
                      {"shifts", ordered_json::array()},
                      {"features", s.features},
                      {"layers", ordered_json::array()}};
  for (const ShiftSummary& shift : s.shifts) {
    const ingest::Alignment& a = shift.alignment;
    out["shifts"].push_back({{"image", shift.image},
                             {"measured", a.measured},
                             {"east_m", a.east_m},
                             {"north_m", a.north_m},
                             {"windows", a.windows},
                             {"agreeing", a.agreeing},
                             {"spread_m", a.spread_m},
                             {"removed", shift.removed}});
  }
  for (const LayerSummary& layer : s.layers) {
    ordered_json levels = ordered_json::array();
    for (const LevelSummary& level : layer.levels)
      levels.push_back({{"level", level.level},
                        {"gsd_m", tiles::gsd_of(level.level)},
                        {"tiles", level.tiles},
                        {"bytes", level.bytes}});
    out["layers"].push_back({{"name", layer.name}, {"codec", name_of(layer.codec)}, {"levels", levels}});
  }
  return out;
}

std::string size_text(uint64_t bytes) {
  return bytes < 100'000 ? fmt::format("{:.1f} kB", double(bytes) / 1e3)
                         : fmt::format("{:.1f} MB", double(bytes) / 1e6);
}

// "0.25 to 8", or the only one.
std::string levels_text(const LayerSummary& layer) {
  const double finest_m = tiles::gsd_of(layer.levels.front().level),
               coarsest_m = tiles::gsd_of(layer.levels.back().level);
  return finest_m == coarsest_m ? fmt::format("{}", finest_m) : fmt::format("{} to {}", finest_m, coarsest_m);
}

void print(const std::string& output, const BuildSummary& s) {
  fmt::print("{}: {:.1f} MB, {:.2f} km2, {:.2f} MB/km2, zone {}, {} m per pixel\n", output, double(s.file_bytes) / 1e6,
             s.area_km2, double(s.file_bytes) / 1e6 / s.area_km2, ingest::zone_text(s.zone), s.gsd_m);
  size_t longest = 0;
  for (const LayerSummary& layer : s.layers) longest = std::max(longest, layer.name.size());
  for (const LayerSummary& layer : s.layers) {
    uint64_t tile_count = 0, bytes = 0;
    for (const LevelSummary& level : layer.levels) tile_count += level.tiles, bytes += level.bytes;
    if (layer.levels.empty())
      fmt::print("  {:<{}} {:<7} no data\n", layer.name, longest, name_of(layer.codec));
    else
      fmt::print("  {:<{}} {:<7} {:>8} tiles {:>13}   {} m\n", layer.name, longest, name_of(layer.codec), tile_count,
                 size_text(bytes), levels_text(layer));
  }
  for (const std::string& text : s.features) fmt::print("  {}\n", text);
  if (s.stored_tiles < s.tiles)
    fmt::print("  {} of {} tiles equal another and are stored once\n", s.tiles - s.stored_tiles, s.tiles);
  fmt::print("  {:.1f} s, {:.1f} Mpx/s\n", s.seconds, s.megapixels / s.seconds);
}

void run(const CommandLine& line) {
  const BuildOptions options = options_of(line);
  stop_requested = false;
  const auto previous = std::signal(SIGINT, [](int) { stop_requested = true; });
  Progress progress = Progress::to(stderr);
  try {
    const BuildSummary summary = build(options, progress);
    std::signal(SIGINT, previous);
    if (line.json)
      fmt::print("{}\n", json_of(line.output, summary).dump(2));
    else
      print(line.output, summary);
  } catch (const Interrupted& e) {
    // Dies of the signal, as shells expect of a program that was interrupted.
    progress.say(fmt::format("landfix: {}", e.what()));
    std::signal(SIGINT, SIG_DFL);
    std::raise(SIGINT);
  }
}

}  // namespace

void add_build(CLI::App& app) {
  auto line = std::make_shared<CommandLine>();
  CLI::App* command = app.add_subcommand("build", "Make a map pack from georeferenced images and heights");
  command->footer(kExamples);
  command->add_option("image", line->images, "Images in any CRS: 8-bit RGB, RGB + near infrared or gray")->required();
  command->add_option("-o,--output", line->output, "The pack to write")->required();
  command->add_option("--dem", line->dem, "Heights in any CRS");
  command->add_option("--dem-datum", line->dem_datum, "What the heights are above: ellipsoid, egm96 or EPSG:n");
  command->add_option(
      "--vectors", line->vectors,
      fmt::format("FILE[:LAYER][=KIND]: landmarks and roads that are known already, of OpenStreetMap or "
                  "an agency. KIND is one of {} (default: by tags, else by the layer's name)",
                  landmarks::kKindNames));
  command->add_option("--landmark-model", line->options.landmark_model,
                      "What landmarks look like (default: the model that comes with landfix)");
  command->add_option("--road-model", line->options.road_model,
                      "What roads look like (default: the model that comes with landfix)");
  command->add_option("--aoi", line->options.area_file,
                      "Polygons of a vector file: only tiles that they touch are stored");
  command->add_option("--bbox", line->options.bbox, "West,south,east,north in degrees, instead of --aoi");
  command->add_option("--zone", line->zone,
                      "UTM zone such as 36N, 0N or 0S for UPS (default: that of the images' centre)");
  command
      ->add_option("--gsd", line->gsd_m,
                   "Ground sample distance in metres, a power of two (default: nearest to the finest image's)")
      ->check(CLI::PositiveNumber);
  command
      ->add_option("--navigability", line->footprints,
                   "Judge how well a camera finds itself, for each VIEW/SEARCH in metres (side of the view on the "
                   "ground, and how far off the vehicle may believe itself), or standard: 160, 240, 320 m / 160, 320 m")
      ->delimiter(',');
  std::vector<std::string> names;
  for (const auto* layer : layers::registry()) names.push_back(layer->info().name);
  names.insert(names.end(), {"landmarks", "roads"});
  command
      ->add_option("--layers", line->layers,
                   fmt::format("Layers to make, of {} (default: all that the inputs serve)", fmt::join(names, ",")))
      ->delimiter(',')
      ->allow_extra_args(false);
  std::string sets;
  for (const LayerSet& set : layer_sets())
    sets += fmt::format("{}{}: {}", sets.empty() ? "" : "; ", set.name, set.description);
  command->add_option("--set", line->options.set, fmt::format("Layers and codecs at once. {} (default: all)", sets));
  command->add_option("--date", line->dates, "FILE=2009-08-18: capture date of an image")->allow_extra_args(false);
  command->add_option("--bands", line->bands, "FILE=nir,red,green: what an image's bands show; '-' leaves one out")
      ->allow_extra_args(false);
  command
      ->add_option("--nodata", line->nodata,
                   "FILE=0: value that all bands have where an image shows nothing, if the file does not say")
      ->allow_extra_args(false);
  command->add_flag("--align", line->options.align,
                    "Remove the constant shifts between overlapping images, which are measured and reported anyway");
  command->add_option("--codec", line->codecs, "LAYER=raw, jpeg, zstd or context")->allow_extra_args(false);
  command->add_option("--jpeg-quality", line->options.jpeg_quality, "1 to 100 (default: the set's)");
  command
      ->add_option("--plane-height", line->options.plane_height_m,
                   "Metres above the ellipsoid of the ground where there are no heights")
      ->capture_default_str();
  command
      ->add_option("--georegistration-error", line->georegistration_error_m,
                   "One sigma per axis of the images' place, metres")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--threads", line->options.threads, "Threads to use (default: one per core)")
      ->check(CLI::PositiveNumber);
  command->add_flag("--force", line->options.force, "Replace the pack if it is there already");
  command->add_flag("--json", line->json, "Print the summary as JSON");
  command->callback([line] { run(*line); });
}

}  // namespace landfix::tools
