// Landmarks and roads through the runtime: each once, in order, against what was drawn; and every way to ask wrongly.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "tests/pack/patch.h"
#include "tests/pack/small_map.h"

namespace landfix::tests {
namespace {

using std::numbers::pi;

constexpr double kSide = 2048, kWest = 244 * kSide, kSouth = 2441 * kSide;
constexpr double kSize = 2 * kSide;  // four tiles

// Three landmarks in every 50 m, of all classes, over four tiles.
std::vector<tiles::Landmark> drawn_landmarks() {
  std::vector<tiles::Landmark> out;
  for (int i = 0; i < 81 * 81; ++i) {
    tiles::Landmark m;
    m.east_m = kWest + 25 + 50.25 * (i % 81), m.north_m = kSouth + 15 + 50.25 * double(i / 81);
    m.cls = tiles::LandmarkClass(i % 5);
    m.length_m = 5 + i % 40, m.width_m = 5;
    if (i % 3 != 0) m.orientation_rad = 0.1 * (i % 30);
    m.confidence = (i % 16) / 15.0, m.distinctiveness_m = i % 500;
    m.source = uint16_t(i % 7 == 0 ? 2 : 0);
    out.push_back(m);
  }
  return out;
}

// A cross of two roads, 6 and 8 m wide, that meet in the south-western tile, and a lane that joins the first.
tiles::RoadGraph drawn_roads() {
  const auto node = [](double x, double y) { return tiles::RoadNode{kWest + x, kSouth + y}; };
  tiles::RoadGraph g;
  g.nodes = {node(1000, 1000), node(20, 1000),  node(4000, 1000), node(1000, 4000),
             node(1000, 20),   node(500, 1000), node(500, 1500)};
  g.edges = {{1, 5, 6, 1, 0, {}},   {5, 0, 6, 1, 0, {}},   {0, 2, 6, 0.8, 0, {}},
             {0, 3, 8, 0.6, 1, {}}, {4, 0, 8, 0.6, 1, {}}, {5, 6, 3, 0.2, 0, {{kWest + 520, kSouth + 1250}}}};
  return g;
}

Drawing drawing() {
  Drawing d{.layers = {small_gray()}, .landmarks = drawn_landmarks(), .roads = drawn_roads()};
  exporter::PackSource image, known;
  known.role = exporter::SourceRole::kVector;
  known.source.name = image.source.name = "some";
  d.description.sources = {known, image, known};
  d.description.bounds = {kWest, kSouth, kWest + kSize, kSouth + kSize};
  return d;
}

const std::vector<uint8_t>& vector_pack() {
  static const std::vector<uint8_t> bytes = draw(drawing());
  return bytes;
}

FeatureQuery box(double west, double south, double east, double north) {
  return {.ellipse = {},
          .west_m = kWest + west,
          .south_m = kSouth + south,
          .east_m = kWest + east,
          .north_m = kSouth + north};
}
const FeatureQuery kEverywhere = box(0, 0, kSize, kSize);

Status prepare(const OpenPack& pack, const char* layer) {
  return pack->prepare(*pack->box(pack.layer(layer), kWest, kSouth, kWest + kSize, kSouth + kSize, 8));
}

struct Prepared : OpenPack {
  Prepared() : OpenPack(vector_pack()) {
    EXPECT_EQ(prepare(*this, "landmarks"), LF_OK);
    EXPECT_EQ(prepare(*this, "roads"), LF_OK);
  }
  std::vector<Landmark> landmarks(const FeatureQuery& q) const {
    std::vector<Landmark> out(10000);
    size_t count = 0;
    EXPECT_EQ((*this)->find_landmarks(layer("landmarks"), q, out, count), LF_OK);
    out.resize(count);
    return out;
  }
  std::vector<Intersection> intersections(const FeatureQuery& q) const {
    std::vector<Intersection> out(100);
    size_t count = 0;
    EXPECT_EQ((*this)->find_intersections(layer("roads"), q, out, count), LF_OK);
    out.resize(count);
    return out;
  }
  std::vector<Road> roads(const FeatureQuery& q, std::vector<Point>* points = nullptr) const {
    std::vector<Road> out(100);
    std::vector<Point> vertices(1000);
    size_t count = 0, vertex_count = 0;
    EXPECT_EQ((*this)->find_roads(layer("roads"), q, out, count, vertices, vertex_count), LF_OK);
    out.resize(count), vertices.resize(vertex_count);
    if (points) *points = vertices;
    return out;
  }
};

// Places of what was drawn that `wanted` says yes to.
template <typename Wanted>
std::multiset<std::pair<double, double>> places(Wanted wanted) {
  std::multiset<std::pair<double, double>> out;
  for (const tiles::Landmark& m : drawn_landmarks())
    if (const tiles::Landmark q = *tiles::quantised(m); wanted(q)) out.insert({q.east_m, q.north_m});
  return out;
}

std::multiset<std::pair<double, double>> places(const std::vector<Landmark>& found) {
  std::multiset<std::pair<double, double>> out;
  for (const Landmark& m : found) out.insert({m.east_m, m.north_m});
  return out;
}

TEST(Layers, OfVectorsSayWhatTheyAre) {
  const OpenPack pack(vector_pack());
  ASSERT_EQ(pack.status(), LF_OK);
  EXPECT_EQ(pack->layer(pack.layer("landmarks"))->pixel_type, LF_LANDMARKS);
  EXPECT_EQ(pack->layer(pack.layer("roads"))->pixel_type, LF_ROADS);
  EXPECT_EQ(pack->level(pack.layer("landmarks"), 0)->level, 3);
  EXPECT_EQ(pack->level(pack.layer("landmarks"), 0)->tile_count, 4u);
  EXPECT_EQ(*pack->verify(true), 6u + 3u + 4u + 3u) << "gray on two levels, landmarks, and roads in three tiles";
}

TEST(Landmarks, AreFoundOnceEachWithAllTheyHave) {
  const Prepared pack;
  const auto found = pack.landmarks(kEverywhere);
  EXPECT_EQ(found.size(), 81u * 81);
  EXPECT_EQ(places(found), places([](const auto&) { return true; }));
  for (const Landmark& m : found) {
    EXPECT_EQ(
        std::isnan(m.orientation_rad),
        int(std::lround((m.east_m - kWest - 25) / 50.25) + 81 * std::lround((m.north_m - kSouth - 15) / 50.25)) % 3 ==
            0);
    EXPECT_GE(m.length_m, m.width_m);
    EXPECT_EQ(m.epochs_seen, 1);
    EXPECT_TRUE(m.source == -1 || m.source == 2) << "the second vector source is the third of all";
  }
  EXPECT_GT(std::ranges::count(found, 2, &Landmark::source), 900);
}

TEST(Landmarks, ComeTileAfterTileFromTheNorthWest) {
  const Prepared pack;
  const auto found = pack.landmarks(kEverywhere);
  const auto tile = [](const Landmark& m) {
    return std::pair(-std::floor(m.north_m / kSide), std::floor(m.east_m / kSide));
  };
  EXPECT_TRUE(std::ranges::is_sorted(found, {}, tile));
  EXPECT_EQ(tile(found.front()), std::pair(-2442.0, 244.0));
  EXPECT_EQ(tile(found.back()), std::pair(-2441.0, 245.0));
}

// The edge at 2035 m runs through a column of landmarks.
TEST(Landmarks, OfABoxAreThoseInItAndBoxesSideBySideShareNone) {
  const Prepared pack;
  const auto in_box = [&](double west, double east) {
    return places([&](const tiles::Landmark& m) {
      return m.east_m >= kWest + west && m.east_m < kWest + east && m.north_m >= kSouth + 1900.25 &&
             m.north_m < kSouth + 2500;
    });
  };
  const auto west = pack.landmarks(box(1500, 1900.25, 2035, 2500)),
             east = pack.landmarks(box(2035, 1900.25, 2100.5, 2500));
  EXPECT_GT(west.size(), 100u);
  EXPECT_EQ(places(west), in_box(1500, 2035));
  EXPECT_EQ(places(east), in_box(2035, 2100.5));
  EXPECT_EQ(pack.landmarks(box(1500, 1900.25, 2100.5, 2500)).size(), west.size() + east.size());
}

TEST(Landmarks, OfAnEllipseAreThoseInIt) {
  const Prepared pack;
  // Correlated, over all four tiles: 3 sigma, 200 and 120 m.
  const Ellipse e{kWest + 2050, kSouth + 2040, 40000, 15000, 14400, 3};
  const auto inside = [&](const tiles::Landmark& m) {
    const double x = m.east_m - e.east_m, y = m.north_m - e.north_m, d = e.cov_ee * e.cov_nn - e.cov_en * e.cov_en;
    return (e.cov_nn * x * x - 2 * e.cov_en * x * y + e.cov_ee * y * y) / d <= 9;
  };
  FeatureQuery q;
  q.ellipse = e;
  const auto found = pack.landmarks(q);
  EXPECT_EQ(places(found), places(inside));
  // The ellipse's area over that of a cell.
  EXPECT_NEAR(double(found.size()), pi * 9 * std::sqrt(40000.0 * 14400 - 15000.0 * 15000) / (50.25 * 50.25), 10);
  q.ellipse->k = 0;
  EXPECT_TRUE(pack.landmarks(q).empty()) << "a point, where nothing stands";
}

TEST(Landmarks, OfAClassAndSureEnough) {
  const Prepared pack;
  FeatureQuery q = kEverywhere;
  q.class_mask = 1u << LF_BUILDING | 1u << LF_WATER;
  q.min_confidence = 0.8f;  // 12/15 and more
  const auto found = pack.landmarks(q);
  EXPECT_EQ(places(found), places([](const tiles::Landmark& m) {
              return (m.cls == tiles::LandmarkClass::kBuilding || m.cls == tiles::LandmarkClass::kWater) &&
                     m.confidence > 11.5 / 15;
            }));
  EXPECT_NEAR(double(found.size()), 81 * 81 * 0.4 * 0.25, 10);
}

TEST(Landmarks, ThatDoNotFitAreCounted) {
  const Prepared pack;
  const auto all = pack.landmarks(kEverywhere);
  std::vector<Landmark> out(100);
  size_t count = 0;
  EXPECT_EQ(pack->find_landmarks(pack.layer("landmarks"), kEverywhere, out, count), LF_BUFFER_TOO_SMALL);
  EXPECT_EQ(count, all.size());
  for (size_t i = 0; i < out.size(); ++i) EXPECT_EQ(out[i].east_m, all[i].east_m);
  EXPECT_EQ(pack->find_landmarks(pack.layer("landmarks"), kEverywhere, {}, count), LF_BUFFER_TOO_SMALL);
  EXPECT_EQ(count, all.size());
}

TEST(Intersections, HaveBearingsAndWidths) {
  const Prepared pack;
  const auto found = pack.intersections(kEverywhere);
  ASSERT_EQ(found.size(), 2u);
  const Intersection& cross = found[0].degree == 4 ? found[0] : found[1];
  const Intersection& fork = found[0].degree == 4 ? found[1] : found[0];
  EXPECT_EQ(cross.east_m, kWest + 1000);
  EXPECT_EQ(cross.north_m, kSouth + 1000);
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(cross.bearing_rad[i], i * pi / 2, 1e-6);
    EXPECT_NEAR(cross.width_m[i], i % 2 == 0 ? 8 : 6, 0.4);
  }
  EXPECT_NEAR(cross.confidence, 0.6, 1e-6) << "the third surest of 1, 0.8, 0.6, 0.6";
  EXPECT_EQ(fork.degree, 3u);
  EXPECT_NEAR(fork.bearing_rad[0], std::atan2(20, 250), 1e-6);
  EXPECT_NEAR(fork.confidence, 0.2, 1e-6);
  FeatureQuery sure = kEverywhere;
  sure.min_confidence = 0.5f;
  EXPECT_EQ(pack.intersections(sure).size(), 1u);
  EXPECT_EQ(pack.intersections(box(400, 900, 600, 1100)).size(), 1u);
  EXPECT_TRUE(pack.intersections(box(3000, 3000, 3100, 3100)).empty());
}

TEST(Roads, AreWholeAndMeetAtBorders) {
  const Prepared pack;
  std::vector<Point> points;
  const auto roads = pack.roads(kEverywhere, &points);
  ASSERT_EQ(roads.size(), 8u) << "six, two of them cut at a border";
  double length = 0;
  int borders = 0;
  for (const Road& r : roads) {
    length += double(r.length_m);
    borders += (r.begin == LF_ROAD_BORDER) + (r.end == LF_ROAD_BORDER);
    double sum = 0;
    for (size_t i = r.first_vertex + 1; i < r.first_vertex + r.vertex_count; ++i)
      sum += std::hypot(points[i].east_m - points[i - 1].east_m, points[i].north_m - points[i - 1].north_m);
    EXPECT_NEAR(sum, double(r.length_m), 1e-3);
    EXPECT_EQ(r.source, r.width_m > 7 ? 0 : -1);
  }
  EXPECT_NEAR(length, 3980 + 3980 + 2 * std::hypot(20, 250), 1);
  EXPECT_EQ(borders, 4);
}

TEST(Roads, OfARegionAreThoseThatTouchIt) {
  const Prepared pack;
  EXPECT_EQ(pack.roads(box(480, 1100, 900, 1200)).size(), 1u) << "the lane";
  EXPECT_EQ(pack.roads(box(1500, 990, 1600, 1010)).size(), 1u) << "no vertex of it lies in the box";
  EXPECT_TRUE(pack.roads(box(1500, 1010, 1600, 1100)).empty());
  FeatureQuery q;
  q.ellipse = Ellipse{kWest + 1500, kSouth + 1050, 400, 0, 400, 2.4};
  EXPECT_TRUE(pack.roads(q).empty()) << "48 m of 50";
  q.ellipse->k = 2.6;
  EXPECT_EQ(pack.roads(q).size(), 1u) << "52 m of 50";
  FeatureQuery sure = kEverywhere;
  sure.min_confidence = 0.9f;
  EXPECT_EQ(pack.roads(sure).size(), 2u);
}

TEST(Roads, ThatDoNotFitAreCounted) {
  const Prepared pack;
  std::vector<Road> roads(3);
  std::vector<Point> vertices(5);
  size_t count = 0, vertex_count = 0;
  EXPECT_EQ(pack->find_roads(pack.layer("roads"), kEverywhere, roads, count, vertices, vertex_count),
            LF_BUFFER_TOO_SMALL);
  EXPECT_EQ(count, 8u);
  EXPECT_EQ(vertex_count, 17u);
  EXPECT_EQ(roads[1].first_vertex, 2u);
  EXPECT_EQ(roads[1].vertex_count, 2u) << "two fit: four of five vertices";
}

TEST(Features, MustBePrepared) {
  const OpenPack pack(vector_pack());
  size_t count = 0, vertices = 0;
  std::vector<Landmark> none;
  EXPECT_EQ(pack->find_landmarks(pack.layer("landmarks"), kEverywhere, {}, count), LF_NOT_PREPARED);
  EXPECT_EQ(pack->find_intersections(pack.layer("roads"), kEverywhere, {}, count), LF_NOT_PREPARED);
  EXPECT_EQ(pack->find_roads(pack.layer("roads"), kEverywhere, {}, count, {}, vertices), LF_NOT_PREPARED);
  // The south-western tile alone.
  ASSERT_EQ(pack->prepare(*pack->box(pack.layer("landmarks"), kWest + 10, kSouth + 10, kWest + 20, kSouth + 20, 8)),
            LF_OK);
  EXPECT_EQ(pack->find_landmarks(pack.layer("landmarks"), box(0, 0, 24, 14), {}, count), LF_OK);
  EXPECT_EQ(count, 0u) << "the first stands at 25, 15";
  EXPECT_EQ(pack->find_landmarks(pack.layer("landmarks"), box(0, 0, kSide + 1, 14), {}, count), LF_NOT_PREPARED);
}

TEST(Features, OfAnEmptyLayerAreNone) {
  Drawing d{.layers = {small_gray()}, .landmarks = std::vector<tiles::Landmark>(), .roads = tiles::RoadGraph()};
  const OpenPack pack(draw(d));
  ASSERT_EQ(pack.status(), LF_OK);
  EXPECT_TRUE(pack->verify(true));
  size_t count = 1;
  FeatureQuery q;
  q.ellipse = Ellipse{kWestM + 100, kSouthM + 100, 100, 0, 100, 3};
  EXPECT_EQ(pack->find_landmarks(pack.layer("landmarks"), q, {}, count), LF_OK);
  EXPECT_EQ(count, 0u);
}

TEST(Features, AskedForWronglyAreRefused) {
  const Prepared pack;
  const uint32_t landmarks = pack.layer("landmarks"), roads = pack.layer("roads"), gray = pack.layer("gray");
  size_t count = 0;
  EXPECT_EQ(pack->find_landmarks(roads, kEverywhere, {}, count), LF_WRONG_TYPE);
  EXPECT_EQ(pack->find_landmarks(gray, kEverywhere, {}, count), LF_WRONG_TYPE);
  EXPECT_EQ(pack->find_intersections(landmarks, kEverywhere, {}, count), LF_WRONG_TYPE);
  EXPECT_EQ(pack->find_landmarks(77, kEverywhere, {}, count), LF_INVALID_ARGUMENT);
  EXPECT_EQ(pack->find_landmarks(landmarks, box(10, 10, 5, 20), {}, count), LF_INVALID_ARGUMENT);
  EXPECT_EQ(pack->find_landmarks(landmarks, box(NAN, 10, 5, 20), {}, count), LF_INVALID_ARGUMENT);
  EXPECT_EQ(pack->find_landmarks(landmarks, box(-5000, 10, -4000, 20), {}, count), LF_OUTSIDE_MAP);
  FeatureQuery q = kEverywhere;
  q.min_confidence = NAN;
  EXPECT_EQ(pack->find_landmarks(landmarks, q, {}, count), LF_INVALID_ARGUMENT);
  q = kEverywhere;
  q.ellipse = Ellipse{kWest, kSouth, 1, 5, 1, 3};  // no covariance
  EXPECT_EQ(pack->find_landmarks(landmarks, q, {}, count), LF_INVALID_ARGUMENT);
  lf_feature_query c{};
  EXPECT_EQ(lf_find_landmarks(pack.c_pack(), landmarks, &c, nullptr, 0, &count), LF_INVALID_ARGUMENT) << "struct_size";
  c.struct_size = sizeof c;
  EXPECT_EQ(lf_find_landmarks(pack.c_pack(), landmarks, &c, nullptr, 1, &count), LF_INVALID_ARGUMENT);
  EXPECT_EQ(lf_find_landmarks(pack.c_pack(), landmarks, nullptr, nullptr, 0, &count), LF_INVALID_ARGUMENT);
  EXPECT_EQ(lf_find_landmarks(nullptr, landmarks, &c, nullptr, 0, &count), LF_INVALID_ARGUMENT);
  // And pixels of a layer that has none.
  uint8_t pixel[64];
  const Region r = *pack->box(landmarks, kWest, kSouth, kWest + 8, kSouth + 8, 8);
  EXPECT_EQ(pack->read(r, pixel, 1), LF_WRONG_TYPE);
  EXPECT_EQ(pack->tile(landmarks, 3, 244, 2441).status(), LF_WRONG_TYPE);
}

TEST(Features, HaveTheEpochsOfTheirTiles) {
  Drawing d = drawing();
  d.description.epochs = {{"2020-01-01", {}}, {"2019-01-01", {}}};
  d.vector_epochs = [](const tiles::TileIndex& t) {
    return t.x == 244 ? catalog::EpochSet{0, 1} : catalog::EpochSet{1};
  };
  const OpenPack pack(draw(d));
  std::array<uint16_t, 4> out{};
  EXPECT_EQ(*pack->tile_epochs(pack.layer("landmarks"), 3, 244, 2441, out), 2u);
  EXPECT_EQ(*pack->tile_epochs(pack.layer("landmarks"), 3, 245, 2441, out), 1u);
  EXPECT_EQ(out[0], 1);
}

// What preparing and the deep check say of the pack after a change of its first tile of landmarks.
template <typename Change>
std::pair<Status, Status> after(Change change) {
  Patch patch(vector_pack());
  for (const schema::BlockRecord& block : patch.blocks())
    for (schema::TileRecord& tile : patch.tiles(block))
      if (tile.codec == uint8_t(tiles::Codec::kVector)) {
        change(tile, patch.data(tile));
        const OpenPack pack(rehashed(std::move(patch)));
        EXPECT_EQ(pack.status(), LF_OK);
        size_t count = 0;
        EXPECT_NE(pack->find_landmarks(pack.layer("landmarks"), kEverywhere, {}, count), LF_OK);
        return {prepare(pack, "landmarks"), pack->verify(true).status()};
      }
  return {LF_OK, LF_OK};
}

TEST(Features, OfHostileTilesAreRefused) {
  constexpr std::pair<Status, Status> kDamaged = {LF_DAMAGED, LF_DAMAGED};
  using Record = schema::TileRecord;
  EXPECT_EQ(after([](Record&, std::span<uint8_t> data) { data[data.size() / 2] ^= 1; }), kDamaged);
  EXPECT_EQ(after([](Record& tile, auto) { --tile.length; }), kDamaged);
  EXPECT_EQ(after([](Record& tile, auto) { tile.length = 0; }), kDamaged);
  EXPECT_EQ(after([](Record&, std::span<uint8_t> data) { std::ranges::fill(data, 0xFF); }), kDamaged)
      << "counts without end";
  EXPECT_EQ(after([](Record& tile, auto) { tile.codec = uint8_t(tiles::Codec::kZstd); }), kDamaged);
  EXPECT_EQ(after([](Record& tile, auto) { tile.codec = 9; }), (std::pair{LF_UNKNOWN_VERSION, LF_UNKNOWN_VERSION}));
}

TEST(Features, OfASourceThatIsNotThereAreRefused) {
  Drawing d = drawing();
  d.description.sources.pop_back();
  const OpenPack pack(draw(d));
  ASSERT_EQ(pack.status(), LF_OK);
  EXPECT_EQ(prepare(pack, "landmarks"), LF_DAMAGED);
  EXPECT_EQ(prepare(pack, "roads"), LF_OK) << "these name the first source alone";
  EXPECT_EQ(pack->verify(true).status(), LF_DAMAGED);
  EXPECT_TRUE(pack->verify(false));
}

TEST(Landmarks, OfAClassThatIsNotKnownAreSkipped) {
  Drawing d{.landmarks = drawn_landmarks()};
  d.description.sources.resize(2);
  for (auto& source : d.description.sources) source.role = exporter::SourceRole::kVector, source.source.name = "some";
  for (size_t i = 0; i < 100; ++i) (*d.landmarks)[i].cls = tiles::LandmarkClass(11);
  const OpenPack pack(draw(d));
  ASSERT_EQ(prepare(pack, "landmarks"), LF_OK);
  std::vector<Landmark> out(10000);
  size_t count = 0;
  ASSERT_EQ(pack->find_landmarks(pack.layer("landmarks"), kEverywhere, out, count), LF_OK);
  EXPECT_EQ(count, 81u * 81 - 100);
}

}  // namespace
}  // namespace landfix::tests
