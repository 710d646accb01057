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
  features::GridImage heights;  // without pixels where none are known, or not asked for
};

Dates dates_in(const Plan& plan, const ingest::Stack& images, const tiles::PixelRect& rect) {
  Dates out;
  const tiles::PixelRect seen = layers::intersection(rect, images.rect);
  if (seen.width == 0 || seen.height == 0) return out;
  const cv::Rect region = layers::region_of(seen, images.rect);
  int whole = 0;
  for (const ingest::Epoch& epoch : images.epochs) {
    const cv::Mat valid = epoch.valid(region);
    if (cv::countNonZero(valid) == 0) continue;
    // Of two bands no matcher makes anything.
    const cv::Mat bands =
        epoch.roles.size() == 2 ? layers::newest({images.rect, {epoch}}, seen, 1).pixels : epoch.bands(region);
    out.images.push_back({bands, valid, seen.west_m(), seen.north_m(), tiles::gsd_of(seen.level)});
    out.days.push_back(nav::day_of(epoch.date.c_str()));
    whole += cv::countNonZero(valid) == int(valid.total());
  }
  if (plan.elevation && whole < 2) {  // somewhere one date may be alone: views are drawn there
    out.heights = plan.elevation->read(seen);
    out.heights.west_m = seen.west_m();
    out.heights.north_m = seen.north_m();
    out.heights.gsd_m = tiles::gsd_of(seen.level);
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

// Writes what is said of the nodes in a part of a block, the nodes of each footprint in an image of their own.
void judge_part(const Plan& plan, const ingest::Stack& images, const tiles::PixelRect& part,
                const std::vector<Footprint>& footprints, std::vector<cv::Mat>& nodes) {
  const Dates dates = dates_in(plan, images, layers::grown(part, navigability_halo_px(plan, part.level)));
  if (dates.images.empty()) return;
  const double gsd_m = tiles::gsd_of(part.level);
  navigability::Witness witness(dates.images, plan.matchers, dates.heights);
  for (size_t f = 0; f < footprints.size(); ++f) {
    const navigability::Footprint view = view_of(footprints[f]);
    const double step_m = tiles::node_spacing_m(footprints[f]);
    const int stride = nodes_per_view(footprints[f]);
    const auto column = std::lround(part.west_m() / step_m), row = std::lround(part.north_m() / step_m);
    for (int i = 0; i < int(nodes[f].total()); ++i) {
      const int x = i % nodes[f].cols, y = i / nodes[f].cols;
      const double east_m = part.west_m() + (x + 0.5) * step_m, north_m = part.north_m() - (y + 0.5) * step_m;
      const Predictors p = witness.at(east_m, north_m, view, plan.matchers[0]);
      if (p.dates == 0) continue;
      Navigability place = judged(plan, p, dates.days[size_t(p.newest)], gsd_m);
      const bool by_all = (column + x) % stride == 0 && (row - y) % stride == 0;
      for (size_t m = 1; m < plan.matchers.size() && by_all; ++m)
        place.fix_probability[size_t(finder_of(plan.matchers[m]))] =
            navigability::fix_probability(witness.at(east_m, north_m, view, plan.matchers[m]), plan.matchers[m]);
      std::ranges::copy(tiles::encode_navigability(place), nodes[f].ptr(y, x));
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
  std::vector<cv::Mat> nodes;
  int parts = kPartsPerBlock;
  for (const Footprint& f : footprints) {
    const int side = JudgedBlocks(f, plan.image_level).side_nodes;
    nodes.push_back(cv::Mat::zeros(side, side, CV_8UC(int(tiles::kNavigabilityChannels))));
    parts = std::min(parts, side);
  }
  const tiles::PixelRect core = layers::pixels_of(block, images.rect.level);
  const int part_px = int(core.width) / parts;
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(0, parts * parts, [&](int i) {
      const int x = i % parts, y = i / parts;
      std::vector<cv::Mat> own;
      for (const cv::Mat& all : nodes) {
        const int side = all.cols / parts;
        own.push_back(all(cv::Rect(x * side, y * side, side, side)));
      }
      judge_part(plan, images, {core.level, core.column + x * part_px, core.row + y * part_px, part_px, part_px},
                 footprints, own);
    });
  });
  return nodes;
}

}  // namespace

int matched_level(const Footprint& footprint, int image_level) {
  const int level = int(std::floor(std::log2(footprint.template_m / kLeastView_px)));
  return std::max(image_level, std::min(level, tiles::navigability_level(footprint) - layers::kBlockLog2));
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
  side_nodes = int(std::lround(tiles::tile_side(level) / tiles::node_spacing_m(footprint)));
}

int nodes_per_view(const Footprint& f) { return std::max(2, int(f.template_m / tiles::node_spacing_m(f))); }

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
