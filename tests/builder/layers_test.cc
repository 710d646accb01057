// The raster layers on small drawn windows, with the values that their definitions give.
#include <gtest/gtest.h>

#include <cmath>

#include "builder/layers/mean.h"
#include "builder/layers/registry.h"
#include "builder/layers/window.h"

namespace landfix::layers {
namespace {

using ingest::BandRole;
using tiles::PixelRect;
using tiles::TileIndex;

constexpr TileIndex kTile{0, 3, 5};

// An epoch that shows one colour wherever `valid` is not 0.
ingest::Epoch epoch(std::vector<BandRole> roles, const cv::Scalar& colour, const cv::Mat& valid) {
  ingest::Epoch e;
  e.bands = cv::Mat(valid.size(), CV_8UC(int(roles.size())), cv::Scalar::all(0));
  e.bands.setTo(colour, valid);
  e.roles = std::move(roles);
  e.valid = valid;
  return e;
}

SourceWindow window_of(const PixelRect& rect, std::vector<ingest::Epoch> epochs) {
  SourceWindow w;
  w.rect = w.images.rect = rect;
  w.images.epochs = std::move(epochs);
  w.gray = newest(w.images, rect, 1);
  return w;
}

cv::Mat everywhere(const PixelRect& r) { return {int(r.height), int(r.width), CV_8UC1, cv::Scalar::all(255)}; }

const std::vector<BandRole> kRgb = {BandRole::kRed, BandRole::kGreen, BandRole::kBlue};

TEST(Gray, IsLumaOfTheNewestEpochAndOlderOnesFillItsHoles) {
  const PixelRect rect = pixels_of(kTile, 0);
  cv::Mat western_half = everywhere(rect);
  western_half.colRange(128, 256).setTo(0);
  const SourceWindow window =
      window_of(rect, {epoch(kRgb, {10, 20, 30}, western_half), epoch({BandRole::kGray}, {200}, everywhere(rect))});
  const cv::Mat gray = gray_layer().compute(window, kTile).pixels;
  ASSERT_EQ(gray.type(), CV_8UC1);
  ASSERT_EQ(gray.size(), cv::Size(256, 256));
  EXPECT_EQ(gray.at<uint8_t>(0, 0), 18);      // (299·10 + 587·20 + 114·30 + 500) / 1000 = 18.65, cut off
  EXPECT_EQ(gray.at<uint8_t>(255, 127), 18);  // the last column that the newest covers
  EXPECT_EQ(gray.at<uint8_t>(255, 128), 200);
}

TEST(Gray, BlackIsDataAndNothingIsNot) {
  const PixelRect rect = pixels_of(kTile, 0);
  cv::Mat first_row = everywhere(rect);
  first_row.rowRange(1, 256).setTo(0);
  const cv::Mat gray = gray_layer().compute(window_of(rect, {epoch(kRgb, {0, 0, 0}, first_row)}), kTile).pixels;
  EXPECT_EQ(gray.at<uint8_t>(0, 7), 1);  // 0 would say "no data"
  EXPECT_EQ(gray.at<uint8_t>(1, 7), 0);
  EXPECT_TRUE(gray_layer().compute(window_of(rect, {}), kTile).empty());
  EXPECT_TRUE(gray_layer().compute(window_of(rect, {epoch(kRgb, {9, 9, 9}, everywhere(rect))}), {0, 4, 5}).empty());
}

TEST(Gray, TakesWhatBandsThereAre) {
  const PixelRect rect = pixels_of(kTile, 0);
  const auto value = [&](std::vector<BandRole> roles, const cv::Scalar& colour) {
    return int(gray_layer()
                   .compute(window_of(rect, {epoch(std::move(roles), colour, everywhere(rect))}), kTile)
                   .pixels.at<uint8_t>(9, 9));
  };
  EXPECT_EQ(value({BandRole::kRed, BandRole::kGreen, BandRole::kBlue, BandRole::kNir}, {10, 20, 30, 250}),
            18);                                                                            // infrared is not seen
  EXPECT_EQ(value({BandRole::kRed, BandRole::kGreen, BandRole::kNir}, {10, 21, 250}), 16);  // (10 + 21 + 1) / 2
  EXPECT_EQ(value({BandRole::kNir}, {250}), 250);
}

TEST(Gray, PlacesAPartialWindowInItsTile) {
  // 10x4 pixels that begin 250 columns and 2 rows into the tile: 6 columns of them are in it.
  PixelRect rect = pixels_of(kTile, 0);
  rect = {0, rect.column + 250, rect.row + 2, 10, 4};
  const cv::Mat gray =
      gray_layer().compute(window_of(rect, {epoch(kRgb, {50, 50, 50}, everywhere(rect))}), kTile).pixels;
  EXPECT_EQ(cv::countNonZero(gray), 6 * 4);
  EXPECT_EQ(gray.at<uint8_t>(2, 250), 50);
  EXPECT_EQ(gray.at<uint8_t>(5, 255), 50);
}

TEST(Overview, IsTheMeanOfFourByFourPixels) {
  const TileIndex tile{2, 1, 1};
  const PixelRect rect = pixels_of(tile, 0);
  ASSERT_EQ(rect.width, 1024);
  auto newest = epoch(kRgb, {100, 50, 0}, everywhere(rect));
  newest.bands.at<cv::Vec3b>(0, 0) = {116, 50, 8};  // one pixel of sixteen: + 16 / 16 and + 8 / 16, rounded half up
  newest.bands(cv::Rect(4, 0, 4, 4)).setTo(0);      // black ground
  newest.valid(cv::Rect(8, 0, 4, 2)).setTo(0);      // 8 of 16 missing: the other half speaks
  newest.valid(cv::Rect(12, 0, 4, 2)).setTo(0);     // and 9 of 16 missing: none
  newest.valid.at<uint8_t>(2, 12) = 0;
  const TileData data = overview_layer().compute(window_of(rect, {newest}), tile);
  ASSERT_EQ(data.pixels.type(), CV_8UC3);
  ASSERT_EQ(data.pixels.size(), cv::Size(256, 256));
  EXPECT_EQ(data.pixels.at<cv::Vec3b>(0, 0), cv::Vec3b(101, 50, 1));
  EXPECT_EQ(data.pixels.at<cv::Vec3b>(0, 1), cv::Vec3b(1, 1, 1));
  EXPECT_EQ(data.pixels.at<cv::Vec3b>(0, 2), cv::Vec3b(100, 50, 0));
  EXPECT_EQ(data.pixels.at<cv::Vec3b>(0, 3), cv::Vec3b(0, 0, 0));
  EXPECT_EQ(data.pixels.at<cv::Vec3b>(255, 255), cv::Vec3b(100, 50, 0));
}

TEST(Overview, ShowsColourInfraredAsAFalseColourPrint) {
  const TileIndex tile{2, 0, 0};
  const PixelRect rect = pixels_of(tile, 0);
  const auto cir = epoch({BandRole::kRed, BandRole::kGreen, BandRole::kNir}, {10, 20, 30}, everywhere(rect));
  EXPECT_EQ(overview_layer().compute(window_of(rect, {cir}), tile).pixels.at<cv::Vec3b>(5, 5), cv::Vec3b(30, 10, 20));
}

TEST(Mean, NeedsHalfOfThePixels) {
  TileData child{.pixels = cv::Mat(256, 256, CV_8UC1, cv::Scalar::all(0))};
  child.pixels.at<uint8_t>(0, 0) = 9;  // 1 of 4
  child.pixels.at<uint8_t>(0, 2) = 9;  // 2 of 4: (9 + 10 + 1) / 2
  child.pixels.at<uint8_t>(0, 3) = 10;
  child.pixels(cv::Rect(4, 0, 2, 2)).setTo(7);
  child.pixels.at<uint8_t>(1, 5) = 9;  // (3·7 + 9 + 2) / 4 = 8
  // The child in the south-east lies in the last quarter of its parent.
  const TileData parent = mean_of_children({TileData{}, TileData{}, TileData{}, child});
  ASSERT_EQ(parent.pixels.size(), cv::Size(256, 256));
  EXPECT_EQ(parent.pixels.at<uint8_t>(128, 128), 0);
  EXPECT_EQ(parent.pixels.at<uint8_t>(128, 129), 10);
  EXPECT_EQ(parent.pixels.at<uint8_t>(128, 130), 8);
  EXPECT_EQ(cv::countNonZero(parent.pixels), 2);
}

TEST(Mean, IsEmptyWhereTooLittleIsLeft) {
  TileData child{.pixels = cv::Mat(256, 256, CV_8UC1, cv::Scalar::all(0))};
  child.pixels.at<uint8_t>(100, 100) = 9;
  EXPECT_TRUE(mean_of_children({child, TileData{}, TileData{}, TileData{}}).empty());
  EXPECT_TRUE(mean_of_children({}).empty());
}

SourceWindow heights_window(const cv::Mat& metres, const cv::Mat& valid = {}) {
  SourceWindow w;
  w.rect = pixels_of(kTile, 0);
  w.heights.pixels = metres;
  w.heights.valid = valid;
  return w;
}

double value(const TileData& tile, int x, int y) {
  return double(tile.value_offset) + double(tile.value_step) * tile.pixels.at<int16_t>(y, x);
}

TEST(Height, KeepsCentimetresBelow655MetresOfRange) {
  cv::Mat metres(256, 256, CV_32FC1);
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x)
      metres.at<float>(y, x) = 300.0f + 2.5f * float(x) + 0.01f * float(y);  // 300 to 940.05
  cv::Mat valid(256, 256, CV_8UC1, cv::Scalar::all(255));
  valid.at<uint8_t>(3, 4) = 0;
  metres.at<float>(3, 5) = NAN;
  const TileData tile = height_layer().compute(heights_window(metres, valid), kTile);
  EXPECT_EQ(tile.value_step, 0.01f);
  EXPECT_EQ(tile.value_offset, 620.0f);  // the middle, (300 + 940.05) / 2, to the whole metre
  EXPECT_EQ(tile.pixels.at<int16_t>(3, 4), -32768);
  EXPECT_EQ(tile.pixels.at<int16_t>(3, 5), -32768);
  for (int y = 10; y < 256; ++y)
    for (int x = 0; x < 256; ++x) ASSERT_NEAR(value(tile, x, y), metres.at<float>(y, x), 0.0051);
}

TEST(Height, CoarsensItsStepOnlyAsFarAsTheRangeAsks) {
  const auto step_of_range = [](float range) {
    cv::Mat metres(256, 256, CV_32FC1, cv::Scalar::all(0));
    metres.at<float>(0, 0) = range;
    const TileData tile = height_layer().compute(heights_window(metres), kTile);
    EXPECT_NEAR(value(tile, 0, 0), range, tile.value_step / 2 * 1.001);
    EXPECT_NEAR(value(tile, 1, 0), 0, tile.value_step / 2 * 1.001);
    return tile.value_step;
  };
  EXPECT_EQ(step_of_range(0), 0.01f);
  EXPECT_EQ(step_of_range(654), 0.01f);  // 65534 steps
  EXPECT_EQ(step_of_range(657), 0.02f);
  EXPECT_EQ(step_of_range(1400), 0.05f);
  EXPECT_EQ(step_of_range(6552), 0.1f);
}

TEST(Height, HasNoTileWithoutData) {
  EXPECT_TRUE(height_layer().compute(heights_window({}), kTile).empty());
  const cv::Mat metres(256, 256, CV_32FC1, cv::Scalar::all(5));
  EXPECT_TRUE(height_layer().compute(heights_window(metres, cv::Mat::zeros(256, 256, CV_8UC1)), kTile).empty());
}

TEST(Height, ParentIsTheMeanInMetresWhateverTheOffsetsOfItsChildren) {
  const auto flat = [](float h) {
    return height_layer().compute(heights_window(cv::Mat(256, 256, CV_32FC1, cv::Scalar::all(double(h)))), kTile);
  };
  TileData low = flat(100.25f);
  low.pixels.at<int16_t>(0, 0) = -32768;  // 3 of 4 left
  low.pixels(cv::Rect(2, 0, 2, 2)).setTo(-32768);
  low.pixels.at<int16_t>(0, 2) = 0;  // 1 of 4 left
  const TileData parent = height_layer().reduce({low, flat(700.5f), TileData{}, flat(400)});
  EXPECT_EQ(parent.value_offset, 400.0f);  // (100.25 + 700.5) / 2 = 400.375
  EXPECT_EQ(parent.value_step, 0.01f);     // 600 m of range
  EXPECT_NEAR(value(parent, 0, 0), 100.25, 1e-4);
  EXPECT_EQ(parent.pixels.at<int16_t>(0, 1), -32768);
  EXPECT_NEAR(value(parent, 128, 0), 700.5, 1e-4);
  EXPECT_EQ(parent.pixels.at<int16_t>(255, 0), -32768);
  EXPECT_NEAR(value(parent, 255, 255), 400, 1e-4);
}

TEST(Registry, NamesAreUniqueAndFound) {
  ASSERT_EQ(registry().size(), 7u);
  for (const RasterLayer* layer : registry()) {
    EXPECT_EQ(find(layer->info().name), layer);
    EXPECT_LE(layer->info().base_offset, kBlockLog2);
  }
  EXPECT_EQ(find("grey"), nullptr);
}

}  // namespace
}  // namespace landfix::layers
