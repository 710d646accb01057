#include "builder/map_navigability.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <set>
#include <span>

#include "builder/catalog/hash.h"
#include "builder/export/vector_layers.h"
#include "builder/layers/layer.h"
#include "builder/layers/window.h"
#include "builder/navigability/model.h"
#include "builder/point_grid.h"
#include "tiles/landmark.h"
#include "tiles/navigability.h"

namespace landfix {
namespace {

using catalog::Catalog;
using catalog::FinishedTile;
using navigability::Predictors;
using schema::TileRecord;
using tiles::Footprint;
using tiles::Navigability;
using tiles::NavigabilityPixel;
using tiles::Reason;

constexpr int kLeastView_px = 32;
constexpr int kRim_px = 16;               // for operators that look at neighbours, of map and view
constexpr int kPartsPerBlock = 2;         // a side: each has its own witness, so that one block keeps all threads busy
constexpr double kHitShare = 15.0 / 160;  // of the view's side: an answer this near is true
constexpr size_t kNodeBytes = tiles::kNavigabilityChannels;

// From these on a place is said to be so.
constexpr double kUniformStructure = 0.05, kStrongRival = 0.8, kWholeView = 0.95, kDisagreement = 0;

constexpr tiles::TileFormat kFormat{tiles::PixelType::kU8, uint8_t(kNodeBytes), 0};

int block_level(int level) { return level + layers::kBlockLog2; }

// Of a block of `level`, a side.
int nodes_of_block(int level) {
  return int(std::lround(tiles::tile_side(block_level(level)) / tiles::kNavigabilityGsd_m));
}

std::string journal_name(const Footprint& f) { return "found/" + tiles::layer_of(f); }

navigability::Footprint view_of(const Footprint& f) { return {f.template_m, f.search_m, kHitShare * f.template_m}; }

std::vector<features::GridImage> dates_in(const ingest::Stack& images, const tiles::PixelRect& rect) {
  std::vector<features::GridImage> out;
  const tiles::PixelRect seen = layers::intersection(rect, images.rect);
  if (seen.width == 0 || seen.height == 0) return out;
  const cv::Rect region = layers::region_of(seen, images.rect);
  for (const ingest::Epoch& epoch : images.epochs) {
    const cv::Mat valid = epoch.valid(region);
    if (cv::countNonZero(valid) == 0) continue;
    out.push_back({epoch.bands(region), valid, seen.west_m(), seen.north_m(), tiles::gsd_of(seen.level)});
  }
  return out;
}

uint16_t reasons_of(const Predictors& p, bool found_once) {
  unsigned out = 0;
  const auto say = [&](Reason reason, bool is_so) { out |= unsigned(is_so) << unsigned(reason); };
  say(Reason::kUniform, p.structure < kUniformStructure);
  say(Reason::kRepeats, p.look_alike && p.look_alike->strength >= kStrongRival);
  say(Reason::kNoData, p.coverage < kWholeView);
  say(Reason::kDatesDisagree, p.dates > 1 && p.mean_logit < kDisagreement && found_once);
  say(Reason::kOneDate, p.dates == 1);
  return uint16_t(out);
}

Navigability judged(const Predictors& p, double gsd_m) {
  Navigability out;
  out.fix_probability.fill(std::nan(""));
  for (const tiles::Finder finder : {tiles::Finder::kOrientation, tiles::Finder::kAuto})
    out.fix_probability[size_t(finder)] = navigability::fix_probability(p);
  const std::array<double, 4> c = navigability::fix_covariance_m2(p, gsd_m);
  const double mean = (c[0] + c[3]) / 2, half = std::hypot((c[0] - c[3]) / 2, c[1]);
  out.major_m = std::sqrt(mean + half);
  out.minor_m = std::sqrt(std::max(mean - half, 0.0));
  // Of (east, north): the angle from east, counterclockwise, is a quarter turn less this.
  out.direction_rad = std::numbers::pi / 2 - 0.5 * std::atan2(2 * c[1], c[0] - c[3]);
  if (p.look_alike) {
    out.rival_m = std::hypot(p.look_alike->east_m, p.look_alike->north_m);
    out.rival_bearing_rad = std::atan2(p.look_alike->east_m, p.look_alike->north_m);
    out.rival_strength = p.look_alike->strength;
  }
  out.reasons = reasons_of(p, p.found > 0);
  out.dates = unsigned(p.dates);
  return out;
}

// Writes what is said of the nodes in a part of a block.
void judge_part(const ingest::Stack& images, const tiles::PixelRect& part, const std::vector<Footprint>& footprints,
                int halo_px, const cv::Point& first, std::vector<cv::Mat>& nodes) {
  const std::vector<features::GridImage> dates = dates_in(images, layers::grown(part, halo_px));
  if (dates.empty()) return;
  const double gsd_m = tiles::gsd_of(part.level), step_m = tiles::kNavigabilityGsd_m;
  const int across = int(std::lround(double(part.width) * gsd_m / step_m));
  navigability::Witness witness(dates);
  for (int y = 0; y < across; ++y)
    for (int x = 0; x < across; ++x)
      for (size_t f = 0; f < footprints.size(); ++f) {
        const Predictors p =
            witness.at(part.west_m() + (x + 0.5) * step_m, part.north_m() - (y + 0.5) * step_m, view_of(footprints[f]));
        if (p.dates == 0) continue;
        const NavigabilityPixel pixel = tiles::encode_navigability(judged(p, gsd_m));
        std::copy(pixel.begin(), pixel.end(), nodes[f].ptr(first.y + y, first.x + x));
      }
}

std::vector<Footprint> footprints_at(const Plan& plan, int level) {
  std::vector<Footprint> out;
  for (const Footprint& f : plan.footprints)
    if (matched_level(f, plan.image_level) == level) out.push_back(f);
  return out;
}

// All landmarks of the pack, as its tiles hold them.
std::vector<tiles::Landmark> landmarks_of(const Catalog& catalog) {
  std::vector<tiles::Landmark> all, some;
  for (const TileRecord& record : catalog.tiles(exporter::kLandmarks, tiles::kVectorLevel)) {
    std::vector<uint8_t> data(record.length);
    catalog.read(record, data);
    if (tiles::decode_landmarks(tiles::tile_of_key(tiles::kVectorLevel, record.key), data, some))
      all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

// Entropy of the classes in a view over that of all classes alike (DeAngelo 2016 ch. 7), 0 to 1.
double diversity_of(const std::array<unsigned, tiles::kLandmarkClasses>& counts, unsigned all) {
  double entropy = 0;
  for (const unsigned count : counts)
    if (count > 0) entropy -= double(count) / all * std::log(double(count) / all);
  return entropy / std::log(double(counts.size()));
}

void count_landmarks(const landmarks::PointGrid& grid, const std::vector<tiles::Landmark>& all,
                     const cv::Point2d& middle, double view_m, Navigability& place) {
  std::array<unsigned, tiles::kLandmarkClasses> counts{};
  grid.within(middle, view_m * std::numbers::sqrt2 / 2, [&](const cv::Point2d& at, int id) {
    if (std::max(std::abs(at.x - middle.x), std::abs(at.y - middle.y)) <= view_m / 2)
      ++counts[size_t(all[size_t(id)].cls)];
  });
  place.landmarks = 0;
  for (const unsigned count : counts) place.landmarks += count;
  if (place.landmarks > 0) place.diversity = diversity_of(counts, place.landmarks);
}

// The nodes of one tile of the layer, CV_8UC(kNodeBytes).
cv::Mat nodes_of_tile(const Catalog& catalog, const std::vector<TileRecord>& blocks, const tiles::TileIndex& tile,
                      int level) {
  cv::Mat out = cv::Mat::zeros(tiles::kTilePixels, tiles::kTilePixels, CV_8UC(int(kNodeBytes)));
  const int side = nodes_of_block(level);
  for (const TileRecord& record : blocks) {
    const tiles::TileIndex block = tiles::tile_of_key(block_level(level), record.key);
    const int per_tile = tiles::kTilePixels / side;
    const cv::Rect place((block.x - tile.x * per_tile) * side, ((tile.y + 1) * per_tile - 1 - block.y) * side, side,
                         side);
    cv::Mat nodes(side, side, out.type());
    catalog.read(record, {nodes.ptr<uint8_t>(), record.length});
    nodes.copyTo(out(place));
  }
  return out;
}

// Counts the landmarks of every node in the area; without data beyond. Whether any is left.
bool finish_nodes(const Plan& plan, const std::vector<tiles::Landmark>& landmarks, const landmarks::PointGrid& grid,
                  const Footprint& f, const tiles::TileIndex& tile, cv::Mat& nodes) {
  const double side_m = tiles::tile_side(tile.level);
  bool any = false;
  for (int y = 0; y < nodes.rows; ++y) {
    for (int x = 0; x < nodes.cols; ++x) {
      uint8_t* pixel = nodes.ptr(y, x);
      std::optional<Navigability> place = tiles::decode_navigability({pixel, kNodeBytes});
      if (!place) continue;
      const cv::Point2d middle(tile.x * side_m + (x + 0.5) * tiles::kNavigabilityGsd_m,
                               (tile.y + 1) * side_m - (y + 0.5) * tiles::kNavigabilityGsd_m);
      if (!plan.area->bounds().contains(middle.x, middle.y)) {
        std::fill_n(pixel, kNodeBytes, uint8_t(0));
        continue;
      }
      count_landmarks(grid, landmarks, middle, f.template_m, *place);
      const NavigabilityPixel coded = tiles::encode_navigability(*place);
      std::copy(coded.begin(), coded.end(), pixel);
      any = true;
    }
  }
  return any;
}

FinishedTile encoded(const Footprint& f, const tiles::TileIndex& tile, const cv::Mat& nodes, const Catalog& catalog,
                     const std::vector<TileRecord>& blocks, const Plan& plan) {
  std::set<uint16_t> epochs;
  for (const TileRecord& record : blocks)
    for (const uint16_t epoch : catalog.epochs_of(record)) epochs.insert(epoch);
  FinishedTile out{tiles::layer_of(f), tile.level, {}, {}, {epochs.begin(), epochs.end()}};
  out.data = tiles::encode(tiles::Codec::kZstd, kFormat, {nodes.ptr<uint8_t>(), kFormat.bytes()}, plan.encoding);
  out.record.key = tiles::hilbert_key(tile);
  out.record.length = uint32_t(out.data.size());
  out.record.codec = uint8_t(tiles::Codec::kZstd);
  out.record.hash = catalog::hash_of(out.data);
  return out;
}

template <typename Visit>
void for_each_node(const Catalog& catalog, const TileRecord& record, Visit visit) {
  std::vector<uint8_t> data(record.length), pixels(kFormat.bytes());
  catalog.read(record, data);
  if (!tiles::decode(tiles::Codec(record.codec), kFormat, data, pixels)) return;
  for (size_t i = 0; i < pixels.size(); i += kNodeBytes)
    if (const auto place = tiles::decode_navigability(std::span(pixels).subspan(i, kNodeBytes))) visit(*place);
}

}  // namespace

int matched_level(const Footprint& footprint, int image_level) {
  const int level = int(std::floor(std::log2(footprint.template_m / kLeastView_px)));
  return std::clamp(level, image_level, tiles::kNavigabilityLevel - layers::kBlockLog2);
}

int navigability_halo_px(const Plan& plan, int level) {
  int halo_px = 0;
  for (const Footprint& f : footprints_at(plan, level))
    halo_px = std::max(halo_px, int(std::ceil((f.template_m / 2 + f.search_m) / tiles::gsd_of(level))) + kRim_px);
  return halo_px;
}

std::vector<FinishedTile> judge_places(const Plan& plan, const ingest::Stack& images, const tiles::TileIndex& block) {
  const int level = images.rect.level;
  const std::vector<Footprint> footprints = footprints_at(plan, level);
  if (footprints.empty() || images.epochs.empty()) return {};
  const int side = nodes_of_block(level), part_nodes = std::max(1, side / kPartsPerBlock);
  const tiles::PixelRect core = layers::pixels_of(block, level);
  std::vector<cv::Mat> nodes;
  for (size_t f = 0; f < footprints.size(); ++f) nodes.push_back(cv::Mat::zeros(side, side, CV_8UC(int(kNodeBytes))));
  const int parts = side / part_nodes, part_px = int(core.width) / parts, halo_px = navigability_halo_px(plan, level);
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(0, parts * parts, [&](int i) {
      const int x = i % parts, y = i / parts;
      judge_part(images, {level, core.column + x * part_px, core.row + y * part_px, part_px, part_px}, footprints,
                 halo_px, {x * part_nodes, y * part_nodes}, nodes);
    });
  });
  std::vector<FinishedTile> out;
  catalog::EpochSet epochs;
  for (const ingest::Epoch& epoch : images.epochs) epochs.push_back(uint16_t(epoch.index));
  std::ranges::sort(epochs);
  for (size_t f = 0; f < footprints.size(); ++f) {
    FinishedTile tile{journal_name(footprints[f]), block.level, {}, {nodes[f].datastart, nodes[f].dataend}, epochs};
    tile.record.key = tiles::hilbert_key(block);
    tile.record.length = uint32_t(tile.data.size());
    tile.record.hash = catalog::hash_of(tile.data);
    out.push_back(std::move(tile));
  }
  return out;
}

exporter::PackLayer navigability_layer(const Footprint& footprint) {
  exporter::PackLayer layer;
  layer.name = tiles::layer_of(footprint);
  layer.description = fmt::format(
      "how well a camera that sees {} m finds itself, up to {} m off: chances by matcher, spread, look-alike, "
      "landmarks, reasons",
      footprint.template_m, footprint.search_m);
  layer.format = kFormat;
  layer.levels.push_back({tiles::kNavigabilityLevel, {}});
  return layer;
}

std::vector<FinishedTile> link_navigability(const Plan& plan, const Catalog& catalog) {
  const std::vector<tiles::Landmark> landmarks =
      plan.landmarks ? landmarks_of(catalog) : std::vector<tiles::Landmark>{};
  landmarks::PointGrid grid(tiles::kNavigabilityGsd_m);
  for (size_t i = 0; i < landmarks.size(); ++i) grid.add({landmarks[i].east_m, landmarks[i].north_m}, int(i));
  std::vector<FinishedTile> out;
  for (const Footprint& f : plan.footprints) {
    const int level = matched_level(f, plan.image_level);
    std::map<uint64_t, std::vector<TileRecord>> blocks;  // by tile
    for (const TileRecord& record : catalog.tiles(journal_name(f), block_level(level)))
      blocks[record.key >> 2 * (tiles::kNavigabilityLevel - block_level(level))].push_back(record);
    for (const auto& [key, records] : blocks) {
      const tiles::TileIndex tile = tiles::tile_of_key(tiles::kNavigabilityLevel, key);
      cv::Mat nodes = nodes_of_tile(catalog, records, tile, level);
      if (!finish_nodes(plan, landmarks, grid, f, tile, nodes)) continue;
      out.push_back(encoded(f, tile, nodes, catalog, records, plan));
    }
  }
  return out;
}

std::vector<std::string> text_of_navigability(const Plan& plan, const Catalog& catalog) {
  std::vector<std::string> out;
  for (const Footprint& f : plan.footprints) {
    std::vector<double> chances;
    for (const TileRecord& record : catalog.tiles(tiles::layer_of(f), tiles::kNavigabilityLevel))
      for_each_node(catalog, record,
                    [&](const Navigability& n) { chances.push_back(n.fix_probability[size_t(tiles::Finder::kAuto)]); });
    if (chances.empty()) {
      out.push_back(tiles::layer_of(f) + ": no place can be judged");
      continue;
    }
    std::ranges::sort(chances);
    out.push_back(fmt::format("{}: {} places; chance of a fix {:.2f} at the median, below {:.2f} at a tenth of them",
                              tiles::layer_of(f), chances.size(), chances[chances.size() / 2],
                              chances[chances.size() / 10]));
  }
  return out;
}

}  // namespace landfix
