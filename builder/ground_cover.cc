#include "builder/ground_cover.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "builder/landmarks/object_model.h"
#include "builder/layers/layer.h"
#include "builder/layers/window.h"
#include "tiles/navigability.h"

namespace landfix {
namespace {

using catalog::FinishedTile;

// Names in the journal; no layer of a pack can have them.
constexpr char kFoundGround[] = "found/ground", kFoundCovers[] = "found/covers";

constexpr double kWaterIndex = 0.1;      // of (green - infrared) / (green + infrared): water is above
constexpr double kShadowTone = 0.6;      // of the mean around: shadow is below
constexpr double kShadowWindow_m = 30;   // larger than a shadow, smaller than a field
constexpr double kCoarsestShadow_m = 2;  // in larger pixels none is resolved
constexpr int kMostShare = 254;
constexpr int kSquareLevel = 6;  // shares are kept of squares as large as its pixels

int side_of_node_px(int level) { return int(std::lround(tiles::gsd_of(kSquareLevel - level))); }

// A square of the map, in pixels that show it: of each kind of ground, and how many could have.
struct Count {
  std::array<int, kGrounds> is{}, seen{};
};

uint8_t code_of(int is, int seen) { return uint8_t(seen > 0 ? 1 + (kMostShare * is + seen / 2) / seen : 0); }

// A byte for each kind of ground and square, rows from the north: 0 not known, 1 to 255 the share.
FinishedTile journal_tile(const char* name, const tiles::TileIndex& block, const std::vector<Count>& counts) {
  std::vector<uint8_t> data;
  for (const Count& c : counts)
    for (size_t g = 0; g < kGrounds; ++g) data.push_back(code_of(c.is[g], c.seen[g]));
  return catalog::finished_tile(name, block, std::move(data));
}

// Adds the pixels of a block: `mask` 255 where they are such ground, `seen` 255 where that can be told.
void add(Ground ground, const cv::Mat& mask, const cv::Mat& seen, std::vector<Count>& counts) {
  const int across = int(std::lround(std::sqrt(double(counts.size())))), side = mask.cols / across;
  for (int i = 0; i < across * across; ++i) {
    const cv::Rect square(i % across * side, i / across * side, side, side);
    Count& c = counts[size_t(i)];
    c.seen[size_t(ground)] += cv::countNonZero(seen(square));
    c.is[size_t(ground)] += cv::countNonZero(mask(square) & seen(square));
  }
}

int nodes_of_block(int level) { return (tiles::kTilePixels << layers::kBlockLog2) / side_of_node_px(level); }

std::vector<Count> counts_of_block(int level) {
  const auto across = size_t(nodes_of_block(level));
  return std::vector<Count>(across * across);
}

int channel_of(const ingest::Epoch& epoch, ingest::BandRole role) {
  const auto it = std::ranges::find(epoch.roles, role);
  return it == epoch.roles.end() ? -1 : int(it - epoch.roles.begin());
}

// Where an epoch shows water, and where it shows anything; nothing without the bands for it.
void find_water(const ingest::Epoch& epoch, const cv::Rect& region, cv::Mat& water, cv::Mat& seen) {
  const int green = channel_of(epoch, ingest::BandRole::kGreen), nir = channel_of(epoch, ingest::BandRole::kNir);
  if (green < 0 || nir < 0) return;
  cv::Mat g, n;
  cv::extractChannel(epoch.bands(region), g, green);
  cv::extractChannel(epoch.bands(region), n, nir);
  g.convertTo(g, CV_32F);
  n.convertTo(n, CV_32F);
  const cv::Mat fresh = epoch.valid(region) & (seen == 0);  // nothing newer shows it
  const cv::Mat found = (g - n) > kWaterIndex * (g + n);
  found.copyTo(water, fresh);
  seen.setTo(255, fresh);
}

// Pixels darker than what is around them.
cv::Mat shadow_in(const cv::Mat& gray, const cv::Mat& valid, double gsd_m) {
  cv::Mat values, weights, mean, weight;
  gray.convertTo(values, CV_32F);
  valid.convertTo(weights, CV_32F, 1.0 / 255);
  const int side = 2 * int(std::lround(kShadowWindow_m / 2 / gsd_m)) + 1;
  cv::boxFilter(values.mul(weights), mean, CV_32F, {side, side}, {-1, -1}, false, cv::BORDER_CONSTANT);
  cv::boxFilter(weights, weight, CV_32F, {side, side}, {-1, -1}, false, cv::BORDER_CONSTANT);
  return values.mul(weight) < kShadowTone * mean;
}

}  // namespace

int ground_level(const Plan& plan) { return std::max(plan.image_level, kFeatureLevel); }

int ground_halo_px(const Plan& plan) {
  const double gsd_m = tiles::gsd_of(ground_level(plan));
  return gsd_m > kCoarsestShadow_m ? 0 : int(std::lround(kShadowWindow_m / 2 / gsd_m));
}

FinishedTile describe_ground(const Plan& plan, const ingest::Stack& images, const tiles::TileIndex& block) {
  const int level = images.rect.level;
  const double gsd_m = tiles::gsd_of(level);
  std::vector<Count> counts = counts_of_block(level);
  const tiles::PixelRect core = layers::pixels_of(block, level), shown = layers::intersection(core, images.rect);
  const cv::Rect whole = layers::region_of(shown, core);
  const cv::Size size(int(core.width), int(core.height));
  cv::Mat water = cv::Mat::zeros(size, CV_8U), seen = cv::Mat::zeros(size, CV_8U);
  if (!whole.empty()) {
    cv::Mat water_shown = water(whole), seen_shown = seen(whole);
    for (const ingest::Epoch& epoch : images.epochs)
      find_water(epoch, layers::region_of(shown, images.rect), water_shown, seen_shown);
  }
  add(Ground::kWater, water, seen, counts);
  if (gsd_m <= kCoarsestShadow_m) {
    const tiles::PixelRect around = layers::grown(core, ground_halo_px(plan));
    if (const layers::Newest newest = layers::newest(images, around, 1); !newest.pixels.empty()) {
      const cv::Mat valid = newest.owner > 0;
      const cv::Rect middle = layers::region_of(core, around);
      add(Ground::kShadow, shadow_in(newest.pixels, valid, gsd_m)(middle), valid(middle), counts);
    }
  }
  return journal_tile(kFoundGround, block, counts);
}

FinishedTile describe_covers(const tiles::TileIndex& block, std::span<const cv::Mat> covers) {
  std::vector<Count> counts = counts_of_block(kFeatureLevel);
  for (const cv::Mat& cover : covers) {
    const cv::Mat seen = cover != landmarks::kNoCover;
    add(Ground::kWater, cover == uint8_t(landmarks::Cover::kWater), seen, counts);
    add(Ground::kWood, cover == uint8_t(landmarks::Cover::kTree), seen, counts);
  }
  return journal_tile(kFoundCovers, block, counts);
}

struct GroundMap::Sums {
  cv::Mat shares, known;  // CV_64FC1, integrals
};

GroundMap::~GroundMap() = default;

GroundMap::GroundMap(const Plan& plan, const catalog::Catalog& catalog)
    : nodes_(ingest::pixels_covering(plan.description.bounds, kSquareLevel)) {
  const int block_level = ground_level(plan) + layers::kBlockLog2;
  cv::Mat codes = cv::Mat::zeros(int(nodes_.height), int(nodes_.width), CV_8UC(int(kGrounds)));
  const cv::Rect map({}, codes.size());
  // What both tell of the infrared knows better.
  for (const char* name : {kFoundCovers, kFoundGround}) {
    for (const schema::TileRecord& record : catalog.tiles(name, block_level)) {
      const tiles::TileIndex block = tiles::tile_of_key(block_level, record.key);
      const int side = nodes_of_block(ground_level(plan));
      cv::Mat cells(side, side, codes.type());
      catalog.read(record, {cells.ptr<uint8_t>(), record.length});
      const cv::Point corner(int(int64_t(block.x) * side - nodes_.column),
                             int(-int64_t(block.y + 1) * side - nodes_.row));
      const cv::Rect inside = cv::Rect(corner, cells.size()) & map;
      if (inside.empty()) continue;
      cv::Mat there = codes(inside).reshape(1), here = cells(inside - corner).clone().reshape(1);
      here.copyTo(there, here != 0);
    }
  }
  std::vector<cv::Mat> planes;
  cv::split(codes, planes);
  for (const cv::Mat& plane : planes) {
    const cv::Mat known = plane != 0;
    cv::Mat shares;
    plane.convertTo(shares, CV_64F, 1.0 / kMostShare, -1.0 / kMostShare);
    shares.setTo(0, ~known);
    Sums& sums = sums_.emplace_back();
    cv::integral(shares, sums.shares, CV_64F);
    cv::integral(known / 255, sums.known, CV_64F);
  }
}

std::optional<double> GroundMap::share(Ground ground, double east_m, double north_m, double side_m) const {
  const double node_m = tiles::gsd_of(kSquareLevel);
  const int reach = std::max(0, int(std::lround((side_m / node_m - 1) / 2)));
  const cv::Point middle(int(std::floor(east_m / node_m) - double(nodes_.column)),
                         int(std::floor(-north_m / node_m) - double(nodes_.row)));
  const cv::Rect square = cv::Rect(middle.x - reach, middle.y - reach, 2 * reach + 1, 2 * reach + 1) &
                          cv::Rect(0, 0, int(nodes_.width), int(nodes_.height));
  if (square.empty()) return std::nullopt;
  const auto sum = [&](const cv::Mat_<double>& s) {
    return s(square.br()) - s(square.y, square.br().x) - s(square.br().y, square.x) + s(square.tl());
  };
  const Sums& sums = sums_[size_t(ground)];
  const double known = sum(sums.known);
  return known > 0 ? std::optional(sum(sums.shares) / known) : std::nullopt;
}

}  // namespace landfix
