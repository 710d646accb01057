// The layers of edges, contours and orientation: tiles against the same operator on the whole image, bit for bit.
#include <gtest/gtest.h>

#include "builder/layers/dated.h"
#include "builder/layers/registry.h"
#include "builder/layers/window.h"
#include "runtime/features/contour.h"
#include "runtime/features/edge.h"
#include "runtime/features/orientation.h"
#include "runtime/features/orientation_code.h"
#include "tests/features/draw.h"

namespace landfix::layers {
namespace {

using features::mask_with_holes;
using features::same;
using features::scene;
using ingest::BandRole;
using tiles::PixelRect;
using tiles::TileIndex;

const std::vector<BandRole> kRgb = {BandRole::kRed, BandRole::kGreen, BandRole::kBlue};
const std::vector<BandRole> kRgbn = {BandRole::kRed, BandRole::kGreen, BandRole::kBlue, BandRole::kNir};

// The tiles (3, 5), (4, 5), (3, 6) and (4, 6), and an image that covers parts of all of them.
constexpr int kLevel = 1;
constexpr PixelRect kAll{kLevel, 3 * 256 + 40, -7 * 256 + 30, 430, 450};
const TileIndex kTiles[] = {{kLevel, 3, 5}, {kLevel, 4, 5}, {kLevel, 3, 6}, {kLevel, 4, 6}};

ingest::Epoch epoch(size_t index, std::vector<BandRole> roles, uint64_t seed, const cv::Mat& valid) {
  ingest::Epoch e;
  e.index = index;
  e.bands = scene(valid.cols, valid.rows, int(roles.size()), seed);
  e.bands.setTo(cv::Scalar::all(0), valid == 0);
  e.valid = valid;
  e.roles = std::move(roles);
  return e;
}

// What `all` shows in `rect`, as the pipeline reads it: no further than the inputs reach.
SourceWindow window_of(const ingest::Stack& all, const PixelRect& rect) {
  SourceWindow w;
  w.rect = w.images.rect = intersection(rect, all.rect);
  for (ingest::Epoch e : all.epochs) {
    e.bands = e.bands(region_of(w.rect, all.rect)).clone();
    e.valid = e.valid(region_of(w.rect, all.rect)).clone();
    if (cv::countNonZero(e.valid) > 0) w.images.epochs.push_back(std::move(e));
  }
  w.gray = newest(w.images, w.rect, 1);
  return w;
}

// Two dates with other bands and holes; the newer one lies in the west only.
ingest::Stack two_dates() {
  cv::Mat west = mask_with_holes(int(kAll.width), int(kAll.height), 1);
  west.colRange(250, west.cols).setTo(0);
  return {kAll, {epoch(0, kRgb, 2, west), epoch(2, kRgbn, 3, mask_with_holes(int(kAll.width), int(kAll.height), 4))}};
}

ingest::Stack one_date() { return {kAll, {epoch(0, kRgb, 5, mask_with_holes(int(kAll.width), int(kAll.height), 6))}}; }

// The tile's part of an image of kAll, 0 elsewhere.
cv::Mat tile_of(const cv::Mat& whole, const TileIndex& tile) {
  const PixelRect rect = pixels_of(tile, kLevel), common = intersection(rect, kAll);
  cv::Mat out = cv::Mat::zeros(256, 256, whole.type());
  whole(region_of(common, kAll)).copyTo(out(region_of(common, rect)));
  return out;
}

// Every tile from a window that is no larger than the layer's halo asks for.
void expect_tiles(const RasterLayer& layer, const ingest::Stack& stack, const cv::Mat& whole) {
  for (const TileIndex& tile : kTiles) {
    const PixelRect rect = grown(pixels_of(tile, kLevel), layer.info().halo_px);
    const TileData data = layer.compute(window_of(stack, rect), tile);
    ASSERT_FALSE(data.empty());
    EXPECT_TRUE(same(data.pixels, tile_of(whole, tile))) << layer.info().name << " " << tile.x << " " << tile.y;
  }
}

TEST(EdgeLayer, TilesAreTheOperatorOnTheWholeImage) {
  const ingest::Stack stack = one_date();
  const Newest shown = newest(stack, kAll, 1);
  cv::Mat whole;
  features::edge(shown.pixels, stack.epochs[0].valid, whole);
  ASSERT_GT(cv::countNonZero(whole), 100'000);
  expect_tiles(edge_layer(), stack, whole);
}

TEST(ContourLayer, TilesAreTheOperatorOnTheWholeImage) {
  const ingest::Stack stack = one_date();
  const Newest shown = newest(stack, kAll, 1);
  cv::Mat mask, known, whole;
  features::contours(shown.pixels, stack.epochs[0].valid, {}, mask, known);
  features::contour_distance(mask, known, {}, whole);
  ASSERT_GT(cv::countNonZero(mask), 3000);
  expect_tiles(contour_layer(), stack, whole);
}

TEST(OrientationLayer, TilesAreTheMeanOverTheDatesOfTheWholeImage) {
  const ingest::Stack stack = two_dates();
  std::vector<features::DatedOrientation> dates(2);
  for (size_t i = 0; i < 2; ++i)
    features::orientation(stack.epochs[i].bands, stack.epochs[i].valid, {}, dates[i].ab, dates[i].valid);
  const features::DatedOrientation fused = features::fuse(dates);
  for (const TileIndex& tile : kTiles) {
    const PixelRect rect = grown(pixels_of(tile, kLevel), features::kOrientationHaloPx);
    const TileData data = orientation_layer().compute(window_of(stack, rect), tile);
    cv::Mat levels, planes;
    features::orientation_levels(tile_of(fused.ab, tile), levels);
    features::pack_orientation(levels, tile_of(fused.valid, tile), planes);
    ASSERT_EQ(data.pixels.size(), cv::Size(32, features::kOrientationPlanes * 256));
    EXPECT_TRUE(same(data.pixels, planes)) << tile.x << " " << tile.y;
    EXPECT_EQ(data.pixels.total(), orientation_layer().info().format.bytes());
    // The newer date ends 250 columns into the image: 34 pixels into the eastern tiles.
    EXPECT_EQ(data.epochs, (std::vector<uint16_t>{0, 2}));
  }
}

TEST(FeatureLayers, NameOnlyTheEpochsThatWentIntoATile) {
  ingest::Stack stack = two_dates();
  stack.epochs[0].valid.colRange(200, stack.epochs[0].valid.cols).setTo(0);  // nothing of the newer one in the east
  const TileIndex east = kTiles[1];
  for (const RasterLayer* layer : {&gray_layer(), &edge_layer(), &contour_layer(), &orientation_layer()})
    EXPECT_EQ(layer->compute(window_of(stack, kAll), east).epochs, (std::vector<uint16_t>{2})) << layer->info().name;
}

// Two flat dates of different brightness: where one ends there is no edge of the ground.
TEST(FeatureLayers, SeeNoEdgeWhereDatesMeet) {
  cv::Mat all(int(kAll.height), int(kAll.width), CV_8UC1, cv::Scalar(255)), west = all.clone();
  west.colRange(150, west.cols).setTo(0);
  ingest::Stack stack{kAll, {epoch(0, {BandRole::kGray}, 7, west), epoch(1, {BandRole::kGray}, 7, all)}};
  stack.epochs[0].bands.setTo(40);
  stack.epochs[1].bands.setTo(200);
  const SourceWindow window = window_of(stack, kAll);
  const cv::Mat edges = edge_layer().compute(window, kTiles[2]).pixels;
  EXPECT_EQ(cv::countNonZero(edges > 1), 0);
  EXPECT_GT(cv::countNonZero(edges == 1), 30'000);
  const cv::Mat distance = contour_layer().compute(window, kTiles[2]).pixels;
  EXPECT_EQ(cv::countNonZero(distance) - cv::countNonZero(distance == 1 + 8), 0);
}

TEST(FeatureLayers, HaveNoTileWithoutData) {
  ingest::Stack stack = one_date();
  stack.epochs[0].valid.setTo(0);
  stack.epochs[0].valid(cv::Rect(30, 30, 6, 6)).setTo(255);  // too small for any gradient; an edge needs 5x5
  for (const RasterLayer* layer : {&contour_layer(), &orientation_layer(), &agreement_layer()})
    EXPECT_TRUE(layer->compute(window_of(stack, kAll), kTiles[2]).empty()) << layer->info().name;
  EXPECT_FALSE(edge_layer().compute(window_of(stack, kAll), kTiles[2]).empty());
  for (const RasterLayer* layer : {&edge_layer(), &contour_layer(), &orientation_layer()})
    EXPECT_TRUE(layer->compute(window_of({kAll, {}}, kAll), kTiles[2]).empty()) << layer->info().name;
}

TEST(AgreementLayer, IsTheOperatorOnTheWholeImageTwoLevelsUp) {
  const TileIndex tile{kLevel + 2, 0, 1};  // 1024x1024 pixels around all of the image
  const ingest::Stack stack = two_dates();
  const PixelRect rect = pixels_of(tile, kLevel);
  const DatedStack dates = dated_orientation(stack, rect, {});
  cv::Mat expected;
  features::agreement(dates.dates, 4, expected);
  const TileData data = agreement_layer().compute(window_of(stack, grown(rect, 5)), tile);
  EXPECT_TRUE(same(data.pixels, expected));
  EXPECT_EQ(data.epochs, (std::vector<uint16_t>{0, 2}));
  cv::Mat dates_at;
  cv::extractChannel(data.pixels, dates_at, 1);
  EXPECT_EQ(cv::countNonZero(dates_at), cv::countNonZero(dates_at == 2));  // nowhere is one date said to agree
  EXPECT_GT(cv::countNonZero(dates_at), 3000);
  EXPECT_TRUE(agreement_layer().compute(window_of(one_date(), rect), tile).empty());
}

}  // namespace
}  // namespace landfix::layers
