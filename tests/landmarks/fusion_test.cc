// Views of several dates become one landmark.
#include "builder/landmarks/fusion.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace landfix::landmarks {
namespace {

using tiles::Landmark;
using tiles::LandmarkClass;

Landmark house(double east_m, double north_m, double confidence = 0.8) {
  Landmark m;
  m.east_m = east_m, m.north_m = north_m;
  m.length_m = 12, m.width_m = 8;
  m.confidence = confidence;
  return m;
}

Sighting seen(const Landmark& m, uint16_t epoch, uint16_t chances = 1) { return {m, epoch, chances, epoch == 0}; }

TEST(FuseEpochs, ViewsOfOneHouseAreCountedAndAveraged) {
  const auto fused = fuse_epochs(
      {seen(house(100, 200, 0.9), 0, 3), seen(house(103, 200, 0.6), 1, 3), seen(house(100, 203, 0.6), 2, 3)});
  ASSERT_EQ(fused.size(), 1u);
  EXPECT_EQ(fused[0].epochs_seen, 3);
  EXPECT_NEAR(fused[0].east_m, 100 + 3 * 0.6 / 2.1, 1e-9);
  EXPECT_NEAR(fused[0].north_m, 200 + 3 * 0.6 / 2.1, 1e-9);
  EXPECT_DOUBLE_EQ(fused[0].confidence, 0.9) << "the newest is surer than the mean, 0.7";
}

TEST(FuseEpochs, NewHousesStayAndGoneOnesFade) {
  const auto fused =
      fuse_epochs({seen(house(0, 0, 0.8), 0, 4), seen(house(500, 0, 0.9), 3, 4), seen(house(900, 0, 0.8), 1, 4),
                   seen(house(900, 0, 0.8), 2, 4), seen(house(900, 0, 0.8), 3, 4)});
  ASSERT_EQ(fused.size(), 2u) << "one date of four, and not the newest: 0.9 / 4 is too little";
  EXPECT_DOUBLE_EQ(fused[0].confidence, 0.8);
  EXPECT_EQ(fused[0].epochs_seen, 1);
  EXPECT_NEAR(fused[1].confidence, 0.6, 1e-12) << "three of four dates";
  EXPECT_EQ(fused[1].epochs_seen, 3);
}

TEST(FuseEpochs, DatesWithoutImageryAreNoEvidenceAgainst) {
  const auto fused = fuse_epochs({{house(0, 0, 0.5), 2, 1, true}});
  ASSERT_EQ(fused.size(), 1u);
  EXPECT_DOUBLE_EQ(fused[0].confidence, 0.5);
}

TEST(FuseEpochs, OtherClassesSizesAndPlacesStayApart) {
  Landmark tree = house(0, 0);
  tree.cls = LandmarkClass::kTree;
  Landmark hall = house(0, 0);
  hall.length_m = 40, hall.width_m = 30;
  const auto fused = fuse_epochs(
      {seen(house(0, 0), 0), seen(tree, 1), seen(hall, 2), seen(house(5.1, 0), 3), seen(house(-4.9, 0), 4)});
  EXPECT_EQ(fused.size(), 4u) << "only the last is the first house";
  EXPECT_EQ(std::ranges::count(fused, 2, &Landmark::epochs_seen), 1);
}

TEST(FuseEpochs, HousesOfOneDateAreNeverJoined) {
  EXPECT_EQ(fuse_epochs({seen(house(0, 0), 0), seen(house(3, 0), 0)}).size(), 2u);
  const auto rows =
      fuse_epochs({seen(house(0, 0), 0), seen(house(4, 0), 0), seen(house(0.5, 0), 1), seen(house(4.5, 0), 1)});
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_NEAR(rows[0].east_m, 0.25, 1e-9) << "each with the nearest";
  EXPECT_NEAR(rows[1].east_m, 4.25, 1e-9);
}

TEST(FuseEpochs, OrderOfSightingsDoesNotMatter) {
  std::vector<Sighting> sightings;
  for (int i = 0; i < 40; ++i)
    sightings.push_back(seen(house(i % 10 * 4, i % 7 * 3, 0.4 + 0.01 * i), uint16_t(i % 4), 4));
  const auto first = fuse_epochs(sightings);
  std::ranges::reverse(sightings);
  const auto second = fuse_epochs(sightings);
  ASSERT_EQ(first.size(), second.size());
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].east_m, second[i].east_m);
    EXPECT_EQ(first[i].confidence, second[i].confidence);
    EXPECT_EQ(first[i].epochs_seen, second[i].epochs_seen);
  }
}

TEST(DropOnRoads, WhatStandsInTheMiddleOfALikelyRoad) {
  tiles::RoadGraph roads;
  roads.nodes = {{0, 0}, {100, 0}, {0, 50}, {100, 50}};
  roads.edges = {{0, 1, 6, 0.9, 0, {{50, 0}}}, {2, 3, 6, 0.4, 0, {}}};
  Landmark tree = house(30, 0);
  tree.cls = LandmarkClass::kTree;
  std::vector<Landmark> all = {house(70.5, 1.8), house(70, 2.6), house(-4, 0), house(50, 50), tree};
  drop_on_roads(all, roads);
  ASSERT_EQ(all.size(), 4u) << "a third of six metres; the second road is unlikely";
  EXPECT_DOUBLE_EQ(all[0].north_m, 2.6);
}

}  // namespace
}  // namespace landfix::landmarks
