// Roads of whole scenes with the model that comes with landfix: found where they are, turned and mirrored alike, in
// gray too, none where there is none, and the same graph whatever the blocks.
#include <gtest/gtest.h>

#include <cmath>

#include "builder/roads/road_extraction.h"
#include "tests/roads/drawn_scene.h"

namespace landfix::landmarks {
namespace {

// A street of 400 m, and one that ends on it.
cv::Mat tee() { return drawn({420, 380}, {{{0, 200}, {420, 200}}, {{200, 200}, {200, 380}}}); }

tiles::RoadGraph roads_of(const cv::Mat& pixels, const cv::Mat& valid = {}) {
  features::GridImage image;
  image.pixels = pixels;
  image.valid = valid;
  image.west_m = 1000;
  image.north_m = 5000;
  image.gsd_m = 1;
  return extract_roads(image, default_road_model(), 1);
}

cv::Point2d intersection_px(const tiles::RoadGraph& graph) {
  for (const tiles::RoadNode& n : graph.nodes)
    if (n.kind == tiles::RoadNodeKind::kIntersection) return {n.east_m - 1000.5, 4999.5 - n.north_m};
  return {-1, -1};
}

void expect_tee(const tiles::RoadGraph& graph, const cv::Point2d& at) {
  ASSERT_EQ(intersections(graph), 1u);
  EXPECT_LT(cv::norm(intersection_px(graph) - at), 2) << intersection_px(graph);
  EXPECT_NEAR(total_length(graph), 600, 30);  // 420 + 180 m, less what is lost at the border
  for (const tiles::RoadEdge& e : graph.edges) {
    EXPECT_NEAR(e.width_m, 6, 1.01);  // 5 or 7 of the filter's widths
    EXPECT_GT(e.confidence, 0.5);
  }
}

TEST(RoadScene, AStreetThatEndsOnAnotherIsAnIntersectionOfThree) { expect_tee(roads_of(tee()), {200, 200}); }

TEST(RoadScene, TurnedAndMirroredTheRoadsAreTurnedAndMirrored) {
  cv::Mat image;
  cv::rotate(tee(), image, cv::ROTATE_90_CLOCKWISE);
  expect_tee(roads_of(image), {379 - 200, 200});
  cv::flip(tee(), image, 1);
  expect_tee(roads_of(image), {419 - 200, 200});
}

TEST(RoadScene, GrayIsEnough) {
  cv::Mat gray;
  cv::cvtColor(tee(), gray, cv::COLOR_RGB2GRAY);
  expect_tee(roads_of(gray), {200, 200});
}

// A road `width_m` across from left to right at y = 200, with a street of 6 m that ends on it. `median_m`: of grass
// between its two carriageways. Beside the edges there is paint.
cv::Mat highway(int width_m, int median_m) {
  cv::Mat image(cv::Size(500, 400), CV_8UC3, cv::Scalar(80, 110, 60));
  image(cv::Rect(247, 200, 6, 200)).setTo(cv::Scalar(150, 150, 150));
  image(cv::Rect(0, 200 - width_m / 2, 500, width_m)).setTo(cv::Scalar(105, 105, 110));
  if (median_m > 0) image(cv::Rect(0, 200 - median_m / 2, 500, median_m)).setTo(cv::Scalar(85, 110, 65));
  for (const int y : {201 - width_m / 2, 198 + width_m / 2}) image(cv::Rect(0, y, 500, 1)) += cv::Scalar(20, 20, 20);
  cv::GaussianBlur(image, image, {5, 5}, 0.8);  // as optics do
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      for (int k = 0; k < 3; ++k) image.at<cv::Vec3b>(y, x)[k] += uint8_t(noise_at(x + 7 * k, y) >> 28);
  return image;
}

void expect_highway(const tiles::RoadGraph& graph) {
  // 500 m along its middle and 200 m of street, less what is lost at the border; edges or carriageways found beside it
  // would make it longer.
  EXPECT_NEAR(total_length(graph), 700, 35);
  for (const tiles::RoadEdge& e : graph.edges) {
    std::vector<tiles::RoadPoint> line = e.vertices;
    for (const uint32_t node : {e.from, e.to}) line.push_back({graph.nodes[node].east_m, graph.nodes[node].north_m});
    for (const tiles::RoadPoint& p : line) {
      if (std::abs(p.east_m - 1250) < 4) continue;  // the street
      EXPECT_NEAR(p.north_m, 4800, 2) << p.east_m;
    }
  }
}

TEST(RoadScene, TwoCarriagewaysAreOneLineBetweenThem) { expect_highway(roads_of(highway(22, 4))); }

TEST(RoadScene, AWideRoadIsItsMiddleAndNotItsEdges) {
  const tiles::RoadGraph graph = roads_of(highway(24, 0));
  expect_highway(graph);
  for (const tiles::RoadEdge& e : graph.edges) EXPECT_TRUE(e.width_m > 17 || e.width_m < 8) << e.width_m;
  ASSERT_EQ(intersections(graph), 1u);  // with the street, from which its edge keeps 12 m
  EXPECT_LT(cv::norm(intersection_px(graph) - cv::Point2d(249.5, 199.5)), 3) << intersection_px(graph);
}

TEST(RoadScene, BlocksGiveTheGraphOfTheWhole) {
  const cv::Mat image = tee();
  const cv::Size size = image.size();
  const RoadModel& model = default_road_model();
  std::vector<RoadPlace> places;
  for (const cv::Rect& core : {cv::Rect(210, 170, 210, 210), cv::Rect(0, 0, 210, 170), cv::Rect(210, 0, 210, 170),
                               cv::Rect(0, 170, 210, 210)}) {
    const cv::Point first(std::max(0, core.x - kRoadHaloPx) & ~1, std::max(0, core.y - kRoadHaloPx) & ~1);
    const cv::Point last(std::min(size.width, core.br().x + kRoadHaloPx),
                         std::min(size.height, core.br().y + kRoadHaloPx));
    for (RoadPlace p : find_road_places(image(cv::Rect(first, last)).clone(), {}, core - first, model)) {
      p.x += first.x;
      p.y += first.y;
      places.push_back(p);
    }
  }
  RoadEvidence evidence([&](const cv::Rect& r) { return image(r).clone(); }, size, model);
  const tiles::RoadGraph a = link_roads(places, size, std::ref(evidence), {1000, 5000, 1}), b = roads_of(image);
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  ASSERT_EQ(a.edges.size(), b.edges.size());
  ASSERT_EQ(a.edges.size(), 3u);
  for (size_t i = 0; i < a.nodes.size(); ++i) {
    EXPECT_EQ(a.nodes[i].east_m, b.nodes[i].east_m);
    EXPECT_EQ(a.nodes[i].north_m, b.nodes[i].north_m);
  }
  for (size_t i = 0; i < a.edges.size(); ++i) {
    EXPECT_EQ(a.edges[i].confidence, b.edges[i].confidence);
    ASSERT_EQ(a.edges[i].vertices.size(), b.edges[i].vertices.size());
  }
}

TEST(RoadScene, EvidenceIsTheSameWhateverTilesItReads) {
  // 600 pixels: nine tiles of 256. What it says at the seam is what an image in one piece says.
  const cv::Mat image = drawn({600, 600}, {{{0, 250}, {600, 262}}});
  const RoadModel& model = default_road_model();
  RoadEvidence tiled([&](const cv::Rect& r) { return image(r); }, image.size(), model);
  for (const int x : {20, 250, 256, 260, 511, 512, 590}) {
    const cv::Rect around = cv::Rect(x - 60, 190, 121, 130) & cv::Rect(0, 0, 600, 600);
    RoadEvidence alone([&](const cv::Rect& r) { return image(r + around.tl()); }, around.size(), model);
    EXPECT_EQ(tiled(x, 256, 0.02), alone(x - around.x, 256 - around.y, 0.02)) << x;
  }
}

TEST(RoadScene, NoRoadsWhereThereAreNone) {
  // A wood: blobs of crowns of all brightness. A field: fine noise. The sea: long waves in one direction.
  cv::Mat wood(400, 400, CV_8UC3), field(400, 400, CV_8UC3), sea(400, 400, CV_8UC3);
  for (int y = 0; y < 400; ++y) {
    for (int x = 0; x < 400; ++x) {
      const uint32_t crown = noise_at(x / 5, y / 5) >> 24, fine = noise_at(x, y) >> 28;
      const double wave = 8 * std::sin(0.35 * x + 0.12 * y + 2 * std::sin(0.05 * y));
      wood.at<cv::Vec3b>(y, x) = cv::Vec3b(uint8_t(25 + crown / 5), uint8_t(40 + crown / 4), uint8_t(20 + crown / 8));
      field.at<cv::Vec3b>(y, x) = cv::Vec3b(uint8_t(120 + fine), uint8_t(130 + fine), uint8_t(80 + fine / 2));
      sea.at<cv::Vec3b>(y, x) = cv::Vec3b(uint8_t(40 + wave), uint8_t(60 + wave), uint8_t(80 + wave));
    }
  }
  cv::GaussianBlur(wood, wood, {5, 5}, 1.2);
  for (const cv::Mat& scene : {wood, field, sea}) {
    EXPECT_EQ(total_length(roads_of(scene)), 0);
    cv::Mat gray;
    cv::cvtColor(scene, gray, cv::COLOR_RGB2GRAY);
    EXPECT_EQ(total_length(roads_of(gray)), 0);
  }
}

TEST(RoadScene, WithoutDataThereAreNoRoads) {
  const cv::Mat image = tee();
  EXPECT_TRUE(roads_of(image, cv::Mat(image.size(), CV_8UC1, cv::Scalar(0))).edges.empty());
  // Data in the left half alone: no road farther right than that.
  cv::Mat valid(image.size(), CV_8UC1, cv::Scalar(255));
  valid.colRange(150, image.cols).setTo(0);
  const tiles::RoadGraph left = roads_of(image, valid);
  EXPECT_GT(total_length(left), 100);  // 140 m
  for (const tiles::RoadNode& n : left.nodes) EXPECT_LE(n.east_m, 1150);
}

TEST(RoadScene, ImagesSmallerThanTheHaloAndTheWindowsWork) {
  for (const cv::Size& size : {cv::Size(1, 1), cv::Size(2, 3), cv::Size(30, 9), cv::Size(70, 50)}) {
    const cv::Mat image = drawn(size, {{{0, size.height / 2}, {size.width, size.height / 2}}});
    EXPECT_LE(total_length(roads_of(image)), size.width) << size;
  }
}

}  // namespace
}  // namespace landfix::landmarks
