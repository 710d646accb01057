// Fields and lakes at 4 m per pixel: merging of ground of one colour, and what is made of it.
#include "builder/landmarks/broad_regions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "builder/landmarks/fusion.h"
#include "builder/landmarks/region_merging.h"

namespace landfix::landmarks {
namespace {

using tiles::LandmarkClass;

// Two halves of 2 x 2 pixels, 0 and 10: they join last, for 4 * 4 / 8 * 10^2 / 2 = 100.
cv::Mat two_halves() {
  cv::Mat colours = cv::Mat::zeros(2, 4, CV_16S);
  colours.colRange(2, 4) = 10;
  return colours;
}

TEST(MergeRegions, TheLeastDifferentFirst) {
  const MergeTree tree = merge_regions(two_halves(), cv::Mat::ones(2, 4, CV_8U), 1e6, 100);
  ASSERT_EQ(tree.nodes.size(), 15u);  // 8 pixels and 7 merges
  const MergeTree::Node& all = tree.nodes.back();
  EXPECT_EQ(all.count, 8);
  EXPECT_FLOAT_EQ(all.strength, 100);
  EXPECT_EQ(all.box, cv::Rect(0, 0, 4, 2));
  for (const MergeTree::Node& node : tree.nodes) {
    if (node.parent != 14) continue;
    EXPECT_EQ(node.count, 4);
    EXPECT_EQ(node.strength, 0);
    for (int i = node.first; i < node.first + node.count; ++i)
      EXPECT_EQ(tree.pixels[size_t(i)] % 4 < 2, node.box.x == 0) << "the pixels of a half";
  }
}

TEST(MergeRegions, EndsAtTheGreatestCostAndSizeAndAtTheMask) {
  const cv::Mat all = cv::Mat::ones(2, 4, CV_8U);
  EXPECT_EQ(merge_regions(two_halves(), all, 99, 100).nodes.size(), 14u);
  EXPECT_EQ(merge_regions(two_halves(), all, 1e6, 7).nodes.size(), 14u);
  cv::Mat holed = all.clone();
  holed.col(2) = 0;  // columns 0, 1 and 3 are left: 6 pixels, 3 + 1 merges
  EXPECT_EQ(merge_regions(two_halves(), holed, 1e6, 100).nodes.size(), 10u);
}

// Open ground of noisy gray, 1200 m north to south.
class Drawn {
 public:
  explicit Drawn(int columns = 300, int rows = 300) {
    cv::Mat ground(rows, columns, CV_8U, cv::Scalar(255)), noise(rows, columns, CV_8UC3);
    cv::RNG random(7);
    random.fill(noise, cv::RNG::UNIFORM, 96, 105);
    std::vector<cv::Mat> planes = {ground, ground, cv::Mat::zeros(rows, columns, CV_8U)}, colours;
    cv::split(noise, colours);
    planes.insert(planes.end(), colours.begin(), colours.end());
    cv::merge(planes, view.pixels);
    view.west_m = 1000, view.north_m = 9000, view.gsd_m = kBroadGsd_m;
  }
  // 240 m x 140 m, turned by 20 degrees, brighter than around.
  void field(const cv::Point2f& centre) {
    cv::Mat inside = cv::Mat::zeros(view.pixels.size(), CV_8U);
    cv::Point2f corners[4];
    cv::RotatedRect(centre, {60, 35}, 20).points(corners);
    std::vector<cv::Point> polygon(corners, corners + 4);
    cv::fillConvexPoly(inside, polygon, 255);
    for (int k = 3; k < 6; ++k) {
      cv::Mat plane;
      cv::extractChannel(view.pixels, plane, k);
      cv::add(plane, 30, plane, inside);
      cv::insertChannel(plane, view.pixels, k);
    }
  }
  void lake(const cv::Point& centre) {
    cv::Mat inside = cv::Mat::zeros(view.pixels.size(), CV_8U);
    cv::ellipse(inside, centre, {30, 20}, 0, 0, 360, 255, cv::FILLED);
    view.pixels.setTo(0, inside);
    for (const auto& [k, value] : {std::pair(0, 255), std::pair(2, 255)}) {
      cv::Mat plane;
      cv::extractChannel(view.pixels, plane, k);
      plane.setTo(value, inside);
      cv::insertChannel(plane, view.pixels, k);
    }
  }
  std::vector<Extracted> find() const { return find_broad(view, cv::Rect({}, view.pixels.size())); }

