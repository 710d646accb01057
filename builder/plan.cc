#include "builder/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include "builder/catalog/hash.h"
#include "builder/error.h"
#include "builder/export/vector_layers.h"
#include "builder/file_bytes.h"
#include "builder/ground_cover.h"
#include "builder/hex.h"
#include "builder/ingest/geoid.h"
#include "builder/ingest/zone.h"
#include "builder/layers/registry.h"
#include "builder/layers/window.h"
#include "builder/map_navigability.h"
#include "builder/navigability_layers.h"

namespace landfix {
namespace {

using layers::Input;
using layers::LevelRule;

constexpr int kCoarsestView_px = 16;   // a smaller view says next to nothing
constexpr int kFarthestView_px = 512;  // a farther search takes hours and memory, and no vehicle is so lost

int image_level_of(const BuildOptions& options, const ingest::ImageSet& images) {
  if (!options.gsd_m) return images.derived_level();
  const std::optional<int> level = tiles::nearest_level(*options.gsd_m);
  if (!level)
    throw Error(ExitCode::kUsage, fmt::format("--gsd {}: expected a power of two from {} to {} metres", *options.gsd_m,
                                              tiles::gsd_of(tiles::kMinLevel), tiles::gsd_of(tiles::kMaxLevel)));
  if (tiles::gsd_of(*level) != *options.gsd_m)
    throw Error(ExitCode::kUsage, fmt::format("--gsd {}: the grid has powers of two only; the nearest is {}",
                                              *options.gsd_m, tiles::gsd_of(*level)));
  return *level;
}

std::string hash_of_bytes(std::span<const uint8_t> bytes) { return hex(catalog::hash_of(bytes).bytes); }

std::string hash_of_text(const std::string& text) {
  return hash_of_bytes({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

// How the area came about, for the manifest: no folders, but what identifies it.
std::string area_text(const BuildOptions& options) {
  if (!options.area_file.empty())
    return fmt::format("{} blake2b:{}", std::filesystem::path(options.area_file).filename().string(),
                       hash_of_bytes(bytes_of_file(options.area_file, "polygons of the area")));
  return options.bbox.empty() ? "images" : "bbox " + options.bbox;
}

std::unique_ptr<ingest::Area> area_of(const BuildOptions& options, const ingest::ImageSet& images) {
  if (!options.area_file.empty() && !options.bbox.empty())
    throw Error(ExitCode::kUsage, "--aoi and --bbox: expected at most one of them");
  const auto make = [&] {
    if (!options.area_file.empty()) return ingest::Area::from_file(options.area_file, images.zone());
    if (!options.bbox.empty()) return ingest::Area::from_bbox(options.bbox, images.zone());
    return ingest::Area::of_images(images);
  };
  auto area = std::make_unique<ingest::Area>(make());
  area->require_overlap(images);
  return area;
}

// The finest level at which the area is no larger than a tile.
int top_level_of(const ingest::GridBounds& bounds) {
  const double extent_m = std::max(bounds.east_m - bounds.west_m, bounds.north_m - bounds.south_m);
  int level = tiles::kMinLevel;
  while (level < tiles::kMaxLevel && tiles::tile_side(level) < extent_m) ++level;
  return level;
}

std::vector<std::string> all_names() {
  std::vector<std::string> names;
  for (const layers::RasterLayer* layer : layers::registry()) names.push_back(layer->info().name);
  return names;
}

bool is_vector_layer(const std::string& name) { return name == exporter::kLandmarks || name == exporter::kRoads; }

void require_known(const std::string& name, const char* option) {
  if (!layers::find(name))
    throw Error(ExitCode::kUsage,
                fmt::format("{} {}: no such layer; expected some of {}", option, name, fmt::join(all_names(), ", ")));
}

// What the inputs lack for a layer; empty: nothing.
std::string lack_of(const layers::LayerInfo& info, const BuildOptions& options, const Plan& plan) {
  if (info.input == Input::kHeights && !options.elevation) return "needs heights; give them with --dem";
  if (const size_t epochs = plan.images->epochs().size(); epochs < size_t(info.min_epochs))
    return fmt::format("needs images of {} dates or more, there is {}; say which with --date", info.min_epochs, epochs);
  return {};
}

bool is_wanted(const layers::LayerInfo& info, const BuildOptions& options, const Plan& plan) {
  const auto among = [&](const std::vector<std::string>& names) { return std::ranges::count(names, info.name) > 0; };
  const std::string lack = lack_of(info, options, plan);
  if (!options.layers.empty()) {
    if (among(options.layers) && !lack.empty())
      throw Error(ExitCode::kUsage, fmt::format("--layers {}: this layer {}", info.name, lack));
    return among(options.layers);
  }
  return lack.empty() && (plan.set->layers.empty() || among(plan.set->layers));
}

tiles::Codec codec_of(const std::string& layer, tiles::Codec otherwise, const BuildOptions& options, const Plan& plan) {
  for (const auto* codecs : {&options.codecs, &plan.set->codecs})
    if (const auto chosen = codecs->find(layer); chosen != codecs->end()) return chosen->second;
  return otherwise;
}

// Why a codec cannot hold such pixels; empty: it can.
std::string refusal_of(tiles::Codec codec, const tiles::TileFormat& format) {
  if (codec == tiles::Codec::kJpeg && (format.type != tiles::PixelType::kU8 || format.channels == 2))
    return "jpeg needs 8-bit pixels of 1 or 3 channels";
  if (codec == tiles::Codec::kContext && format.type != tiles::PixelType::kBit)
    return "context needs pixels of single bits, as orientation has them";
  return {};
}

std::string codecs_for(const tiles::TileFormat& format) {
  std::vector<std::string> names;
  for (const tiles::Codec codec :
       {tiles::Codec::kRaw, tiles::Codec::kJpeg, tiles::Codec::kZstd, tiles::Codec::kContext})
    if (refusal_of(codec, format).empty()) names.push_back(name_of(codec));
  return fmt::format("{}", fmt::join(names, ", "));
}

LayerPlan plan_of(const layers::RasterLayer& layer, const BuildOptions& options, const Plan& plan) {
  const layers::LayerInfo& info = layer.info();
  LayerPlan out{&layer, codec_of(info.name, info.default_codec, options, plan)};
  if (const std::string refusal = refusal_of(out.codec, info.format); !refusal.empty())
    throw Error(ExitCode::kUsage, fmt::format("--codec {}={}: {}; expected one of {}", info.name, name_of(out.codec),
                                              refusal, codecs_for(info.format)));
  int window_level = plan.image_level;
  if (info.input == Input::kHeights)
    window_level = std::max(window_level, tiles::nearest_level(plan.elevation->gsd_m()).value_or(window_level));
  out.base_level = std::min(window_level + info.base_offset, tiles::kMaxLevel);
  out.top_level = std::max(out.base_level, top_level_of(plan.area->bounds()));
  return out;
}

// A codec for a layer that is not built is a misunderstanding that the user should hear of.
void require_built(const std::string& layer, tiles::Codec codec, const BuildOptions& options, const Plan& plan) {
  std::vector<std::string> built;
  for (const LayerPlan& l : plan.layers) built.push_back(l.info().name);
  if (std::ranges::count(built, layer) > 0) return;
  const std::string lack = lack_of(layers::find(layer)->info(), options, plan);
  throw Error(ExitCode::kUsage,
              fmt::format("--codec {}={}: this layer is not built{}; built are {}", layer, name_of(codec),
                          lack.empty() ? "" : ", it " + lack, fmt::join(built, ", ")));
}

void choose_layers(const BuildOptions& options, Plan& plan) {
  for (const std::string& name : options.layers)
    if (!is_vector_layer(name))
      require_known(name, "--layers");
    else if (options.vectors.empty() && plan.image_level > kFeatureLevel)
      throw Error(ExitCode::kUsage,
                  fmt::format("--layers {}: this layer needs imagery of {} m or finer, this is of {}; "
                              "--vectors gives what is known",
                              name, tiles::gsd_of(kFeatureLevel), tiles::gsd_of(plan.image_level)));
  for (const auto& entry : options.codecs) require_known(entry.first, "--codec");
  for (const layers::RasterLayer* layer : layers::registry()) {
    if (!is_wanted(layer->info(), options, plan)) continue;
    const LayerPlan out = plan_of(*layer, options, plan);
    plan.sources[out.base_level - layer->info().base_offset].push_back(plan.layers.size());
    if (layer->info().level_rule == LevelRule::kFromSource)
      for (int level = out.base_level + 1; level <= out.top_level; ++level)
        plan.halved[level].push_back(plan.layers.size());
    plan.layers.push_back(out);
  }
  for (const auto& [layer, codec] : options.codecs) require_built(layer, codec, options, plan);
}

std::optional<double> georegistration_error(const BuildOptions& options, const ingest::ImageSet& images) {
  if (options.georegistration_error_m) return options.georegistration_error_m;
  double largest = 0;
  for (const ingest::Source& source : images.sources()) {
    if (!source.georegistration_error_m) return std::nullopt;
    largest = std::max(largest, *source.georegistration_error_m);
  }
  return largest;
}

// What tells sources apart in parameters and messages: the file's name, and where several have it, "#2" and so on from
// the second of them as listed. Folders would make the pack depend on where it was built.
std::vector<std::string> labels_of(const std::vector<std::string>& names) {
  std::vector<std::string> labels;
  for (const std::string& name : names) {
    std::string label = name;
    for (int number = 2; std::ranges::count(labels, label) > 0; ++number) label = fmt::format("{}#{}", name, number);
    labels.push_back(label);
  }
  return labels;
}

std::vector<std::string> names_of(const std::vector<ingest::Source>& sources) {
  std::vector<std::string> names;
  for (const ingest::Source& source : sources) names.push_back(source.name);
  return names;
}

bool is_wanted(const char* vector_layer, const BuildOptions& options, const Plan& plan) {
  const std::vector<std::string>& chosen = options.layers.empty() ? plan.set->layers : options.layers;
  return chosen.empty() || std::ranges::count(chosen, vector_layer) > 0;
}

void read_vectors(const BuildOptions& options, Plan& plan) {
  if (options.vectors.empty()) return;
  exporter::PackDescription& d = plan.description;
  plan.known = landmarks::read_known(options.vectors, d.zone, d.bounds);
  for (const ingest::Source& source : plan.known.sources) d.sources.push_back({exporter::SourceRole::kVector, source});
  plan.warnings.insert(plan.warnings.end(), plan.known.warnings.begin(), plan.known.warnings.end());
}

// Landmarks that are known are joined by those that the images show. Known roads are taken alone: a second line beside
// each, a little off, would make intersections that are none.
void choose_vector_layers(const BuildOptions& options, Plan& plan) {
  const bool landmarks = is_wanted(exporter::kLandmarks, options, plan);
  const bool roads = is_wanted(exporter::kRoads, options, plan);
  const bool is_fine = plan.image_level <= kFeatureLevel;
  plan.find_landmarks = landmarks && is_fine;
  plan.find_roads = roads && is_fine && !plan.known.has_roads;
  const auto is_made = [&](bool wanted, bool known) { return wanted && (is_fine || known || !options.layers.empty()); };
  plan.landmarks = is_made(landmarks, plan.known.has_landmarks);
  plan.roads = is_made(roads, plan.known.has_roads);
  if (!is_fine && ((landmarks && !plan.known.has_landmarks) || (roads && !plan.known.has_roads)))
    plan.warnings.push_back(
        fmt::format("landmarks and roads are not sought in the images: that takes {} m per pixel or finer, this is {}",
                    tiles::gsd_of(kFeatureLevel), tiles::gsd_of(plan.image_level)));
  if (plan.landmarks) plan.description.layers.push_back(exporter::landmarks_layer());
  if (plan.roads) plan.description.layers.push_back(exporter::roads_layer());
  if (plan.find_landmarks)
    plan.object_model = std::make_shared<const landmarks::ObjectModel>(
        options.landmark_model.empty() ? landmarks::default_object_model()
                                       : landmarks::read_object_model(options.landmark_model));
  if (plan.find_roads)
    plan.road_model = std::make_shared<const landmarks::RoadModel>(
        options.road_model.empty() ? landmarks::default_road_model() : landmarks::read_road_model(options.road_model));
  if (!plan.find_landmarks && !plan.find_roads) return;
  plan.sources[plan.image_level];
  for (int level = plan.image_level + 1; level <= kFeatureLevel; ++level) plan.halved[level];
}

// Matchers whose layers the pack has, in the order in which `auto` asks them.
std::vector<nav::Method> matchers_of(const Plan& plan) {
  using nav::Method;
  std::vector<Method> out;
  for (const Method method : {Method::kOrientation, Method::kGray, Method::kEdge, Method::kContour})
    if (std::ranges::any_of(plan.layers, [&](const LayerPlan& l) { return l.info().name == nav::name_of(method); }))
      out.push_back(method);
  return out;
}

void add_footprint(const tiles::Footprint& f, Plan& plan) {
  if (std::ranges::count(plan.footprints, f) > 0) return;
  const int level = matched_level(f, plan.image_level);
  if (tiles::gsd_of(level) * kCoarsestView_px > f.template_m)
    throw Error(
        ExitCode::kUsage,
        fmt::format("--navigability {}/{}: a view of {} m has fewer than {} pixels a side here; expected {} m "
                    "or more",
                    f.template_m, f.search_m, f.template_m, kCoarsestView_px, tiles::gsd_of(level) * kCoarsestView_px));
  const double reach_m = f.template_m / 2 + f.search_m, most_m = kFarthestView_px * tiles::gsd_of(level);
  if (reach_m > most_m)
    throw Error(
        ExitCode::kUsage,
        fmt::format("--navigability {}/{}: views would reach {} m from a place, {} pixels at {} m each; expected "
                    "half of the view and the search to be {} m together at most",
                    f.template_m, f.search_m, reach_m, reach_m / tiles::gsd_of(level), tiles::gsd_of(level), most_m));
  plan.footprints.push_back(f);
  plan.description.layers.push_back(navigability_layer(f));
  plan.sources[plan.image_level];
  for (int l = plan.image_level + 1; l <= std::max(level, ground_level(plan)); ++l) plan.halved[l];
}

void choose_footprints(const BuildOptions& options, Plan& plan) {
  if (options.footprints.empty()) return;
  plan.matchers = matchers_of(plan);
  if (plan.matchers.empty())
    throw Error(ExitCode::kUsage,
                "--navigability: nothing could be matched in this pack; expected one of the layers orientation, gray, "
                "edge, contour");
  for (const tiles::Footprint& f : options.footprints) add_footprint(f, plan);
}

std::vector<std::pair<std::string, std::string>> parameters_of(const BuildOptions& options, const Plan& plan) {
  std::vector<std::pair<std::string, std::string>> out;
  out.emplace_back("area", area_text(options));
  out.emplace_back("gsd_m", fmt::format("{}", tiles::gsd_of(plan.image_level)));
  bool jpeg = false, zstd = false;
  for (const LayerPlan& layer : plan.layers) {
    out.emplace_back("codec." + layer.info().name, name_of(layer.codec));
    for (const auto& [name, value] : layer.info().parameters) out.emplace_back(layer.info().name + "." + name, value);
    jpeg |= layer.codec == tiles::Codec::kJpeg;
    zstd |= layer.codec == tiles::Codec::kZstd;
  }
  if (jpeg) out.emplace_back("jpeg_quality", std::to_string(plan.encoding.jpeg_quality));
  if (zstd) out.emplace_back("zstd_level", std::to_string(plan.encoding.zstd_level));
  std::vector<ingest::Source> sources = plan.images->sources();
  if (plan.elevation) sources.push_back(plan.elevation->source());
  const std::vector<std::string> labels = labels_of(names_of(sources));
  for (size_t i = 0; i < sources.size(); ++i)
    if (sources[i].nodata) out.emplace_back("nodata." + labels[i], fmt::format("{}", *sources[i].nodata));
  for (size_t i = 0; i < options.vectors.size(); ++i) {
    const landmarks::VectorInput& input = options.vectors[i];
    out.emplace_back(fmt::format("vectors.{}", i + 1),
                     fmt::format("{}{}{}={}", plan.known.sources[i].name, input.layer.empty() ? "" : ":", input.layer,
                                 input.kind ? landmarks::name_of(*input.kind) : "by tags or name"));
  }
  if (plan.landmarks) out.emplace_back("landmarks.distinct_radius_m", fmt::format("{}", tiles::kDistinctRadius_m));
  if (plan.find_landmarks)
    out.emplace_back("landmarks.model", "blake2b:" + hash_of_bytes(plan.object_model->serialise()));
  if (plan.find_roads) out.emplace_back("roads.model", "blake2b:" + hash_of_bytes(plan.road_model->serialise()));
  for (const ShiftSummary& s : plan.shifts)
    out.emplace_back("shift." + s.image, s.text + (s.removed ? ", removed" : ""));
  return out;
}

ingest::GridBounds intersection(const ingest::GridBounds& a, const ingest::GridBounds& b) {
  return {std::max(a.west_m, b.west_m), std::max(a.south_m, b.south_m), std::min(a.east_m, b.east_m),
          std::min(a.north_m, b.north_m)};
}

// Encloses the data of every layer's finest level: tiles that touch the area are stored whole, as far as the inputs
// reach.
ingest::GridBounds bounds_of_data(const Plan& plan) {
  ingest::GridBounds bounds;
  for (const LayerPlan& layer : plan.layers) {
    const tiles::TileRange range = tiles::tiles_of(ingest::pixels_covering(plan.area->bounds(), layer.base_level));
    ingest::GridBounds touched = ingest::bounds_of(tiles::TileIndex{range.level, range.x_min, range.y_min});
    touched.extend(ingest::bounds_of(tiles::TileIndex{range.level, range.x_max, range.y_max}));
    const bool heights = layer.info().input == Input::kHeights;
    const ingest::GridBounds& input = heights ? plan.elevation->source().bounds : plan.images->bounds();
    const ingest::GridBounds data =
        intersection(touched, ingest::bounds_of(ingest::pixels_covering(input, layer.base_level)));
    if (!data.empty()) bounds.extend(data);
  }
  if (bounds.empty()) bounds = plan.area->bounds();
  return bounds;
}

void describe(const BuildOptions& options, Plan& plan) {
  exporter::PackDescription& d = plan.description;
  d.zone = plan.images->zone();
  d.bounds = bounds_of_data(plan);
  for (const LayerPlan& layer : plan.layers)
    d.layers.push_back({layer.info().name, layer.info().description, layer.info().format, {}});
  for (const ingest::Source& source : plan.images->sources())
    d.sources.push_back({exporter::SourceRole::kImage, source});
  if (plan.elevation) d.sources.push_back({exporter::SourceRole::kElevation, plan.elevation->source()});
  read_vectors(options, plan);
  choose_vector_layers(options, plan);
  choose_footprints(options, plan);
  for (const ingest::EpochInfo& epoch : plan.images->epochs())
    d.epochs.push_back({epoch.date, {epoch.sources.begin(), epoch.sources.end()}});
  ingest::GeoidResult geoid = ingest::make_geoid_grid(d.zone, d.bounds);
  d.geoid = std::move(geoid.grid);
  if (!geoid.warning.empty()) plan.warnings.push_back(geoid.warning);
  d.plane_height_m = options.plane_height_m;
  d.georegistration_error_m = georegistration_error(options, *plan.images);
  d.builder = "landfix " LANDFIX_VERSION;
  d.parameters = parameters_of(options, plan);
}

// All that decides about the bytes of tiles and about which there are.
std::string fingerprint_of(const Plan& plan) {
  const exporter::PackDescription& d = plan.description;
  std::string text = fmt::format("{}\n{}\n{} {} {} {}\n", d.builder, ingest::zone_text(d.zone), d.bounds.west_m,
                                 d.bounds.south_m, d.bounds.east_m, d.bounds.north_m);
  for (const auto& [name, value] : d.parameters) text += fmt::format("{}={}\n", name, value);
  for (const LayerPlan& l : plan.layers) text += fmt::format("{} {} {}\n", l.info().name, l.base_level, l.top_level);
  text += fmt::format("landmarks {} roads {}\n", plan.landmarks, plan.roads);
  for (const tiles::Footprint& f : plan.footprints) text += tiles::layer_of(f) + "\n";
  for (const exporter::PackSource& s : d.sources) {
    text += fmt::format("{} {} {} {} {}", int(s.role), s.source.sha256, s.source.date, s.source.crs,
                        s.source.vertical_datum);
    for (const ingest::BandRole role : s.source.bands) text += fmt::format(" {}", ingest::name_of(role));
    text += "\n";
  }
  return hash_of_text(text);
}

// Before anything that depends on where the images lie.
void align(const BuildOptions& options, Plan& plan) {
  const auto alignments = ingest::measure_alignment(*plan.images, plan.image_level);
  const std::vector<std::string> labels = labels_of(names_of(plan.images->sources()));
  for (size_t i = 0; i < alignments.size(); ++i) {
    const ingest::Alignment& a = alignments[i];
    if (!a.reference) continue;
    const bool removed = options.align && a.measured;
    plan.shifts.push_back({labels[i], a, text_of(a, labels), removed});
    if (removed) plan.images->move_source(i, -a.east_m, -a.north_m);
  }
}

void check_options(const BuildOptions& options) {
  if (options.images.empty()) throw Error(ExitCode::kUsage, "no image was given");
  if (const auto q = options.jpeg_quality; q && (*q < 1 || *q > 100))
    throw Error(ExitCode::kUsage, fmt::format("--jpeg-quality {}: expected 1 to 100", *q));
  if (!options.set.empty() && !options.layers.empty())
    throw Error(ExitCode::kUsage, "--set and --layers: expected at most one of them");
  if (options.threads < 0)
    throw Error(ExitCode::kUsage, fmt::format("--threads {}: expected 1 or more", options.threads));
  if (!std::isfinite(options.plane_height_m))
    throw Error(ExitCode::kUsage, "--plane-height: expected metres above the ellipsoid");
  if (const auto e = options.georegistration_error_m; e && !(std::isfinite(*e) && *e >= 0))
    throw Error(ExitCode::kUsage, fmt::format("--georegistration-error {}: expected metres, 0 or more", *e));
  if (!options.output.has_filename()) throw Error(ExitCode::kUsage, "no output file was given");
  if (std::filesystem::exists(options.output) && !options.force)
    throw Error(ExitCode::kUsage, fmt::format("{}: exists already; --force replaces it", options.output.string()));
}

}  // namespace

const char* name_of(tiles::Codec codec) {
  switch (codec) {
    case tiles::Codec::kRaw:
      return "raw";
    case tiles::Codec::kJpeg:
      return "jpeg";
    case tiles::Codec::kZstd:
      return "zstd";
    case tiles::Codec::kContext:
      return "context";
    case tiles::Codec::kVector:
      return "vector";
  }
  return "";
}

Plan make_plan(const BuildOptions& options) {
  check_options(options);
  Plan plan;
  plan.set = &layer_set(options.set.empty() ? layer_sets().front().name : options.set);
  plan.encoding = plan.set->encoding;
  if (options.jpeg_quality) plan.encoding.jpeg_quality = *options.jpeg_quality;
  plan.images = std::make_unique<ingest::ImageSet>(options.images, options.zone);
  plan.warnings = plan.images->warnings();
  plan.image_level = image_level_of(options, *plan.images);
  align(options, plan);
  plan.area = area_of(options, *plan.images);
  if (options.elevation) {
    plan.elevation = std::make_unique<ingest::ElevationModel>(*options.elevation, plan.images->zone());
    plan.elevation->require_overlap(plan.area->bounds());
    std::ranges::copy(plan.elevation->warnings(), std::back_inserter(plan.warnings));
  } else {
    plan.warnings.push_back(
        fmt::format("no heights (--dem): the runtime will assume a plane {} m above the ellipsoid (--plane-height)",
                    options.plane_height_m));
  }
  choose_layers(options, plan);
  describe(options, plan);
  plan.fingerprint = fingerprint_of(plan);
  return plan;
}

std::vector<tiles::TileIndex> blocks_of(const Plan& plan, int level) {
  const ingest::GridBounds& bounds = plan.area->bounds();
  const tiles::TileRange range = tiles::tiles_of(ingest::pixels_covering(bounds, level + layers::kBlockLog2));
  std::vector<tiles::TileIndex> blocks;
  for (int32_t y = range.y_min; y <= range.y_max; ++y)
    for (int32_t x = range.x_min; x <= range.x_max; ++x)
      if (const tiles::TileIndex block{range.level, x, y}; plan.area->touches(block)) blocks.push_back(block);
  std::sort(blocks.begin(), blocks.end(),
            [](const auto& a, const auto& b) { return tiles::hilbert_key(a) < tiles::hilbert_key(b); });
  return blocks;
}

tiles::PixelRect window_of(const Plan& plan, const tiles::TileIndex& block, int level, int halo_px) {
  const tiles::PixelRect rect = layers::grown(layers::pixels_of(block, level), halo_px);
  ingest::GridBounds inputs = plan.images->bounds();
  if (plan.elevation) inputs.extend(plan.elevation->source().bounds);
  return layers::intersection(rect, ingest::pixels_covering(inputs, level));
}

}  // namespace landfix
