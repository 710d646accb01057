#include "builder/map_navigability.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "builder/ground_cover.h"
#include "builder/layers/layer.h"
#include "builder/layers/window.h"
#include "builder/navigability/model.h"
#include "runtime/nav/pack_map.h"

namespace landfix {
namespace {

using catalog::FinishedTile;
using navigability::Predictors;
using tiles::Finder;
using tiles::Footprint;
using tiles::Navigability;
using tiles::NavigabilityPixel;
using tiles::Reason;

constexpr int kLeastView_px = 32;
constexpr int kRim_px = 16;        // for operators that look at neighbours, of map and view
constexpr int kPartsPerBlock = 2;  // a side: each has its own witness, so that one block keeps all threads busy

// From these on a place is said to be so.
constexpr double kUniformStructure = 0.15, kStrongRival = 0.8, kWholeView = 0.95, kDisagreement = 0;

navigability::Footprint view_of(const Footprint& f) {
  return {f.template_m, f.search_m, tiles::kHitShare * f.template_m};
}

// What the epochs show in a rectangle, the newest first, and on which days.
struct Dates {
  std::vector<features::GridImage> images;
  std::vector<std::optional<int>> days;
};

Dates dates_in(const ingest::Stack& images, const tiles::PixelRect& rect) {
  Dates out;
  const tiles::PixelRect seen = layers::intersection(rect, images.rect);
  if (seen.width == 0 || seen.height == 0) return out;
  const cv::Rect region = layers::region_of(seen, images.rect);
  for (const ingest::Epoch& epoch : images.epochs) {
    const cv::Mat valid = epoch.valid(region);
    if (cv::countNonZero(valid) == 0) continue;
    // Of two bands no matcher makes anything.
    const cv::Mat bands =
        epoch.roles.size() == 2 ? layers::newest({images.rect, {epoch}}, seen, 1).pixels : epoch.bands(region);
    out.images.push_back({bands, valid, seen.west_m(), seen.north_m(), tiles::gsd_of(seen.level)});
    out.days.push_back(nav::day_of(epoch.date.c_str()));
  }
  return out;
}

uint16_t reasons_of(const Predictors& p) {
  unsigned out = 0;
  const auto say = [&](Reason reason, bool is_so) { out |= unsigned(is_so) << unsigned(reason); };
  say(Reason::kUniform, p.structure < kUniformStructure);
  say(Reason::kRepeats, p.look_alike && p.look_alike->strength >= kStrongRival && p.structure >= kUniformStructure);
  say(Reason::kNoData, p.coverage < kWholeView);
  say(Reason::kDatesDisagree, p.dates > 1 && p.mean_logit < kDisagreement && p.found > 0);
  say(Reason::kOneDate, p.dates == 1);
  return uint16_t(out);
}

void tell_spread(const Predictors& p, double gsd_m, Navigability& out) {
  const std::array<double, 4> c = navigability::fix_covariance_m2(p, gsd_m);
  const double mean = (c[0] + c[3]) / 2, half = std::hypot((c[0] - c[3]) / 2, c[1]);
  out.major_m = std::sqrt(mean + half);
  out.minor_m = std::sqrt(std::max(mean - half, 0.0));
  // Of (east, north): the angle from east, counterclockwise, is a quarter turn less this.
  out.direction_rad = std::numbers::pi / 2 - 0.5 * std::atan2(2 * c[1], c[0] - c[3]);
}

// By the matcher that is asked first; what `auto` gains by the others did not show on real images.
Navigability judged(const Plan& plan, const Predictors& p, const std::optional<int>& day, double gsd_m) {
  Navigability out;
  out.fix_probability.fill(std::nan(""));
  const nav::Method first = plan.matchers[0];
  const double chance = navigability::fix_probability(p, first);
  out.fix_probability[size_t(Finder::kAuto)] = out.fix_probability[size_t(finder_of(first))] = chance;
  out.false_probability = navigability::false_fix_probability(chance);
  tell_spread(p, gsd_m, out);
  if (p.look_alike) {
    out.rival_m = std::hypot(p.look_alike->east_m, p.look_alike->north_m);
    out.rival_bearing_rad = std::atan2(p.look_alike->east_m, p.look_alike->north_m);
    out.rival_strength = p.look_alike->strength;
  }
  out.reasons = reasons_of(p);
  out.dates = unsigned(p.dates);
  out.newest_day = day;
  return out;
}

// A part of a block, whose nodes are judged one after the other.
struct Part {
  tiles::PixelRect rect;
  cv::Point first;  // of its nodes, in the block
};

// Writes what is said of the nodes in a part of a block.
void judge_part(const Plan& plan, const ingest::Stack& images, const Part& part,
                const std::vector<Footprint>& footprints, std::vector<cv::Mat>& nodes) {
  const int level = part.rect.level;
  const Dates dates = dates_in(images, layers::grown(part.rect, navigability_halo_px(plan, level)));
  if (dates.images.empty()) return;
  const double gsd_m = tiles::gsd_of(level), step_m = tiles::kNavigabilityGsd_m;
  const int across = int(std::lround(double(part.rect.width) * gsd_m / step_m));
  const auto column = std::lround(part.rect.west_m() / step_m), row = std::lround(part.rect.north_m() / step_m);
  navigability::Witness witness(dates.images, plan.matchers);
  for (int i = 0; i < across * across; ++i) {
    const int x = i % across, y = i / across;
    const double east_m = part.rect.west_m() + (x + 0.5) * step_m, north_m = part.rect.north_m() - (y + 0.5) * step_m;
    const bool by_all = (column + x) % 2 == 0 && (row - y) % 2 == 0;
    for (size_t f = 0; f < footprints.size(); ++f) {
      const navigability::Footprint view = view_of(footprints[f]);
      const Predictors p = witness.at(east_m, north_m, view, plan.matchers[0]);
      if (p.dates == 0) continue;
      Navigability place = judged(plan, p, dates.days[size_t(p.newest)], gsd_m);
      for (size_t m = 1; m < plan.matchers.size() && by_all; ++m)
        place.fix_probability[size_t(finder_of(plan.matchers[m]))] =
            navigability::fix_probability(witness.at(east_m, north_m, view, plan.matchers[m]), plan.matchers[m]);
      const NavigabilityPixel pixel = tiles::encode_navigability(place);
      std::ranges::copy(pixel, nodes[f].ptr(part.first.y + y, part.first.x + x));
    }
  }
}

std::vector<Footprint> footprints_at(const Plan& plan, int level) {
  std::vector<Footprint> out;
  for (const Footprint& f : plan.footprints)
    if (matched_level(f, plan.image_level) == level) out.push_back(f);
  return out;
}

bool describes(const Plan& plan, int level) { return !plan.footprints.empty() && level == ground_level(plan); }

std::vector<cv::Mat> judge_block(const Plan& plan, const ingest::Stack& images, const tiles::TileIndex& block,
                                 const std::vector<Footprint>& footprints) {
  const int level = images.rect.level, side = JudgedBlocks(footprints[0], plan.image_level).side_nodes;
  const int parts = std::min(kPartsPerBlock, side), part_nodes = side / parts;
  const tiles::PixelRect core = layers::pixels_of(block, level);
  const int part_px = int(core.width) / parts;
  std::vector<cv::Mat> nodes;
  for (size_t f = 0; f < footprints.size(); ++f)
    nodes.push_back(cv::Mat::zeros(side, side, CV_8UC(int(tiles::kNavigabilityChannels))));
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(0, parts * parts, [&](int i) {
      const int x = i % parts, y = i / parts;
      judge_part(plan, images,
                 {{level, core.column + x * part_px, core.row + y * part_px, part_px, part_px},
                  {x * part_nodes, y * part_nodes}},
                 footprints, nodes);
    });
  });
  return nodes;
}

}  // namespace

