// Epochs halved from level to level, and put together again from tiles.
#include "builder/layers/stack.h"

#include <gtest/gtest.h>

#include <map>

#include "builder/layers/window.h"
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
const std::vector<ingest::EpochInfo> kEpochs = {{"2018-07-16", kRgb, {0}}, {"2009-08-18", {BandRole::kGray}, {1}}};
const auto kAllUsed = [](const TileIndex&) { return true; };

// An image of odd size at an odd place, around the corner of four tiles of the coarser level.
constexpr PixelRect kFine{0, 1024 - 301, -1024 - 203, 701, 505};

ingest::Stack stack() {
  ingest::Stack s{kFine, {}};
  for (size_t i = 0; i < 2; ++i) {
    ingest::Epoch e{kEpochs[i].date, kEpochs[i].roles, {}, {}, {}, i};
    e.bands = scene(int(kFine.width), int(kFine.height), int(e.roles.size()), 31 + i);
    e.valid = mask_with_holes(int(kFine.width), int(kFine.height), 41 + i);
    s.epochs.push_back(std::move(e));
  }
  return s;
}

// The mean of 2x2 pixels of one band, rounded half up; -1 without data.
int plain_half(const ingest::Epoch& e, int band, int64_t column, int64_t row) {
  int sum = 0, count = 0;
  for (int i = 0; i < 4; ++i) {
    const int64_t x = 2 * column + i % 2 - kFine.column, y = 2 * row + i / 2 - kFine.row;
    if (x < 0 || y < 0 || x >= kFine.width || y >= kFine.height || !e.valid.at<uint8_t>(int(y), int(x))) continue;
    sum += e.bands.ptr<uint8_t>(int(y))[x * e.bands.channels() + band];
    ++count;
  }
  return count < 2 ? -1 : int(double(sum) / count + 0.5);
}

// Keeps tiles as the journal does.
struct Kept {
  std::map<std::tuple<size_t, int, int>, std::vector<uint8_t>> tiles;
  void add(std::vector<EpochTile> more) {
    for (EpochTile& t : more) tiles[{t.epoch, t.tile.x, t.tile.y}] = std::move(t.data);
  }
  ReadEpochTile reader() const {
    return [this](size_t epoch, const TileIndex& t) -> std::optional<std::vector<uint8_t>> {
      const auto found = tiles.find({epoch, t.x, t.y});
      if (found == tiles.end()) return std::nullopt;
      return found->second;
    };
  }
};

TEST(Stack, HalvedTilesGiveTheMeansOfTheWholeImage) {
  const ingest::Stack fine = stack();
  Kept kept;
  for (const TileIndex& t : {TileIndex{1, 1, 1}, {1, 2, 1}, {1, 1, 2}, {1, 2, 2}}) kept.add(halved(fine, t, kAllUsed));
  // A window that begins and ends inside tiles.
  const PixelRect rect{1, 512 - 140, -512 - 90, 320, 230};
  const ingest::Stack half = stack_of_tiles(rect, kEpochs, kept.reader());
  ASSERT_EQ(half.epochs.size(), 2u);
  int wrong = 0, with_data = 0;
  for (size_t e = 0; e < 2; ++e) {
    EXPECT_EQ(half.epochs[e].index, e);
    EXPECT_EQ(half.epochs[e].date, kEpochs[e].date);
    for (int y = 0; y < rect.height; ++y)
      for (int x = 0; x < rect.width; ++x)
        for (int b = 0; b < half.epochs[e].bands.channels(); ++b) {
          const int expected = plain_half(fine.epochs[e], b, rect.column + x, rect.row + y);
          const bool valid = half.epochs[e].valid.at<uint8_t>(y, x);
          const int value = half.epochs[e].bands.ptr<uint8_t>(y)[x * half.epochs[e].bands.channels() + b];
          wrong += valid ? value != expected : expected != -1 || value != 0;
          with_data += valid;
        }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(with_data, 200'000);
}

TEST(Stack, LeavesOutChildrenThatAreNotUsed) {
  const ingest::Stack fine = stack();
  const TileIndex tile{1, 2, 1};
  const auto used = [](const TileIndex& child) { return child.x == 4; };  // its western half
  Kept all, west;
  all.add(halved(fine, tile, kAllUsed));
  west.add(halved(fine, tile, used));
  const PixelRect rect = pixels_of(tile, 1), half{1, rect.column, rect.row, 128, 256};
  EXPECT_TRUE(same(stack_of_tiles(half, kEpochs, all.reader()).epochs[0].bands,
                   stack_of_tiles(half, kEpochs, west.reader()).epochs[0].bands));
  const ingest::Stack shown = stack_of_tiles(rect, kEpochs, west.reader());
  EXPECT_EQ(cv::countNonZero(shown.epochs[0].valid.colRange(128, 256)), 0);
  EXPECT_TRUE(halved(fine, tile, [](const TileIndex&) { return false; }).empty());
}

TEST(Stack, StoresAMaskOnlyWhereThereAreHoles) {
  ingest::Stack s{pixels_of({1, 0, 0}, 0), {}};
  ingest::Epoch e{
      "", {BandRole::kGray}, cv::Mat(512, 512, CV_8UC1, cv::Scalar(7)), cv::Mat(512, 512, CV_8UC1, cv::Scalar(255)), {},
      1};
  s.epochs = {e};
  ASSERT_EQ(halved(s, {1, 0, 0}, kAllUsed).size(), 1u);
  EXPECT_EQ(halved(s, {1, 0, 0}, kAllUsed)[0].epoch, 1u);
  EXPECT_EQ(halved(s, {1, 0, 0}, kAllUsed)[0].data.size(), 65536u);
  s.epochs[0].valid(cv::Rect(10, 10, 2, 2)).setTo(0);
  EXPECT_EQ(halved(s, {1, 0, 0}, kAllUsed)[0].data.size(), 2 * 65536u);
  s.epochs[0].valid.setTo(0);
  EXPECT_TRUE(halved(s, {1, 0, 0}, kAllUsed).empty());
}

}  // namespace
}  // namespace landfix::layers
