// Lines of roads become a planar graph: nodes where they cross, none where they do not, small faces gone.
#include "builder/roads/road_planar.h"

#include <CGAL/Arr_segment_traits_2.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Surface_sweep_2_algorithms.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace landfix::landmarks {
namespace {

constexpr double kRoundabout_px = 50;

RoadLine line(std::vector<cv::Point2d> points, double width = 5, double probability = 0.8) {
  return {std::move(points), width, probability};
}

size_t degree(const PlanarRoads& roads, size_t node) {
  size_t count = 0;
  for (const PlanarRoads::Edge& e : roads.edges) count += size_t(e.from == node) + size_t(e.to == node);
  return count;
}

// Whether segments cross or touch but at their ends, in exact arithmetic.
bool is_planar(const PlanarRoads& roads) {
  using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
  std::vector<CGAL::Arr_segment_traits_2<Kernel>::Curve_2> segments;
  for (const PlanarRoads::Edge& e : roads.edges)
    for (size_t i = 1; i < e.line.points.size(); ++i) {
      const cv::Point2d &a = e.line.points[i - 1], &b = e.line.points[i];
      segments.emplace_back(Kernel::Point_2(a.x, a.y), Kernel::Point_2(b.x, b.y));
    }
  return !CGAL::do_curves_intersect(segments.begin(), segments.end());
}

TEST(PlanarRoads, LinesThatCrossMeetInANode) {
  const std::vector<RoadLine> lines = {line({{0, 50}, {100, 50}}, 6, 0.9), line({{40, 0}, {40, 100}}, 4, 0.5)};
  const PlanarRoads roads = planar_roads(lines, kRoundabout_px);
  ASSERT_EQ(roads.nodes.size(), 5u);  // four ends and the crossing
  ASSERT_EQ(roads.edges.size(), 4u);
  EXPECT_TRUE(is_planar(roads));
  for (size_t i = 0; i < roads.nodes.size(); ++i) {
    const bool crossing = cv::norm(roads.nodes[i] - cv::Point2d(40, 50)) < 1e-9;
    EXPECT_EQ(degree(roads, i), crossing ? 4u : 1u) << roads.nodes[i];
  }
  for (const PlanarRoads::Edge& e : roads.edges) {
    const bool flat = e.line.points.front().y == e.line.points.back().y;
    EXPECT_DOUBLE_EQ(e.line.width_px, flat ? 6 : 4);
    EXPECT_DOUBLE_EQ(e.line.probability, flat ? 0.9 : 0.5);
  }
}

TEST(PlanarRoads, AnEndOnALineIsANodeOfThree) {
  const std::vector<RoadLine> lines = {line({{0, 0}, {100, 0}}), line({{30, 0}, {30, 60}})};
  const PlanarRoads roads = planar_roads(lines, kRoundabout_px);
  ASSERT_EQ(roads.edges.size(), 3u);
  EXPECT_EQ(roads.nodes.size(), 4u);
  EXPECT_TRUE(is_planar(roads));
}

TEST(PlanarRoads, EndsThatMeetAloneAreOneEdgeAndOvershootsGo) {
  // Two lines end to end; a third crosses and reaches 2 pixels beyond.
  const std::vector<RoadLine> lines = {line({{0, 0}, {50, 0}}), line({{50, 0}, {90, 30}}), line({{20, -2}, {20, 70}})};
  const PlanarRoads roads = planar_roads(lines, kRoundabout_px);
  EXPECT_EQ(roads.edges.size(), 3u);  // from (20, 0): to (0, 0), to (90, 30) by (50, 0), to (20, 70)
  EXPECT_EQ(roads.nodes.size(), 4u);
}

TEST(PlanarRoads, ARingStaysARing) {
  // As round as a roundabout, but no road leads to it: one edge whose ends are one node.
  std::vector<cv::Point2d> ring;
  for (int i = 0; i <= 24; ++i) {
    const double a = 2 * std::numbers::pi * (i % 24) / 24;
    ring.push_back({100 + 60 * std::cos(a), 100 + 60 * std::sin(a)});
  }
  const PlanarRoads roads = planar_roads(std::vector<RoadLine>{line(ring)}, kRoundabout_px);
  ASSERT_EQ(roads.edges.size(), 1u);
  EXPECT_EQ(roads.edges[0].from, roads.edges[0].to);
  EXPECT_EQ(roads.edges[0].line.points.size(), 25u);
}

// A ring of `radius` with roads that leave it for the four sides, 100 pixels from its centre.
std::vector<RoadLine> roundabout(double radius) {
  std::vector<RoadLine> lines;
  for (int k = 0; k < 4; ++k) {
    std::vector<cv::Point2d> arc;
    for (int i = 0; i <= 6; ++i) {
      const double a = std::numbers::pi / 2 * (k + i / 6.0);
      arc.push_back({radius * std::cos(a), radius * std::sin(a)});
    }
    const double a = std::numbers::pi / 2 * k;
    lines.push_back(line({arc.front(), {100 * std::cos(a), 100 * std::sin(a)}}));
    lines.push_back(line(arc));
  }
  return lines;
}

TEST(PlanarRoads, ARoundaboutIsOneIntersection) {
  const PlanarRoads roads = planar_roads(roundabout(15), kRoundabout_px);
  ASSERT_EQ(roads.edges.size(), 4u);
  ASSERT_EQ(roads.nodes.size(), 5u);
  size_t centre = 0;
  for (size_t i = 0; i < roads.nodes.size(); ++i)
    if (degree(roads, i) == 4) centre = i;
  EXPECT_LT(cv::norm(roads.nodes[centre]), 0.05);  // the ring's centre, up to the rounding to 1/64
  // Larger than the limit it stays a ring with four intersections.
  EXPECT_EQ(planar_roads(roundabout(30), kRoundabout_px).edges.size(), 8u);
}

TEST(PlanarRoads, ASquareOfStreetsIsNoRoundabout) {
  std::vector<RoadLine> lines = {line({{0, -50}, {0, 80}}), line({{30, -50}, {30, 80}}), line({{-50, 0}, {80, 0}}),
                                 line({{-50, 30}, {80, 30}})};
  EXPECT_EQ(planar_roads(lines, kRoundabout_px).edges.size(), 12u);  // roundness pi / 4, below 0.86
}

TEST(PlanarRoads, ManyLinesGiveAPlanarGraphInAnyOrder) {
  // Sixty chords of a circle at angles of the golden section: hundreds of crossings.
  std::vector<RoadLine> lines;
  for (int i = 0; i < 60; ++i) {
    const double a = 2.399963 * i, b = a + 1 + 0.03 * i;
    lines.push_back(line({{500 * std::cos(a), 500 * std::sin(a)}, {500 * std::cos(b), 500 * std::sin(b)}}));
  }
  const PlanarRoads roads = planar_roads(lines, kRoundabout_px);
  EXPECT_GT(roads.edges.size(), 500u);
  EXPECT_TRUE(is_planar(roads));
  std::reverse(lines.begin(), lines.end());
  const PlanarRoads again = planar_roads(lines, kRoundabout_px);
  ASSERT_EQ(roads.edges.size(), again.edges.size());
  for (size_t i = 0; i < roads.edges.size(); ++i) EXPECT_EQ(roads.edges[i].line.points, again.edges[i].line.points);
}

TEST(PlanarRoads, OfNothingIsNothing) {
  EXPECT_TRUE(planar_roads({}, kRoundabout_px).edges.empty());
  const std::vector<RoadLine> point = {line({{3, 3}, {3, 3}})};
  EXPECT_TRUE(planar_roads(point, kRoundabout_px).edges.empty());
}

}  // namespace
}  // namespace landfix::landmarks
