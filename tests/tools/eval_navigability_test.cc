// What a map foretells against what happens: interpolation between nodes, textures, dates and figures, against cases
// worked out by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "tests/tools/navigability_world.h"
#include "tools/common/map_age.h"
#include "tools/common/open_pack.h"
#include "tools/eval/navigability.h"
#include "tools/eval/navigability_report.h"

namespace landfix::eval {
namespace {

using tests::kJudgedNorth;
using tests::kJudgedWest;
using tiles::Finder;

double logit(double p) { return std::log(p / (1 - p)); }

class JudgedPack : public testing::Test {
 protected:
  JudgedPack() {
    tests::write_file(folder_.file("map.lfpack"), tests::draw(tests::judged_drawing()));
    pack_.emplace(tools::open_pack(folder_.file("map.lfpack")));
    map_.emplace(*pack_, tiles::Footprint{160, 160}, "map.lfpack");
  }
  tests::TemporaryFolder folder_;
  std::optional<Pack> pack_;
  std::optional<tools::NavigabilityMap> map_;
};

TEST_F(JudgedPack, ChancesAreInterpolatedByTheirLogOdds) {
  // Nodes 0.3 and 0.6 stand 96 and 160 m from the western edge; three quarters of the way.
  const double at_nodes[2] = {map_->node(1, 0)->fix_probability[0], map_->node(2, 0)->fix_probability[0]};
  const auto expected = map_->between(kJudgedWest + 144, kJudgedNorth - 64, Finder::kAuto);
  ASSERT_TRUE(expected);
  EXPECT_NEAR(logit(expected->fix_probability), 0.25 * logit(at_nodes[0]) + 0.75 * logit(at_nodes[1]), 1e-9);
  // 8 m from west to east and 4 m from south to north, to 2.2 %.
  EXPECT_NEAR(std::sqrt(expected->covariance_m2[0]), 8, 0.18);
  EXPECT_NEAR(std::sqrt(expected->covariance_m2[3]), 4, 0.09);
  EXPECT_NEAR(expected->covariance_m2[1], 0, 0.6);
}

TEST_F(JudgedPack, WhatSaysNothingHasNoPart) {
  // Between the third row, which speaks, and the fourth, which does not.
  const auto expected = map_->between(kJudgedWest + 32, kJudgedNorth - 180, Finder::kAuto);
  ASSERT_TRUE(expected);
  EXPECT_NEAR(expected->fix_probability, map_->node(0, 2)->fix_probability[0], 1e-9);
  EXPECT_FALSE(map_->between(kJudgedWest + 32, kJudgedNorth - 240, Finder::kAuto)) << "beyond the last that speaks";
  EXPECT_FALSE(map_->between(kJudgedWest + 32, kJudgedNorth - 64, Finder::kGray)) << "not judged";
  EXPECT_FALSE(map_->between(kJudgedWest - 1e6, kJudgedNorth - 64, Finder::kAuto));
  EXPECT_FALSE(map_->between(NAN, kJudgedNorth - 64, Finder::kAuto));
  EXPECT_TRUE(map_->judges(Finder::kOrientation));
  EXPECT_FALSE(map_->judges(Finder::kEdge));
}

TEST_F(JudgedPack, AgeIsToTheNearestDateOnEitherSide) {
  const auto age = [&](const char* date) {
    return tools::map_age_years(*pack_, kJudgedWest + 10, kJudgedNorth - 10, *tools::days_of(date));
  };
  EXPECT_NEAR(*age("2018-07-16"), 2, 0.003);
  EXPECT_NEAR(*age("2014-07-16"), 2, 0.003);
  EXPECT_FALSE(tools::map_age_years(*pack_, kJudgedWest - 1000, kJudgedNorth - 10, 0)) << "off the map";
  EXPECT_EQ(tools::days_of("1970-01-02"), 1);
  EXPECT_FALSE(tools::days_of("1970-02-30"));
}

TEST(Navigability, NearestFootprintIsByFactors) {
  const std::vector<tiles::Footprint> judged = {{160, 160}, {160, 320}, {320, 320}};
  EXPECT_EQ(tools::nearest_footprint(judged, {200, 160}), (tiles::Footprint{160, 160}));
  EXPECT_EQ(tools::nearest_footprint(judged, {230, 300}), (tiles::Footprint{320, 320})) << "1.39 is less than 1.44";
  EXPECT_FALSE(tools::nearest_footprint({}, {160, 160}));
}

TEST(Navigability, CovarianceTurnsWithItsLongerAxis) {
  tiles::Navigability n;
  n.major_m = 5, n.minor_m = 3, n.direction_rad = M_PI / 4;  // towards north-east: 25 and 9 along the diagonals
  const std::array<double, 4> c = tools::covariance_of(n);
  EXPECT_NEAR(c[0], 17, 1e-9);
  EXPECT_NEAR(c[1], 8, 1e-9);
  EXPECT_NEAR(c[3], 17, 1e-9);
}

TEST(Navigability, DatesInNames) {
  EXPECT_EQ(date_in_name("m_4709963_se_14_1_20180716.tif"), "2018-07-16") << "the other numbers are no dates";
  EXPECT_EQ(date_in_name("2018-07-16.tif"), "2018-07-16");
  EXPECT_EQ(date_in_name("a2018_07_16b.tif"), "2018-07-16");
  EXPECT_EQ(date_in_name("20181316_20190203.tif"), "2019-02-03") << "there is no month 13";
  EXPECT_EQ(date_in_name("120180716.tif"), "");
  EXPECT_EQ(date_in_name("town.tif"), "");
}

TEST(Textures, OfARampAndOfNothing) {
  const auto flat = textures_of(cv::Mat(40, 40, CV_8UC1, cv::Scalar(90)));
  for (size_t t = 0; t < kTextures; ++t) EXPECT_EQ(flat[t], 0) << kTextureNames[t];
  // 10 gray levels per pixel from west to east over 16 columns: 16 bins or more, known in one direction alone.
  cv::Mat ramp(40, 16, CV_8UC1);
  for (int x = 0; x < 16; ++x) ramp.col(x).setTo(10 * x);
  const auto t = textures_of(ramp);
  EXPECT_NEAR(t[0], 4, 1e-9) << "every column has a bin of its own";
  EXPECT_NEAR(t[1], 10 * std::sqrt((16 * 16 - 1) / 12.0), 1e-3) << "of sixteen even steps";
  EXPECT_NEAR(t[2], 14.0 / 16, 1e-9) << "80 by Sobel's operator, half of it in the two columns at the edge";
  EXPECT_NEAR(t[3], 0, 1e-6) << "nothing tells where it lies from north to south";
  // A plane that rises as much to the south besides has one direction still; a wave across it has two.
  cv::Mat wave(40, 40, CV_8UC1);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 40; ++x) wave.at<uint8_t>(y, x) = uint8_t(100 + 40 * std::sin(x) + 40 * std::sin(y));
  EXPECT_GT(textures_of(wave)[3], 100);
}

/// A registration `error_m` east of the truth, at a place with these chances and 3 m of standard deviation per axis.
Foreseen foreseen(double chance, double error_m, uint64_t block, double sigma_m = 3) {
  Foreseen f;
  f.trial.status = nav::Status::kOk;
  f.trial.question.hit_m = 15;
  f.trial.question.block = block;
  f.trial.east_m = error_m;
  f.expected = {chance, {sigma_m * sigma_m, 0, 0, sigma_m * sigma_m}};
  f.textures = {{error_m, -error_m, 1, 0}};
  return f;
}

TEST(NavigabilityFigures, OfFourPlaces) {
  // Hits at 0.9 and 0.4, misses at 0.6 and 0.2: 3 of 4 pairs are in order. 7.34 m lie within 2.448 sigma, 8 m do not.
  std::vector<Foreseen> all = {foreseen(0.9, 7.3, 1), foreseen(0.4, 8, 2), foreseen(0.6, 20, 3), foreseen(0.2, 90, 4)};
  const NavigabilityFigures f = figures_of(all);
  EXPECT_EQ(f.samples, 4);
  EXPECT_EQ(f.hits, 2);
  EXPECT_EQ(f.blocks, 4u);
  EXPECT_DOUBLE_EQ(f.auc.value, 0.75);
  EXPECT_NEAR(f.calibration_error.value, (0.1 + 0.6 + 0.6 + 0.2) / 4, 1e-12);
  EXPECT_DOUBLE_EQ(f.in_ellipse.value, 0.5);
  EXPECT_NEAR(f.expected_rms_m, 3 * std::sqrt(2), 1e-9);
  EXPECT_NEAR(f.actual_rms_m, std::sqrt((7.3 * 7.3 + 8 * 8) / 2), 1e-9);
  EXPECT_TRUE(std::isnan(f.rank_correlation.value)) << "all were given the same spread";
  EXPECT_DOUBLE_EQ(f.textures[0].value, 0) << "grows with the error";
  EXPECT_DOUBLE_EQ(f.textures[1].value, 1);
  EXPECT_DOUBLE_EQ(f.textures[2].value, 0.5) << "all are equal";
  EXPECT_TRUE(std::isnan(f.mean_age_years));
  // A match that was not found is no true fix, however near its place would have been.
  all[0].trial.status = nav::Status::kNoTexture;
  EXPECT_EQ(figures_of(all).hits, 1);
}

TEST(NavigabilityFigures, SpreadThatFollowsTheErrorCorrelates) {
  std::vector<Foreseen> all;
  for (int i = 1; i <= 10; ++i) all.push_back(foreseen(0.9, i, uint64_t(i), 20 - i));
  const NavigabilityFigures f = figures_of(all);
  EXPECT_NEAR(f.rank_correlation.value, -1, 1e-12);
  EXPECT_NEAR(f.rank_correlation.interval.high, -1, 1e-12);
}

TEST(NavigabilityFigures, WhatIsNotDefinedIsNullAndSaid) {
  ForeseenMatcher matcher{"auto", {{"camera.tif", "map.lfpack", 3, {}}}};
  for (int i = 0; i < 5; ++i) matcher.cameras[0].samples.push_back(foreseen(0.8, 1, uint64_t(i)));
  const std::vector<ForeseenMatcher> matchers = {matcher};
  const std::vector<NavigabilityReport> reports = report(matchers);
  const auto json = nlohmann::json::parse(to_json(reports).dump());
  EXPECT_TRUE(json[0]["pooled"]["auc"]["value"].is_null());
  EXPECT_TRUE(json[0]["pooled"]["auc"]["interval_95"][0].is_null());
  EXPECT_NEAR(json[0]["pooled"]["expected_calibration_error"]["value"].get<double>(), 0.2, 1e-9);
  EXPECT_EQ(json[0]["cameras"][0]["not_judged"], 3);
  EXPECT_NE(to_text(reports).find("every one of the samples is a true fix"), std::string::npos) << to_text(reports);
}

}  // namespace
}  // namespace landfix::eval
