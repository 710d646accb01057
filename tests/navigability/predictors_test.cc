// Evidence of how well a place can be matched: what dates did to each other, and what one date shows.
#include "builder/navigability/predictors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <vector>

#include "tests/nav/scene.h"

namespace landfix::navigability {
namespace {

using features::GridImage;

constexpr int kSidePx = 260;
constexpr Footprint kView{.template_m = 80, .search_m = 80, .hit_m = 7.5};  // at 2 m: 40 px searched over ±40

/// Around (0, 0) at 2 m per pixel.
GridImage ground(const cv::Mat& pixels) { return {pixels, {}, -0.5 * 2 * pixels.cols, 0.5 * 2 * pixels.rows, 2}; }

GridImage fields(uint64_t seed, uint64_t season) { return ground(nav::testing::countryside(kSidePx, seed, season)); }

Predictors judge(const std::vector<GridImage>& dates, double east_m = 0, double north_m = 0) {
  return Witness(dates).at(east_m, north_m, kView);
}

/// Bars of random width that run north-south, with noise of its own on every date.
GridImage bars(uint64_t noise_seed) {
  cv::RNG widths(5), noise(noise_seed);
  cv::Mat image(kSidePx, kSidePx, CV_8UC3, cv::Scalar::all(90));
  for (int x = 0, bar = 0; x < kSidePx; x += widths.uniform(5, 23), ++bar)
    image.colRange(x, kSidePx).setTo(cv::Scalar::all(bar % 2 ? 90 : 170));
  cv::Mat grain(image.size(), CV_8UC3);
  noise.fill(grain, cv::RNG::UNIFORM, 0, 40);
  return ground(image + grain);
}

TEST(Witness, DatesThatShowTheSameAreFoundInEachOther) {
  const Predictors p = judge({fields(3, 0), fields(3, 1), fields(3, 2)});
  EXPECT_EQ(p.dates, 3);
  EXPECT_EQ(p.template_px, 40);
  EXPECT_EQ(p.found, 1) << "seasons change colours and some edges: registration finds such places";
  EXPECT_GT(p.least_logit, std::log(0.9 / 0.1)) << "most of the likelihood lies at the truth on every date";
  EXPECT_GE(p.mean_logit, p.least_logit - 1e-9);
}

TEST(Witness, ADateOfAnotherPlaceFaresWorst) {
  const Predictors p = judge({fields(3, 0), fields(3, 1), fields(8, 0)});
  EXPECT_NEAR(p.found, 2 / 3.0, 1e-9) << "the third date shows other ground";
  EXPECT_LT(p.least_logit, 0) << "less than half of its likelihood can lie at the truth";
  EXPECT_GT(p.mean_logit, p.least_logit + 1);
}

TEST(Witness, OnlyDatesThatShowThePlaceHaveASay) {
  std::vector<GridImage> dates = {fields(3, 0), fields(3, 1), fields(8, 0)};
  dates[2].valid = cv::Mat(kSidePx, kSidePx, CV_8U, cv::Scalar(255));
  dates[2].valid.colRange(0, kSidePx / 2 + 10).setTo(0);  // 30 of 40 columns of the view around (0, 0)
  const Predictors p = judge(dates);
  EXPECT_EQ(p.dates, 2);
  EXPECT_EQ(p.found, 1) << "the other ground is not in the view";
}

TEST(Witness, WhatRepeatsHasALookAlikeWhereItRepeats) {
  const cv::Mat piece = nav::testing::countryside(kSidePx, 3)(cv::Rect(0, 0, 30, kSidePx));
  cv::Mat rows, image;
  cv::repeat(piece, 1, 10, rows);
  image = rows.colRange(0, kSidePx).clone();
  const Predictors p = judge({ground(image)});
  ASSERT_TRUE(p.look_alike);
  EXPECT_NEAR(std::abs(p.look_alike->east_m), 60, 2.1) << "30 px of 2 m to the east or the west";
  EXPECT_NEAR(p.look_alike->north_m, 0, 2.1);
  EXPECT_GT(p.look_alike->strength, 0.95);
  const Predictors unique = judge({fields(3, 0)});
  ASSERT_TRUE(unique.look_alike);
  EXPECT_LT(unique.look_alike->strength, 0.6) << "fields that do not repeat";
}

TEST(Witness, AlongBarsAFixIsLessCertainThanAcross) {
  const Predictors p = judge({bars(1), bars(2)});
  EXPECT_GT(p.covariance_m2[3], 4 * p.covariance_m2[0]) << "nothing but grain holds it in north";
  const double of_fields = judge({fields(3, 0), fields(3, 1)}).background;
  EXPECT_GT(p.background, of_fields + 0.1) << "everything runs in one direction";
  EXPECT_NEAR(of_fields, 0, 0.1) << "unrelated places: some agree, some contradict; the peak does not count";
}

TEST(Witness, FlatGroundHasNoStructureAndIsNotFound) {
  const cv::Mat flat(kSidePx, kSidePx, CV_8UC3, cv::Scalar(80, 120, 90));
  const Predictors p = judge({ground(flat), ground(flat + cv::Scalar::all(10))});
  EXPECT_EQ(p.dates, 2);
  EXPECT_EQ(p.structure, 0);
  EXPECT_EQ(p.least_logit, -kLargestLogit);
  EXPECT_EQ(p.found, 0);
  EXPECT_FALSE(p.look_alike);
}

TEST(Witness, StructureIsTheMeanLengthInTheViewAlone) {
  cv::Mat half(kSidePx, kSidePx, CV_8UC3, cv::Scalar::all(100));
  const cv::Mat textured = nav::testing::countryside(kSidePx, 3);
  textured.colRange(kSidePx / 2, kSidePx).copyTo(half.colRange(kSidePx / 2, kSidePx));
  Witness witness(std::vector{ground(half)});
  const double west = witness.at(-100, 0, kView).structure, east = witness.at(100, 0, kView).structure;
  EXPECT_EQ(west, 0);
  EXPECT_GT(east, 0.05);
  EXPECT_NEAR(east, judge({ground(textured)}, 100, 0).structure, 1e-9) << "what lies beyond the view does not count";
}

TEST(Witness, EveryMatcherHasEvidenceOfItsOwn) {
  std::vector<GridImage> dates = {fields(3, 0), fields(3, 0), fields(8, 0)};
  dates[1].pixels = dates[0].pixels * 0.8;  // nothing but the light has changed
  Witness witness(dates, nav::kMethods);
  double gray = 0;
  for (const nav::Method method : nav::kMethods) {
    const Predictors p = witness.at(0, 0, kView, method);
    EXPECT_EQ(p.dates, 3);
    EXPECT_EQ(p.newest, 0);
    EXPECT_NEAR(p.found, 2 / 3.0, 1e-9) << nav::name_of(method) << ": the third date shows other ground";
    if (method == nav::Method::kGray) gray = p.mean_logit;
  }
  EXPECT_NE(gray, witness.at(0, 0, kView, nav::Method::kEdge).mean_logit);
}

TEST(Witness, GrayIsMatchedWithTheNewestDateThatShowsAPixel) {
  std::vector<GridImage> dates = {fields(8, 0), fields(3, 0), fields(3, 0)};
  for (GridImage& date : dates) date.valid = cv::Mat(kSidePx, kSidePx, CV_8U, cv::Scalar(255));
  dates[0].valid.colRange(kSidePx / 2 - 60, kSidePx).setTo(0);
  const nav::Method gray[] = {nav::Method::kGray};
  Witness witness(dates, gray);
  const Predictors p = witness.at(40, 0, kView, nav::Method::kGray);
  EXPECT_EQ(p.dates, 2);
  EXPECT_EQ(p.newest, 1);
  EXPECT_EQ(p.found, 1) << "where the newest date shows nothing the map has the next";
}

TEST(Witness, OneDateIsMatchedWithViewsOfOtherDays) {
  const Predictors roofs = judge({fields(3, 0)});
  EXPECT_EQ(roofs.dates, 1);
  EXPECT_GE(roofs.views, kLeastViews);
  EXPECT_LE(roofs.views, kMostViews);
  cv::Mat grain(kSidePx, kSidePx, CV_8UC3);
  cv::RNG(6).fill(grain, cv::RNG::UNIFORM, 90, 110);
  const Predictors field = judge({ground(grain)});
  EXPECT_GT(roofs.mean_logit, field.mean_logit + 3) << "a field's grain is another one on another day";
  EXPECT_GT(roofs.found, 0.5);
  EXPECT_LT(field.found, 0.5);
  const Predictors again = judge({fields(3, 0)});
  EXPECT_EQ(again.mean_logit, roofs.mean_logit);
  EXPECT_EQ(again.covariance_m2, roofs.covariance_m2);
}

TEST(Witness, ViewsAreDrawnForOrientationAlone) {
  Witness witness(std::vector{fields(3, 0)}, nav::kMethods);
  for (const nav::Method method : nav::kMethods) {
    const Predictors p = witness.at(0, 0, kView, method);
    EXPECT_EQ(p.views > 0, method == nav::Method::kOrientation) << nav::name_of(method);
    EXPECT_GT(p.crest, p.structure) << nav::name_of(method) << ": the long ones weigh more";
  }
  EXPECT_EQ(Witness(std::vector{fields(3, 0), fields(3, 1)}).at(0, 0, kView).views, 0) << "there are dates";
}

TEST(Witness, MoreViewsAreDrawnWhereTheyDisagree) {
  EXPECT_EQ(judge({ground(cv::Mat(kSidePx, kSidePx, CV_8UC3, cv::Scalar(80, 120, 90)))}).views, kLeastViews)
      << "nothing to be seen on any day";
  EXPECT_EQ(judge({fields(3, 0)}).views, kLeastViews) << "found on every day";
  EXPECT_GT(judge({bars(1)}).views, kLeastViews) << "some days hold it in north by chance";
}

TEST(Witness, WhereOneOfSeveralDatesIsAloneItIsJudgedAsIfItWereTheOnly) {
  std::vector<GridImage> dates = {fields(3, 0), fields(8, 0)};
  dates[1].valid = cv::Mat(kSidePx, kSidePx, CV_8U, cv::Scalar(0));
  dates[1].valid.colRange(0, 20).setTo(255);  // far from the view
  const Predictors p = judge(dates), only = judge({fields(3, 0)});
  EXPECT_EQ(p.dates, 1);
  EXPECT_EQ(p.newest, 0);
  EXPECT_EQ(p.mean_logit, only.mean_logit);
  EXPECT_EQ(p.background, only.background);
  EXPECT_EQ(p.covariance_m2, only.covariance_m2);
}

TEST(Witness, TheBoundIsWideAlongBars) {
  const Predictors p = judge({bars(1), bars(2)});
  EXPECT_GT(p.least_covariance_m2[3], 4 * p.least_covariance_m2[0]);
  EXPECT_GT(p.least_covariance_m2[0], 0);
}

TEST(Witness, BeyondTheImagesNothingIsKnown) {
  EXPECT_EQ(judge({fields(3, 0)}, 5000, 0).dates, 0);
  EXPECT_EQ(judge({fields(3, 0)}, kSidePx + 20, 0).dates, 0) << "less than half of the view is left";
}

TEST(Witness, RefusesWhatCannotBeJudged) {
  EXPECT_THROW(Witness({}), std::invalid_argument);
  EXPECT_THROW(judge({fields(3, 0), ground(nav::testing::countryside(kSidePx - 2, 3))}), std::invalid_argument);
  const GridImage heights{cv::Mat(kSidePx, kSidePx - 1, CV_32F, cv::Scalar(0)), {}, -kSidePx, kSidePx, 2};
  EXPECT_THROW(Witness(std::vector{fields(3, 0)}, kOrientationOnly, heights), std::invalid_argument);
  Witness witness(std::vector{fields(3, 0)});
  EXPECT_THROW(witness.at(0, 0, {.template_m = 0}), std::invalid_argument);
  EXPECT_THROW(witness.at(0, 0, {.search_m = std::nan("")}), std::invalid_argument);
  EXPECT_THROW(witness.at(0, 0, kView, nav::Method::kGray), std::invalid_argument) << "made for orientation alone";
}

}  // namespace
}  // namespace landfix::navigability
