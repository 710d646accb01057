// Roads from drawn images: blocks equal the whole, gaps close, intersections lie where roads meet, learning learns.
#include <gtest/gtest.h>

#include <cmath>

#include "builder/error.h"
#include "builder/roads/road_extraction.h"
#include "builder/roads/road_training.h"
#include "tests/roads/drawn_scene.h"

namespace landfix::landmarks {
namespace {

// Places as a sure detector would give them along a line.
void add_places(cv::Point2d a, cv::Point2d b, std::vector<RoadPlace>& places) {
  const cv::Point2d d = b - a;
  const int steps = int(std::max(std::abs(d.x), std::abs(d.y)));
  double theta = std::atan2(d.y, d.x);
  if (theta < 0) theta += 3.14159265358979;
  for (int i = 0; i <= steps; ++i) {
    const cv::Point2d p = a + d * (double(i) / steps);
    places.push_back({int(std::lround(p.x)), int(std::lround(p.y)), float(theta), 0.9f, 6});
  }
}

TEST(RoadPlaces, OfBlocksAreThoseOfTheWholeImage) {
  cv::Mat image = drawn({420, 380}, {{{0, 60}, {420, 300}}, {{200, 0}, {180, 380}}});
  cv::line(image, {0, 350}, {420, 150}, {105, 105, 110}, 22);  // wide enough for the scale of 2 m
  const RoadModel& model = default_road_model();
  const std::vector<RoadPlace> whole = find_road_places(image, {}, {0, 0, 420, 380}, model);
  ASSERT_GT(whole.size(), 300u);  // of 870 m of road
  std::vector<RoadPlace> joined;
  for (const cv::Rect& core : {cv::Rect(0, 0, 210, 190), cv::Rect(210, 0, 210, 190), cv::Rect(0, 190, 210, 190),
                               cv::Rect(210, 190, 210, 190)}) {
    // A block is read alone, with its halo and no more.
    const cv::Point first(std::max(0, core.x - kRoadHaloPx) & ~1, std::max(0, core.y - kRoadHaloPx) & ~1);
    const cv::Point last(std::min(420, core.br().x + kRoadHaloPx), std::min(380, core.br().y + kRoadHaloPx));
    for (RoadPlace p : find_road_places(image(cv::Rect(first, last)).clone(), {}, core - first, model)) {
      p.x += first.x;
      p.y += first.y;
      joined.push_back(p);
    }
  }
  std::sort(joined.begin(), joined.end(),
            [](const RoadPlace& a, const RoadPlace& b) { return std::tie(a.y, a.x) < std::tie(b.y, b.x); });
  EXPECT_EQ(joined, whole);
}

TEST(RoadPlaces, NoneOnEvenGround) {
  for (const int type : {CV_8UC1, CV_8UC3}) {
    const cv::Mat image(200, 200, type, cv::Scalar::all(120));
    EXPECT_TRUE(find_road_places(image, {}, {0, 0, 200, 200}, default_road_model()).empty());
  }
}

TEST(RoadGraph, MeetsWhereTheRoadsMeet) {
  std::vector<RoadPlace> places;
  add_places({20, 100}, {280, 100}, places);
  add_places({150, 100}, {150, 280}, places);
  const tiles::RoadGraph graph = link_roads(places, {300, 300}, [](double, double, double) { return 0; }, {1000, 5000});
  ASSERT_EQ(graph.edges.size(), 3u);
  ASSERT_EQ(intersections(graph), 1u);
  for (const tiles::RoadNode& n : graph.nodes) {
    if (n.kind != tiles::RoadNodeKind::kIntersection) continue;
    EXPECT_NEAR(n.east_m, 1150.5, 0.7);  // centre of pixel (150, 100)
    EXPECT_NEAR(n.north_m, 4899.5, 0.7);
  }
  EXPECT_NEAR(total_length(graph), 440, 8);  // 260 and 180, less what thinning takes off the three ends
  for (const tiles::RoadEdge& e : graph.edges) EXPECT_DOUBLE_EQ(e.width_m, 6);
}

TEST(RoadGraph, GapsCloseWhereTheImageSupportsThem) {
  std::vector<RoadPlace> places;
  add_places({20, 100}, {130, 100}, places);
  add_places({165, 100}, {280, 100}, places);
  const auto parts = [&](double p) {
    return link_roads(places, {300, 200}, [p](double, double, double) { return p; }, {}).edges.size();
  };
  EXPECT_EQ(parts(0.9), 1u);  // 35 pixels of little doubt
  EXPECT_EQ(parts(0.0), 2u);  // 35 times 1.05 is more than the budget of 31
}

TEST(RoadGraph, IsTheSameForAnyOrderOfPlaces) {
  std::vector<RoadPlace> places;
  add_places({10, 20}, {290, 250}, places);
  add_places({20, 260}, {280, 30}, places);
  const auto none = [](double, double, double) { return 0.5; };
  const tiles::RoadGraph a = link_roads(places, {300, 300}, none, {});
  std::reverse(places.begin(), places.end());
  const tiles::RoadGraph b = link_roads(places, {300, 300}, none, {});
  ASSERT_EQ(a.edges.size(), b.edges.size());
  EXPECT_EQ(intersections(a), 1u);
  for (size_t i = 0; i < a.nodes.size(); ++i) EXPECT_EQ(a.nodes[i].east_m, b.nodes[i].east_m);
}

TEST(RoadGraph, OfNoPlacesIsEmpty) {
  EXPECT_TRUE(link_roads({}, {100, 100}, [](double, double, double) { return 1; }, {}).edges.empty());
}

TEST(Boosting, LearnsWhatTellsTheClassesApart) {
  // Roads: feature 3 above 0.5 and feature 7 below 0.5, two features of 131. One tree of four leaves can say so.
  TrainingSet set;
  for (int i = 0; i < 3000; ++i) {
    set.rows.emplace_back();
    for (int f = 0; f < features::kRoadProfileFeatures; ++f)
      set.rows.back()[size_t(f)] = float(noise_at(i, f) >> 8) / float(1 << 24);
    set.is_road.push_back(set.rows.back()[3] > 0.5f && set.rows.back()[7] < 0.5f);
  }
  const features::BoostedTrees trees = boost(set, {.trees = 20, .leaves = 4, .rate = 0.3});
  size_t right = 0;
  for (size_t i = 0; i < set.rows.size(); ++i)
    right += (trees.probability(set.rows[i]) > 0.5f) == (set.is_road[i] != 0);
  EXPECT_GT(right, 2940u);  // 98 %: limits lie at quantiles, 0.5 between two of 255
  EXPECT_EQ(trees.serialise(), boost(set, {.trees = 20, .leaves = 4, .rate = 0.3}).serialise());
}

TEST(Boosting, NeedsBothClasses) {
  TrainingSet set;
  set.rows.resize(100);
  set.is_road.assign(100, 1);
  EXPECT_THROW(boost(set, {}), Error);
}

TEST(RoadModel, ReadsBackWhatItWrote) {
  const std::vector<uint8_t> bytes = default_road_model().serialise();
  EXPECT_LT(bytes.size(), 200000u);
  EXPECT_EQ(parse_road_model(bytes, "m").serialise(), bytes);
}

void expect_refused(const std::vector<uint8_t>& bytes, const std::string& word) {
  try {
    parse_road_model(bytes, "roads.model");
    FAIL() << "expected: " << word;
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kBadInput);
    EXPECT_NE(std::string(e.what()).find("roads.model"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << e.what();
  }
}

TEST(RoadModel, SaysWhatIsWrongWithItsBytes) {
  const std::vector<uint8_t> good = default_road_model().serialise();
  std::vector<uint8_t> bytes = good;
  bytes.push_back(0);
  expect_refused(bytes, "1 bytes more");
  bytes = good;
  bytes[4] = 3;
  expect_refused(bytes, "a version that is not known");
  bytes = good;
  bytes[0] = 'X';
  expect_refused(bytes, "not a model of trees");
  bytes = good;
  bytes[8] = 7;  // of another number of features
  bytes[9] = 0;
  expect_refused(bytes, "");
  expect_refused({}, "ends early");
}

TEST(RoadModel, SurvivesEveryTruncationAndFlippedBits) {
  const std::vector<uint8_t> good = default_road_model().serialise();
  for (size_t size = 0; size < good.size(); size += size < 300 ? 1 : 97)
    EXPECT_THROW(parse_road_model(std::span(good).first(size), "m"), Error) << size;
  // What is still taken for a model gives a probability for any profile.
  features::RoadProfile profile{};
  RoadScaleProfile at_both{};
  for (size_t i = 0; i < 4000; ++i) {
    std::vector<uint8_t> bytes = good;
    bytes[noise_at(int(i), 1) % (i % 2 == 0 ? 400 : bytes.size())] ^= uint8_t(1 << (i % 8));
    try {
      const RoadModel model = parse_road_model(bytes, "m");
      for (const float p : {model.colour.first.probability(profile), model.gray.second.probability(at_both)})
        EXPECT_TRUE(p >= 0 && p <= 1) << i;
    } catch (const Error&) {
    }
  }
}

}  // namespace
}  // namespace landfix::landmarks