  features::GridImage view;
};

std::vector<Extracted> sure(std::vector<Extracted> all, LandmarkClass cls) {
  std::erase_if(all, [&](const Extracted& e) { return e.landmark.cls != cls || e.landmark.confidence < 0.5; });
  return all;
}

TEST(FindBroad, AFieldWhereItIs) {
  Drawn drawn;
  drawn.field({150, 120});
  const std::vector<Extracted> found = sure(drawn.find(), LandmarkClass::kField);
  ASSERT_EQ(found.size(), 1u);
  const tiles::Landmark& m = found[0].landmark;
  EXPECT_NEAR(m.east_m, 1000 + 150.5 * 4, 4);
  EXPECT_NEAR(m.north_m, 9000 - 120.5 * 4, 4);
  EXPECT_NEAR(m.length_m, 240, 12) << "steps of 4 m along slanted sides";
  EXPECT_NEAR(m.width_m, 140, 12);
  EXPECT_NEAR(m.orientation_rad * 180 / std::numbers::pi, 110, 3) << "20 degrees south of east";
  std::vector<cv::Point2f> outline;
  for (const cv::Point2d& p : found[0].outline) outline.emplace_back(p - cv::Point2d(m.east_m, m.north_m));
  EXPECT_LE(outline.size(), 10u) << "four corners, and little else at a tolerance of 8 m";
  EXPECT_NEAR(cv::contourArea(outline), 240 * 140, 0.05 * 240 * 140);
}

TEST(FindBroad, ALakeAndNoFieldInIt) {
  Drawn drawn;
  drawn.lake({150, 120});
  const std::vector<Extracted> found = sure(drawn.find(), LandmarkClass::kWater);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].landmark.east_m, 1000 + 150.5 * 4, 2);
  EXPECT_NEAR(found[0].landmark.length_m, 61 * 4, 8);
  EXPECT_TRUE(sure(drawn.find(), LandmarkClass::kField).empty());
}

TEST(FindBroad, NothingInEvenGroundOrWithoutData) {
  Drawn drawn;
  EXPECT_TRUE(sure(drawn.find(), LandmarkClass::kField).empty());
  drawn.view.pixels = cv::Mat::zeros(300, 300, CV_8UC(broad_channels(3)));
  EXPECT_TRUE(drawn.find().empty());
  drawn.view.pixels = cv::Mat::zeros(300, 300, CV_8UC(broad_channels(1)));
  EXPECT_TRUE(drawn.find().empty());
}

TEST(FindBroad, WhatIsNotSeenWholeIsLeftOut) {
  Drawn drawn;
  drawn.field({20, 120});  // reaches beyond the western rim
  drawn.field({150, 220});
  cv::Mat without = drawn.view.pixels(cv::Rect(150, 0, 3, 300));  // a gap in the data through the other
  without.setTo(0);
  for (const Extracted& e : sure(drawn.find(), LandmarkClass::kField)) {
    EXPECT_GT(std::abs(e.landmark.east_m - (1000 + 20 * 4)), 60) << "at the rim";
    EXPECT_GT(std::abs(e.landmark.east_m - (1000 + 150 * 4)), 140) << "beside the gap";
  }
}

TEST(FindBroad, WindowsFindEveryFieldOnce) {
  Drawn drawn(1100, 300);
  const std::vector<cv::Point2f> centres = {{100, 150}, {500, 150}, {560, 60}, {1023, 150}};  // edges at 512 and 1024
  for (const cv::Point2f& c : centres) drawn.field(c);
  const std::vector<Extracted> found = sure(find_all_broad(drawn.view), LandmarkClass::kField);
  EXPECT_EQ(found.size(), centres.size());
  for (const cv::Point2f& c : centres)
    EXPECT_EQ(std::ranges::count_if(found,
                                    [&](const Extracted& e) {
                                      return std::abs(e.landmark.east_m - (1000 + double(c.x) * 4)) < 8 &&
                                             std::abs(e.landmark.north_m - (9000 - double(c.y) * 4)) < 8;
                                    }),
              1);
}

TEST(FuseEpochs, AFieldOfTheNewestDateAloneIsWeak) {
  Sighting s{{}, 0, 2, true};
  s.landmark.cls = LandmarkClass::kField;
  s.landmark.length_m = s.landmark.width_m = 200;
  s.landmark.confidence = 0.9;
  EXPECT_NEAR(fuse_epochs({s}).at(0).confidence, 0.45, 1e-9) << "one date of two";
  s.landmark.cls = LandmarkClass::kBuilding;
  EXPECT_NEAR(fuse_epochs({s}).at(0).confidence, 0.9, 1e-9) << "a house may be new";
}

TEST(WithoutCovered, KeepsOneOfADateAndAllOfOthers) {
  Sighting s{{}, 0, 2, true};
  s.landmark.cls = LandmarkClass::kField;
  s.landmark.length_m = s.landmark.width_m = 200;
  Sighting near = s, other = s, far = s;
  near.landmark.east_m = 90, other.epoch = 1, far.landmark.east_m = 110;
  EXPECT_EQ(without_covered({s, near}).size(), 1u);
  EXPECT_EQ(without_covered({s, other}).size(), 2u);
  EXPECT_EQ(without_covered({s, far}).size(), 2u);
}

}  // namespace
}  // namespace landfix::landmarks
