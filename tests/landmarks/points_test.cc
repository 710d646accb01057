// How found points are held against known ones.
#include "tools/eval/points.h"

#include <gtest/gtest.h>

#include <cmath>

namespace landfix::eval {
namespace {

const ingest::GridBounds kExtent = {0, 0, 100, 100};

TEST(MatchPoints, OneToOneTheNearestFirst) {
  // Two found near one known: the nearer is right, the other is wrong.
  const std::vector<FoundPoint> found = {{{12, 10}, 0.9}, {{11, 10}, 0.5}, {{50, 50}, 0.8}};
  const std::vector<KnownPoint> known = {{{10, 10}, true, 0, "a"}, {{80, 80}, true, 0, "b"}};
  const PointMatch m = match_points(found, known, kExtent, 6);
  EXPECT_EQ(m.right[0], std::optional(false));
  EXPECT_EQ(m.right[1], std::optional(true));
  EXPECT_EQ(m.right[2], std::optional(false));
  EXPECT_DOUBLE_EQ(m.distance_m[0], 1);
  EXPECT_TRUE(std::isnan(m.distance_m[1]));
  EXPECT_DOUBLE_EQ(m.recall(), 0.5);
  EXPECT_DOUBLE_EQ(m.precision(), 1.0 / 3);
}

TEST(MatchPoints, UnsureOnesCountNeitherWay) {
  // One is matched with the unsure point, one lies within its 15 m; both drop out.
  const std::vector<FoundPoint> found = {{{10, 11}, 1}, {{10, 22}, 1}, {{60, 60}, 1}};
  const std::vector<KnownPoint> known = {{{10, 10}, false, 15, "a"}, {{60, 61}, true, 0, "b"}};
  const PointMatch m = match_points(found, known, kExtent, 6);
  EXPECT_EQ(m.right[0], std::nullopt);
  EXPECT_EQ(m.right[1], std::nullopt);
  EXPECT_EQ(m.found(), 1u);
  EXPECT_DOUBLE_EQ(m.precision(), 1);
  EXPECT_DOUBLE_EQ(m.recall(), 1);
}

TEST(MatchPoints, OutsideOfTheExtentOnlyWhatIsRightCounts) {
  const std::vector<FoundPoint> found = {{{103, 50}, 1}, {{150, 50}, 1}};
  const std::vector<KnownPoint> known = {{{99, 50}, true, 0, "a"}};
  const PointMatch m = match_points(found, known, kExtent, 6);
  EXPECT_EQ(m.right[0], std::optional(true));
  EXPECT_EQ(m.right[1], std::nullopt);
}

TEST(Reports, CountByDistanceConfidenceAndReliability) {
  const std::vector<FoundPoint> found = {{{11.5, 10}, 0.95}, {{45, 40}, 0.55}, {{70, 70}, 0.52}};
  const std::vector<KnownPoint> known = {{{10, 10}, true, 0, "a"}, {{40, 40}, true, 0, "b"}};
  const PointReport r = report_points(found, known, kExtent, 6, 0.5);
  EXPECT_EQ(r.by_distance[0].sure_found, 0u);  // within 1 m
  EXPECT_EQ(r.by_distance[1].sure_found, 1u);  // within 2 m
  EXPECT_EQ(r.by_distance[4].sure_found, 2u);  // within 6 m
  EXPECT_EQ(r.by_confidence.back().found, 1u);
  EXPECT_EQ(r.by_confidence.back().right, 1u);
  EXPECT_EQ(r.reliability.steps[5].count, 2u);
  EXPECT_EQ(r.reliability.steps[5].right, 1u);
  EXPECT_NEAR(r.reliability.steps[5].confidence, 0.535, 1e-12);
  EXPECT_NE(to_text(r).find("recall 1.000 (2 of 2), precision 0.667 (2 of 3)"), std::string::npos);
  EXPECT_EQ(to_json(r)["by_distance"][4]["found_right"], 2);
}

TEST(FoundAgain, PairsEachOnce) {
  const std::vector<FoundPoint> a = {{{0, 0}, 1}, {{3, 0}, 1}}, b = {{{1, 0}, 1}};
  EXPECT_EQ(found_again(a, b, 5), 1u);
  EXPECT_EQ(found_again(a, {}, 5), 0u);
}

}  // namespace
}  // namespace landfix::eval