int matched_level(const Footprint& footprint, int image_level) {
  const int level = int(std::floor(std::log2(footprint.template_m / kLeastView_px)));
  return std::clamp(level, image_level, tiles::kNavigabilityLevel - layers::kBlockLog2);
}

int navigability_halo_px(const Plan& plan, int level) {
  int halo_px = describes(plan, level) ? ground_halo_px(plan) : 0;
  for (const Footprint& f : footprints_at(plan, level))
    halo_px = std::max(halo_px, int(std::ceil((f.template_m / 2 + f.search_m) / tiles::gsd_of(level))) + kRim_px);
  return halo_px;
}

bool judges(const Plan& plan, int level) { return describes(plan, level) || !footprints_at(plan, level).empty(); }

JudgedBlocks::JudgedBlocks(const Footprint& footprint, int image_level)
    : name("found/" + tiles::layer_of(footprint)), level(matched_level(footprint, image_level) + layers::kBlockLog2) {
  side_nodes = int(std::lround(tiles::tile_side(level) / tiles::kNavigabilityGsd_m));
}

Finder finder_of(nav::Method method) {
  switch (method) {
    case nav::Method::kGray:
      return Finder::kGray;
    case nav::Method::kEdge:
      return Finder::kEdge;
    case nav::Method::kContour:
      return Finder::kContour;
    case nav::Method::kOrientation:
      break;
  }
  return Finder::kOrientation;
}

std::vector<FinishedTile> judge_places(const Plan& plan, const ingest::Stack& images, const tiles::TileIndex& block) {
  std::vector<FinishedTile> out;
  if (images.epochs.empty()) return out;
  catalog::EpochSet epochs;
  for (const ingest::Epoch& epoch : images.epochs) epochs.push_back(uint16_t(epoch.index));
  std::ranges::sort(epochs);
  if (const std::vector<Footprint> footprints = footprints_at(plan, images.rect.level); !footprints.empty()) {
    const std::vector<cv::Mat> nodes = judge_block(plan, images, block, footprints);
    for (size_t f = 0; f < footprints.size(); ++f)
      out.push_back(catalog::finished_tile(JudgedBlocks(footprints[f], plan.image_level).name, block,
                                           {nodes[f].datastart, nodes[f].dataend}));
  }
  if (describes(plan, images.rect.level)) out.push_back(describe_ground(plan, images, block));
  for (FinishedTile& tile : out) tile.epochs = epochs;
  return out;
}

}  // namespace landfix
