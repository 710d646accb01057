// No allocation after opening on raw layers: malloc is counted while the queries run.
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/pack/small_map.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define LANDFIX_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define LANDFIX_SANITIZED 1
#endif
#endif

namespace {
// Volatile: the compiler knows malloc and believes that it leaves these alone.
thread_local volatile bool counting = false;
thread_local volatile size_t allocations = 0;
void note() {
  if (counting) allocations = allocations + 1;
}
}  // namespace

#ifdef LANDFIX_SANITIZED
// The sanitizers own malloc; they tell of every allocation. GCC ships this function of theirs without its header.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*)(const volatile void*, size_t),
                                                         void (*)(const volatile void*));
[[maybe_unused]] const int installed = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, size_t) { note(); }, [](const volatile void*) {});
#else
// glibc's own functions under the names that every library in this process calls, operator new's included.
extern "C" {
void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);

void* malloc(size_t size) {
  note();
  return __libc_malloc(size);
}
void* calloc(size_t count, size_t size) {
  note();
  return __libc_calloc(count, size);
}
void* realloc(void* p, size_t size) {
  note();
  return __libc_realloc(p, size);
}
void* memalign(size_t alignment, size_t size) {
  note();
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(size_t alignment, size_t size) {
  note();
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** out, size_t alignment, size_t size) {
  note();
  *out = __libc_memalign(alignment, size);
  return *out == nullptr ? 12 : 0;
}
}
#endif

