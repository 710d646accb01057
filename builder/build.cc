#include "builder/build.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <iterator>
#include <optional>
#include <set>
#include <span>
#include <system_error>
#include <utility>

#include "builder/catalog/catalog.h"
#include "builder/error.h"
#include "builder/export/vector_layers.h"
#include "builder/layers/stack.h"
#include "builder/layers/window.h"
#include "builder/map_features.h"
#include "builder/map_navigability.h"
#include "builder/navigability_layers.h"
#include "builder/plan.h"

namespace landfix {
namespace {

using catalog::Catalog;
using catalog::FinishedTile;
using catalog::Job;
using schema::TileRecord;

constexpr char kSourceStage[] = "source", kHalvedStage[] = "halved", kVectorStage[] = "vectors",
               kNavigabilityStage[] = "navigability";
constexpr size_t kParentsPerJob = 16;
constexpr double kBlockPixels =
    double(tiles::kTilePixels << layers::kBlockLog2) * (tiles::kTilePixels << layers::kBlockLog2);

// The name in the journal of an epoch's halved tiles; no layer of the pack can have it.
std::string name_of_epoch(size_t epoch) { return fmt::format("epoch/{}", epoch); }

// Where the halved tiles of a level are: by epoch, ascending by key.
using EpochRecords = std::vector<std::vector<TileRecord>>;

struct Work {
  Job job;
  double amount = 0;  ///< in the unit of the stage's progress
};

// One build under way.
class Run {
 public:
  Run(const BuildOptions& options, Progress& progress, const Plan& plan, Catalog& catalog, int threads)
      : options_(options), progress_(progress), plan_(plan), catalog_(catalog), threads_(threads) {}

