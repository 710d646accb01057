// Many threads, one pack: first touches race, answers do not. Meant to be run under ThreadSanitizer too.
#include <gtest/gtest.h>

#include <atomic>
#include <barrier>
#include <thread>

#include "tests/pack/small_map.h"
#include "tests/tiles/random.h"

namespace landfix::tests {
namespace {

constexpr int kThreads = 8;

template <typename Work>
void on_all_threads(Work work) {
  std::barrier start(kThreads);
  std::vector<std::thread> threads;
  for (int i = 0; i < kThreads; ++i)
    threads.emplace_back([&, i] {
      start.arrive_and_wait();
      work(i);
    });
  for (std::thread& t : threads) t.join();
}

bool as_drawn(const Region& r, const std::vector<uint8_t>& pixels) {
  for (int64_t y = 0; y < r.height; ++y)
    for (int64_t x = 0; x < r.width; ++x) {
      const int64_t column = r.first_column + x, row = r.first_row + y;
      const char letter = small_letter(column, row);
      if (pixels[size_t(y) * r.width + size_t(x)] != (letter == '.' ? 0 : pattern({letter, 0, column, row, 0})))
        return false;
    }
  return true;
}

TEST(Threads, FirstTouchOfRawTiles) {
  const std::vector<uint8_t> bytes = small_pack();
  for (int round = 0; round < 5; ++round) {
    const OpenPack pack(bytes);
    std::atomic<int> wrong = 0;
    on_all_threads([&](int i) {
      Random random{uint64_t(i)};
      for (int k = 0; k < 20; ++k) {
        const double east = kWestM + random.uniform(0, 600), north = kSouthM + random.uniform(0, 400);
        const auto r = pack->box(0, east, north, east + 60, north + 60, 1);
        const Read got = read(*pack, *r);
        wrong += got.status != LF_OK || !as_drawn(*r, got.pixels);
      }
    });
    EXPECT_EQ(wrong, 0);
  }
}

TEST(Threads, PrepareWhileOthersReadAndPrepare) {
  const std::vector<uint8_t> bytes = small_pack(tiles::Codec::kZstd);
  for (int round = 0; round < 5; ++round) {
    const OpenPack pack(bytes);
    std::atomic<int> wrong = 0;
    const void* seen[kThreads] = {};
    on_all_threads([&](int i) {
      const Region r = *pack->box(0, kWestM, kSouthM, kEastM, kNorthM, 1);
      const Read early = read(*pack, r);
      wrong += early.status != LF_NOT_PREPARED && early.status != LF_OK;
      wrong += pack->prepare(r) != LF_OK;
      const Read late = read(*pack, r);
      wrong += late.status != LF_OK || !as_drawn(r, late.pixels);
      seen[i] = pack->tile(0, 0, kWestX, kSouthY)->pixels;
    });
    EXPECT_EQ(wrong, 0);
    for (const void* p : seen) EXPECT_EQ(p, seen[0]) << "all threads see the same decoded tile";
  }
}

TEST(Threads, PreparedTilesNeverMove) {
  // All decode the same tiles at once: whoever is first wins, and what a thread has seen stays.
  const std::vector<uint8_t> bytes = small_pack(tiles::Codec::kJpeg);
  for (int round = 0; round < 40; ++round) {
    const OpenPack pack(bytes);
    const Region r = *pack->box(0, kWestM, kSouthM, kEastM, kNorthM, 1);
    std::vector<const void*> seen[kThreads];
    on_all_threads([&](int i) {
      EXPECT_EQ(pack->prepare(r), LF_OK);
      EXPECT_EQ(pack->for_each_tile(r, nullptr, [&](const Tile& tile) { seen[i].push_back(tile.pixels); }), LF_OK);
    });
    EXPECT_EQ(seen[0].size(), 5u);
    for (const auto& other : seen) EXPECT_EQ(other, seen[0]);
  }
}

TEST(Threads, EveryoneSeesTheDamage) {
  std::vector<uint8_t> bytes = small_pack();
  bytes.back() ^= 1;  // in the last tile of level 1
  const OpenPack pack(bytes);
  std::atomic<int> damaged = 0;
  on_all_threads([&](int) { damaged += pack->verify(false).status() == LF_DAMAGED; });
  EXPECT_EQ(damaged, kThreads);
}

}  // namespace
}  // namespace landfix::tests