namespace landfix::tests {
namespace {

template <typename Work>
size_t allocations_in(Work work) {
  allocations = 0;
  counting = true;
  work();
  counting = false;
  return allocations;
}

Drawing with_heights() {
  DrawnLayer height = small_gray();
  height.name = "height";
  height.format = {tiles::PixelType::kI16, 1, -32768};
  height.value_step = 0.1f;
  Drawing d{.layers = {small_gray(), height, small_bits()}};
  d.description.epochs = {{"2018-07-16", {}}};
  d.layers[0].epochs = [](char) -> catalog::EpochSet { return {0}; };
  d.description.geoid = ingest::GeoidGrid{"egm96", kWestM - 1000, kSouthM - 1000, 4000, 2, 2, {40, 41, 42, 43}};
  return d;
}

TEST(Allocation, IsCountedAtAll) {
  EXPECT_EQ(allocations_in([] {}), 0u);
  void* volatile kept = nullptr;  // keeps the compiler from leaving the pair out
  EXPECT_GE(allocations_in([&] {
              kept = std::malloc(100);
              std::free(kept);
            }),
            1u);
  EXPECT_GE(allocations_in([&] {
              kept = new int[100];
              delete[] static_cast<int*>(kept);
            }),
            1u);
  // Inside the runtime library too: preparing a compressed layer decodes it to memory.
  const OpenPack packed(small_pack(tiles::Codec::kZstd));
  const Region r = *packed->box(0, kWestM, kSouthM, kEastM, kNorthM, 1);
  lf_status status = LF_END;
  EXPECT_GE(allocations_in([&] { status = packed->prepare(r); }), 5u);
  EXPECT_EQ(status, LF_OK);
}

TEST(Allocation, NoneInAnyQueryOfRawLayers) {
  const TemporaryFolder folder;
  const std::string path = folder.file("small.lfpack");
  write_file(path, draw(with_heights()));
  const auto pack = Pack::open(path.c_str());
  ASSERT_TRUE(pack);
  const lf_pack* p = pack->c_pack();
  std::vector<uint8_t> pixels(1 << 20);
  std::vector<float> heights(1 << 20);
  std::vector<uint64_t> bits(1 << 16);
  lf_status worst = LF_OK;
  const auto check = [&](lf_status s) { worst = worst == LF_OK ? s : worst; };
  int tiles_seen = 0;
  const size_t counted = allocations_in([&] {
    // First touch included: nothing of the pack was read yet.
    for (int round = 0; round < 2; ++round) {
      lf_info info;
      check(lf_get_info(p, &info));
      uint32_t gray, height;
      check(lf_find_layer(p, "gray", &gray));
      check(lf_find_layer(p, "height", &height));
      const lf_ellipse ellipse{kWestM + 300, kSouthM + 300, 10000, 3000, 5000, 3};
      lf_region r;
      check(lf_ellipse_region(p, gray, &ellipse, 1, &r));
      check(lf_read(p, &r, pixels.data(), r.width, pixels.size()));
      lf_tile tile;
      uint64_t cursor = 0;
      while (lf_next_tile(p, &r, &ellipse, &cursor, &tile) == LF_OK) ++tiles_seen;
      check(lf_tile_view(p, gray, 0, kWestX, kSouthY, &tile));
      check(lf_ellipse_region(p, height, &ellipse, 2, &r));
      check(lf_read_heights(p, &r, heights.data(), r.width * sizeof(float), heights.size() * sizeof(float)));
      uint32_t orientation, count;
      check(lf_find_layer(p, "orientation", &orientation));
      check(lf_ellipse_region(p, orientation, &ellipse, 1, &r));
      check(lf_read_bits(p, &r, bits.data(), 16, 1 << 14, bits.size()));
      uint16_t epochs[4];
      lf_epoch_info epoch;
      lf_epoch_range range;
      check(lf_get_epoch(p, 0, &epoch));
      check(lf_tile_epochs(p, gray, 0, kWestX, kSouthY, epochs, 4, &count));
      check(lf_region_epochs(p, &r, &range));
      double value;
      lf_height_source source;
      check(lf_height(p, kWestM + 255.9, kSouthM + 256.1, &value, &source));
      check(lf_undulation(p, kWestM, kSouthM, &value));
      double east, north, latitude, longitude, convergence, scale;
      check(lf_geodetic_from_grid(p, kWestM, kSouthM, &latitude, &longitude, &convergence, &scale));
      check(lf_grid_from_geodetic(p, latitude, longitude, &east, &north, &convergence, &scale));
    }
  });
  EXPECT_EQ(worst, LF_OK);
  EXPECT_EQ(tiles_seen, 10);
  EXPECT_EQ(counted, 0u);
}

TEST(Allocation, NoneInSearchesOfPreparedLandmarksAndRoads) {
  std::vector<tiles::Landmark> drawn(200);
  for (size_t i = 0; i < drawn.size(); ++i)
    drawn[i].east_m = kWestM + 2.0 * double(i), drawn[i].north_m = kSouthM + 100;
  tiles::RoadGraph cross;
  for (const auto& [x, y] : {std::pair(200, 200), {10, 200}, {400, 200}, {200, 400}})
    cross.nodes.push_back({kWestM + x, kSouthM + y});
  for (const uint32_t to : {1u, 2u, 3u}) cross.edges.push_back({0, to, 5, 1, 0, {}});
  const OpenPack pack(draw({.landmarks = drawn, .roads = cross}));
  const uint32_t landmarks = pack.layer("landmarks"), roads = pack.layer("roads");
  for (const uint32_t layer : {landmarks, roads})
    ASSERT_EQ(pack->prepare(*pack->box(layer, kWestM, kSouthM, kWestM + 400, kSouthM + 400, 8)), LF_OK);
  std::vector<Landmark> points(500);
  std::vector<Intersection> crossings(5);
  std::vector<Road> lines(5);
  std::vector<Point> vertices(50);
  FeatureQuery query;
  query.ellipse = Ellipse{kWestM + 200, kSouthM + 150, 1e4, 0, 1e4, 2};
  size_t point_count = 0, crossing_count = 0, line_count = 0, vertex_count = 0;
  lf_status worst = LF_OK;
  const size_t counted = allocations_in([&] {
    for (const lf_status s : {pack->find_landmarks(landmarks, query, points, point_count),
                              pack->find_intersections(roads, query, crossings, crossing_count),
                              pack->find_roads(roads, query, lines, line_count, vertices, vertex_count)})
      worst = worst == LF_OK ? s : worst;
  });
  EXPECT_EQ(worst, LF_OK);
  EXPECT_GT(point_count, 150u);
  EXPECT_EQ(crossing_count, 1u);
  EXPECT_EQ(line_count, 3u);
  EXPECT_EQ(counted, 0u);
}

TEST(Allocation, NoneInReadsOfAPreparedLayer) {
  const OpenPack packed(small_pack(tiles::Codec::kJpeg));
  const Region r = *packed->box(0, kWestM, kSouthM, kEastM, kNorthM, 1);
  ASSERT_EQ(packed->prepare(r), LF_OK);
  std::vector<uint8_t> pixels(768 * 512);
  lf_status status = LF_END;
  EXPECT_EQ(allocations_in([&] { status = packed->read(r, pixels, 768); }), 0u);
  EXPECT_EQ(status, LF_OK);
}

}  // namespace
}  // namespace landfix::tests