  void make_tiles() {
    for (const auto& entry : plan_.sources) make_source_tiles(entry.first, entry.second);
    for (const auto& entry : plan_.halved) make_halved_tiles(entry.first, entry.second);
    make_levels();
    make_vector_tiles();
    make_navigability_tiles();
  }
  double megapixels() const { return megapixels_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  using Compute = std::function<std::vector<FinishedTile>(const Work&)>;

  std::string stage_at(int level) const;
  void make_source_tiles(int level, const std::vector<size_t>& layer_indices);
  std::vector<FinishedTile> source_tiles(const tiles::TileIndex& block, int level,
                                         const std::vector<size_t>& layer_indices) const;
  void make_halved_tiles(int level, const std::vector<size_t>& layer_indices);
  ingest::Stack read_halved(const tiles::PixelRect& rect, const EpochRecords& records) const;
  std::vector<Work> blocks_to_do(const char* stage, int level) const;
  bool searches(int level) const { return level == kFeatureLevel && (plan_.find_landmarks || plan_.find_roads); }
  int halo_of(const std::vector<size_t>& layer_indices, int level, bool searched) const;
  std::vector<FinishedTile> tiles_of_block(const layers::SourceWindow& window, const tiles::TileIndex& block,
                                           const std::vector<size_t>& layer_indices) const;
  void add_halved(const ingest::Stack& images, const tiles::TileIndex& block, std::vector<FinishedTile>& out) const;
  void make_levels();
  void make_level(const LayerPlan& layer, int level);
  void make_vector_tiles();
  void make_navigability_tiles();
  FinishedTile parent_tile(const LayerPlan& layer, int level, std::span<const TileRecord> children) const;
  FinishedTile encode(const LayerPlan& layer, const tiles::TileIndex& tile, const layers::TileData& data) const;
  layers::TileData decode(const LayerPlan& layer, const TileRecord& record) const;
  void run_jobs(const std::vector<Work>& work, const Compute& compute);

  const BuildOptions& options_;
  Progress& progress_;
  const Plan& plan_;
  Catalog& catalog_;
  int threads_;
  size_t jobs_ = 0;
  double megapixels_ = 0;
  std::vector<std::string> warnings_;
};

// Jobs start in order, run in parallel and end one by one in the catalog. At most two per thread are in flight.
void Run::run_jobs(const std::vector<Work>& work, const Compute& compute) {
  std::vector<const Work*> to_do;
  for (const Work& w : work)
    if (catalog_.is_done(w.job))
      progress_.skip(w.amount);
    else
      to_do.push_back(&w);
  // Beside the pipeline, which carries indices only: it would leak what it holds when one of its jobs throws.
  std::vector<std::vector<FinishedTile>> results(to_do.size());
  const auto stopping = [this] { return options_.stop && *options_.stop; };
  size_t next = 0;
  const auto take = [&](tbb::flow_control& flow) -> size_t {
    if (next < to_do.size() && !stopping()) return next++;
    flow.stop();
    return 0;
  };
  const auto run = [&](size_t index) {
    results[index] = compute(*to_do[index]);
    return index;
  };
  const auto commit = [&](size_t index) {
    std::vector<FinishedTile> tiles = std::move(results[index]);
    catalog_.commit(to_do[index]->job, tiles);
    progress_.advance(to_do[index]->amount);
    if (options_.after_job) options_.after_job(++jobs_);
  };
  tbb::parallel_pipeline(size_t(threads_) * 2,
                         tbb::make_filter<void, size_t>(tbb::filter_mode::serial_in_order, take) &
                             tbb::make_filter<size_t, size_t>(tbb::filter_mode::parallel, run) &
                             tbb::make_filter<size_t, void>(tbb::filter_mode::serial_out_of_order, commit));
  if (stopping()) throw Interrupted("stopped");
}

std::vector<Work> Run::blocks_to_do(const char* stage, int level) const {
  std::vector<Work> work;
  for (const tiles::TileIndex& block : blocks_of(plan_, level)) {
    const tiles::PixelRect window = window_of(plan_, block, level, 0);
    const double megapixels = double(window.width) * double(window.height) / 1e6;
    if (megapixels > 0) work.push_back({{stage, level, tiles::hilbert_key(block)}, megapixels});
  }
  return work;
}

// What takes the time there: "tiles, landmarks and roads at 1 m".
std::string Run::stage_at(int level) const {
  return fmt::format("tiles{}{} at {} m", searches(level) ? ", landmarks and roads" : "",
                     judges(plan_, level) ? ", navigability" : "", tiles::gsd_of(level));
}

void Run::make_source_tiles(int level, const std::vector<size_t>& layer_indices) {
  const std::vector<Work> work = blocks_to_do(kSourceStage, level);
  double total = 0;
  for (const Work& w : work) {
    total += w.amount;
    if (level == plan_.image_level && !catalog_.is_done(w.job)) megapixels_ += w.amount;
  }
  progress_.begin(stage_at(level), "Mpx", total);
  run_jobs(work, [&](const Work& w) {
    return source_tiles(tiles::tile_of_key(level + layers::kBlockLog2, w.job.key), level, layer_indices);
  });
  progress_.end();
}

int Run::halo_of(const std::vector<size_t>& layer_indices, int level, bool searched) const {
  int halo_px = std::max(searched ? feature_halo_px() : 0, navigability_halo_px(plan_, level));
  for (const size_t i : layer_indices) halo_px = std::max(halo_px, plan_.layers[i].info().halo_px);
  return halo_px;
}

std::vector<FinishedTile> Run::source_tiles(const tiles::TileIndex& block, int level,
                                            const std::vector<size_t>& layer_indices) const {
  const auto needs = [&](layers::Input input) {
    return std::ranges::any_of(layer_indices, [&](size_t i) { return plan_.layers[i].info().input == input; });
  };
  const bool searched = level == plan_.image_level && searches(level);
  const bool halves = level == plan_.image_level && plan_.halved.contains(level + 1);
  layers::SourceWindow window;
  window.rect = window.images.rect = window_of(plan_, block, level, halo_of(layer_indices, level, searched));
  const bool judged = level == plan_.image_level && judges(plan_, level);
  if (needs(layers::Input::kImages) || searched || halves || judged) window.images = plan_.images->read(window.rect);
  window.gray = layers::newest(window.images, window.rect, 1);
  if (needs(layers::Input::kHeights)) window.heights = plan_.elevation->read(window.rect);
  std::vector<FinishedTile> out = tiles_of_block(window, block, layer_indices);
  if (halves) add_halved(window.images, block, out);
  if (searched) std::ranges::move(find_features(plan_, window.images, block), std::back_inserter(out));
  std::ranges::move(judge_places(plan_, window.images, block), std::back_inserter(out));
  return out;
}

// In parallel, so that the last blocks of a level keep all threads busy. Isolated, so that a thread that waits here
// does not begin another block: its window would come on top.
std::vector<FinishedTile> Run::tiles_of_block(const layers::SourceWindow& window, const tiles::TileIndex& block,
                                              const std::vector<size_t>& layer_indices) const {
  std::vector<std::pair<const LayerPlan*, tiles::TileIndex>> wanted;
  for (const size_t i : layer_indices) {
    const LayerPlan& layer = plan_.layers[i];
    const int level = window.rect.level + layer.info().base_offset;
    const int32_t side = 1 << (block.level - level);
    for (int32_t n = 0; n < side * side; ++n) {
      const tiles::TileIndex tile{level, block.x * side + n % side, block.y * side + n / side};
      if (plan_.area->touches(tile)) wanted.emplace_back(&layer, tile);
    }
  }
  std::vector<FinishedTile> all(wanted.size());
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(size_t(0), wanted.size(), [&](size_t i) {
      const auto& [layer, tile] = wanted[i];
      const layers::TileData data = layer->layer->compute(window, tile);
      if (!data.empty()) all[i] = encode(*layer, tile, data);
    });
  });
  std::erase_if(all, [](const FinishedTile& tile) { return tile.data.empty(); });
  return all;
}

// What the epochs show in the block, for the jobs of the next level: of the tiles that touch the area, so that all
// layers show the same part of it at every level.
void Run::add_halved(const ingest::Stack& images, const tiles::TileIndex& block, std::vector<FinishedTile>& out) const {
  const auto used = [&](const tiles::TileIndex& tile) { return plan_.area->touches(tile); };
  const int level = images.rect.level + 1;
  const int32_t side = 1 << (block.level - level);
  for (int32_t n = 0; n < side * side; ++n) {
    const tiles::TileIndex tile{level, block.x * side + n % side, block.y * side + n / side};
    for (layers::EpochTile& half : layers::halved(images, tile, used))
      out.push_back(catalog::finished_tile(name_of_epoch(half.epoch), tile, std::move(half.data)));
  }
}

void Run::make_halved_tiles(int level, const std::vector<size_t>& layer_indices) {
  const std::vector<Work> work = blocks_to_do(kHalvedStage, level);
  EpochRecords records;
  for (size_t e = 0; e < plan_.images->epochs().size(); ++e) records.push_back(catalog_.tiles(name_of_epoch(e), level));
  double total = 0;
  for (const Work& w : work) total += w.amount;
  progress_.begin(stage_at(level), "Mpx", total);
  run_jobs(work, [&](const Work& w) {
    const tiles::TileIndex block = tiles::tile_of_key(level + layers::kBlockLog2, w.job.key);
    layers::SourceWindow window;
    window.rect = layers::grown(layers::pixels_of(block, level), halo_of(layer_indices, level, searches(level)));
    window.images = read_halved(window.rect, records);
    window.gray = layers::newest(window.images, window.rect, 1);
    std::vector<FinishedTile> out = tiles_of_block(window, block, layer_indices);
    if (plan_.halved.contains(level + 1)) add_halved(window.images, block, out);
    if (searches(level)) std::ranges::move(find_features(plan_, window.images, block), std::back_inserter(out));
    std::ranges::move(judge_places(plan_, window.images, block), std::back_inserter(out));
    return out;
  });
  progress_.end();
}

ingest::Stack Run::read_halved(const tiles::PixelRect& rect, const EpochRecords& records) const {
  const auto read = [&](size_t epoch, const tiles::TileIndex& tile) -> std::optional<std::vector<uint8_t>> {
    if (!tiles::in_domain(tile)) return std::nullopt;
    const uint64_t key = tiles::hilbert_key(tile);
    const auto record = std::ranges::lower_bound(records[epoch], key, {}, &TileRecord::key);
    if (record == records[epoch].end() || record->key != key) return std::nullopt;
    std::vector<uint8_t> data(record->length);
    catalog_.read(*record, data);
    return data;
  };
  return layers::stack_of_tiles(rect, plan_.images->epochs(), read);
}

// All levels above those made from the sources.
void Run::make_levels() {
  double total = 0;
  for (const LayerPlan& layer : plan_.layers) {
    if (layer.info().level_rule != layers::LevelRule::kFromChildren) continue;
    std::vector<TileRecord> tiles = catalog_.tiles(layer.info().name, layer.base_level);
    for (int level = layer.base_level + 1; level <= layer.top_level; ++level) {
      for (TileRecord& tile : tiles) tile.key >>= 2;
      tiles.erase(std::unique(tiles.begin(), tiles.end(), [](const auto& a, const auto& b) { return a.key == b.key; }),
                  tiles.end());
      total += double(tiles.size());
    }
  }
  progress_.begin("coarser levels", "tiles", total);
  for (const LayerPlan& layer : plan_.layers)
    if (layer.info().level_rule == layers::LevelRule::kFromChildren)
      for (int level = layer.base_level + 1; level <= layer.top_level; ++level) make_level(layer, level);
  progress_.end();
}

// The four children of a tile follow each other in Hilbert order: their keys share all digits but the last.
void Run::make_level(const LayerPlan& layer, int level) {
  const std::vector<TileRecord> children = catalog_.tiles(layer.info().name, level - 1);
  std::vector<size_t> first;  // child of each parent, and the end
  for (size_t i = 0; i < children.size(); ++i)
    if (i == 0 || children[i].key >> 2 != children[i - 1].key >> 2) first.push_back(i);
  const size_t parents = first.size();
  first.push_back(children.size());
  std::vector<Work> work;
  for (size_t p = 0; p < parents; p += kParentsPerJob)
    work.push_back(
        {{layer.info().name, level, children[first[p]].key >> 2}, double(std::min(kParentsPerJob, parents - p))});
  run_jobs(work, [&](const Work& w) {
    std::vector<FinishedTile> out;
    const size_t begin = size_t(&w - work.data()) * kParentsPerJob, end = std::min(begin + kParentsPerJob, parents);
    for (size_t p = begin; p < end; ++p) {
      FinishedTile tile = parent_tile(layer, level, std::span(children).subspan(first[p], first[p + 1] - first[p]));
      if (!tile.data.empty()) out.push_back(std::move(tile));
    }
    return out;
  });
}

// One job: what is left of the map by now is small.
void Run::make_vector_tiles() {
  if (!plan_.landmarks && !plan_.roads) return;
  progress_.begin("landmarks and roads", "passes", 1);
  run_jobs({{{kVectorStage, tiles::kVectorLevel, 0}, 1}},
           [&](const Work&) { return link_features(plan_, catalog_, warnings_); });
  progress_.end();
  for (const std::string& warning : warnings_) progress_.say("warning: " + warning);
}

// One job, after that of the landmarks that it counts.
void Run::make_navigability_tiles() {
  if (plan_.footprints.empty()) return;
  progress_.begin("navigability", "passes", 1);
  run_jobs({{{kNavigabilityStage, tiles::navigability_level(plan_.footprints[0]), 0}, 1}},
           [&](const Work&) { return link_navigability(plan_, catalog_); });
  progress_.end();
}

// Without data where the children leave none.
FinishedTile Run::parent_tile(const LayerPlan& layer, int level, std::span<const TileRecord> children) const {
  std::array<layers::TileData, 4> quadrants;
  for (const TileRecord& record : children) {
    const tiles::TileIndex child = tiles::tile_of_key(level - 1, record.key);
    quadrants[size_t((child.y & 1 ? 0 : 2) + (child.x & 1))] = decode(layer, record);
  }
  layers::TileData data = layer.layer->reduce(quadrants);
  if (data.empty()) return {};
  std::set<uint16_t> epochs;
  for (const TileRecord& record : children)
    for (const uint16_t epoch : catalog_.epochs_of(record)) epochs.insert(epoch);
  data.epochs.assign(epochs.begin(), epochs.end());
  return encode(layer, tiles::tile_of_key(level, children[0].key >> 2), data);
}

FinishedTile Run::encode(const LayerPlan& layer, const tiles::TileIndex& tile, const layers::TileData& data) const {
  const tiles::TileFormat& format = layer.info().format;
  CV_Assert(data.pixels.isContinuous() && data.pixels.total() * data.pixels.elemSize() == format.bytes());
  std::vector<uint8_t> bytes =
      tiles::encode(layer.codec, format, {data.pixels.ptr<uint8_t>(), format.bytes()}, plan_.encoding);
  if (bytes.empty())
    throw Error(ExitCode::kInternal, fmt::format("layer {}: a tile could not be encoded", layer.info().name));
  FinishedTile out = catalog::finished_tile(layer.info().name, tile, std::move(bytes));
  out.record.codec = uint8_t(layer.codec);
  out.record.value_offset = data.value_offset;
  out.record.value_step = data.value_step;
  out.epochs = data.epochs;
  return out;
}

layers::TileData Run::decode(const LayerPlan& layer, const TileRecord& record) const {
  const tiles::TileFormat& format = layer.info().format;
  std::vector<uint8_t> data(record.length);
  catalog_.read(record, data);
  const int depth = format.type == tiles::PixelType::kU8 ? CV_8U : CV_16S;
  layers::TileData out{cv::Mat(tiles::kTilePixels, tiles::kTilePixels, CV_MAKETYPE(depth, format.channels)),
                       record.value_offset, record.value_step};
  if (!tiles::decode(tiles::Codec(record.codec), format, data, {out.pixels.ptr<uint8_t>(), format.bytes()}))
    throw Error(ExitCode::kIo, fmt::format("layer {}: a spooled tile is damaged", layer.info().name));
  return out;
}

// A level that holds anything.
void add_summary(const exporter::PackLevel& level, LayerSummary& layer) {
  LevelSummary out{level.level};
  for (const TileRecord& tile : level.tiles) ++out.tiles, out.bytes += tile.length;
  if (out.tiles) layer.levels.push_back(out);
}

// Adds the finished tiles to the description of the pack, and what there is of them to the summary.
exporter::PackDescription collect(const Plan& plan, const Catalog& catalog, std::vector<LayerSummary>& summary) {
  exporter::PackDescription pack = plan.description;
  pack.epoch_sets = catalog.epoch_sets();
  for (size_t i = 0; i < plan.layers.size(); ++i) {
    const LayerPlan& layer = plan.layers[i];
    summary.push_back({layer.info().name, layer.codec, {}});
    for (int level = layer.base_level; level <= layer.top_level; ++level) {
      pack.layers[i].levels.push_back({level, catalog.tiles(layer.info().name, level)});
      add_summary(pack.layers[i].levels.back(), summary.back());
    }
  }
  for (size_t i = plan.layers.size(); i < pack.layers.size(); ++i) {
    exporter::PackLevel& level = pack.layers[i].levels.front();
    level.tiles = catalog.tiles(pack.layers[i].name, level.level);
    const bool raster = pack.layers[i].content == exporter::VectorContent::kNone;
    summary.push_back({pack.layers[i].name, raster ? tiles::Codec::kZstd : tiles::Codec::kVector, {}});
    add_summary(level, summary.back());
  }
  return pack;
}

// The last step of every build.
exporter::PackStatistics merge(const BuildOptions& options, Progress& progress, const exporter::PackDescription& pack,
                               const Catalog& catalog) {
  double bytes = 0;
  for (const exporter::PackLayer& layer : pack.layers)
    for (const exporter::PackLevel& level : layer.levels)
      for (const TileRecord& tile : level.tiles) bytes += tile.length;
  progress.begin("writing", "MB", bytes / 1e6);
  const auto read = [&](const TileRecord& tile, std::span<uint8_t> out) {
    if (options.stop && *options.stop) throw Interrupted("stopped");
    catalog.read(tile, out);
  };
  const auto statistics = exporter::write_pack(options.output, pack, read,
                                               [&](uint64_t written) { progress.advance(double(written) / 1e6); });
  progress.end();
  return statistics;
}

// By the first layer that has tiles: the one with the smallest, so the closest to the area's shape.
double area_km2(const Plan& plan, const std::vector<LayerSummary>& layers) {
  const ingest::GridBounds& b = plan.area->bounds();
  const double bounds_m2 = (b.east_m - b.west_m) * (b.north_m - b.south_m);
  for (const LayerSummary& layer : layers)
    if (!layer.levels.empty()) {
      const double side_m = tiles::tile_side(layer.levels[0].level);
      return std::min(double(layer.levels[0].tiles) * side_m * side_m, bounds_m2) / 1e6;
    }
  return bounds_m2 / 1e6;
}

// What the journal's tiles will take, from above: every block full, nothing compressed; all coarser levels add a third.
double spool_bytes(const Plan& plan) {
  double bytes = 0;
  for (const auto& [level, layer_indices] : plan.sources) {
    const auto blocks = double(blocks_of(plan, level).size());
    for (const size_t i : layer_indices) {
      const layers::LayerInfo& info = plan.layers[i].info();
      const double tiles = blocks * double(1 << 2 * (layers::kBlockLog2 - info.base_offset));
      bytes += tiles * double(info.format.bytes()) * 4 / 3;
    }
  }
  if (!plan.halved.empty())
    for (const ingest::EpochInfo& epoch : plan.images->epochs())
      bytes += double(blocks_of(plan, plan.image_level).size()) * kBlockPixels * double(epoch.roles.size()) / 3;
  return bytes;
}

// Better said before hours of work than after. Only a warning: equal tiles, gaps and compression may make it fit.
void warn_of_full_disk(const BuildOptions& options, const Plan& plan, Progress& progress) {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(catalog::folder_of(options.output), error);
  const double needed =
      2 * spool_bytes(plan);  // the journal and the pack lie beside each other until the pack is whole
  if (!error && double(space.available) < needed)
    progress.say(fmt::format("warning: {}: the build may need up to {:.1f} GB here, the disk has {:.1f} GB free",
                             options.output.string(), needed / 1e9, double(space.available) / 1e9));
}

std::filesystem::path journal_of(const std::filesystem::path& output) { return output.string() + ".build"; }

BuildSummary run(const BuildOptions& options, Progress& progress, const Plan& plan, int threads) {
  Catalog catalog(journal_of(options.output), plan.fingerprint);
  if (!catalog.note().empty()) progress.say("starting over: " + catalog.note());
  if (catalog.jobs_found()) progress.say(fmt::format("continuing: {} jobs are done already", catalog.jobs_found()));
  warn_of_full_disk(options, plan, progress);
  BuildSummary summary;
  Run run(options, progress, plan, catalog, threads);
  run.make_tiles();
  const exporter::PackDescription pack = collect(plan, catalog, summary.layers);
  const auto rasters = std::span(summary.layers).first(plan.layers.size());
  if (!rasters.empty() && std::ranges::all_of(rasters, [](const LayerSummary& l) { return l.levels.empty(); })) {
    catalog.remove();
    throw Error(
        ExitCode::kBadInput,
        "the inputs hold no data inside the area: nothing to write; check --aoi or --bbox and the images' nodata");
  }
  summary.features = text_of_features(plan, catalog);
  std::ranges::move(text_of_navigability(plan, catalog), std::back_inserter(summary.features));
  const exporter::PackStatistics statistics = merge(options, progress, pack, catalog);
  catalog.remove();
  summary.zone = plan.images->zone();
  summary.gsd_m = tiles::gsd_of(plan.image_level);
  summary.area_km2 = area_km2(plan, summary.layers);
  summary.file_bytes = statistics.file_bytes;
  summary.tiles = statistics.tiles;
  summary.stored_tiles = statistics.stored_tiles;
  summary.resumed_jobs = catalog.jobs_found();
  summary.megapixels = run.megapixels();
  summary.warnings = plan.warnings;
  summary.warnings.insert(summary.warnings.end(), run.warnings().begin(), run.warnings().end());
  summary.shifts = plan.shifts;
  return summary;
}

}  // namespace

BuildSummary build(const BuildOptions& options, Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  const int threads = options.threads > 0 ? options.threads : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
  const Plan plan = make_plan(options);
  for (const std::string& warning : plan.warnings) progress.say("warning: " + warning);
  for (const ShiftSummary& s : plan.shifts)
    progress.say(fmt::format("{}: {}{}", s.image, s.text,
                             s.removed              ? ", removed"
                             : s.alignment.measured ? "; --align removes it"
                                                    : ""));
  const auto advice = [&] {
    const std::filesystem::path journal = journal_of(options.output);
    if (!std::filesystem::exists(journal)) return std::string();
    return fmt::format("; the tiles done so far are kept in {}: the same command continues from there",
                       journal.string());
  };
  try {
    BuildSummary summary;
    tbb::task_arena(threads).execute([&] { summary = run(options, progress, plan, threads); });
    summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return summary;
  } catch (const Error& error) {
    throw Error(error.code(), error.what() + advice());
  } catch (const Interrupted& interrupted) {
    throw Interrupted(interrupted.what() + advice());
  }
}

}  // namespace landfix
