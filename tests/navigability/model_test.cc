// From evidence to probability and covariance: which way each piece of evidence turns them.
#include "builder/navigability/model.h"

#include <gtest/gtest.h>

#include <cmath>

namespace landfix::navigability {
namespace {

/// A place that three dates show, as most are on farmland.
Predictors usual() {
  Predictors p;
  p.dates = 3;
  p.template_px = 40;
  p.least_logit = 0;
  p.mean_logit = 1.5;
  p.structure = 0.35;
  p.crest = 0.7;
  p.background = 0.05;
  p.covariance_m2 = {30, 10, 10, 50};
  return p;
}

TEST(FixProbability, EvidenceForAPlaceRaisesIt) {
  const double usually = fix_probability(usual());
  const auto with = [](auto Predictors::*member, auto value) {
    Predictors p = usual();
    p.*member = value;
    return fix_probability(p);
  };
  EXPECT_GT(with(&Predictors::least_logit, 3.0), usually);
  EXPECT_GT(with(&Predictors::mean_logit, 3.0), usually);
  EXPECT_GT(with(&Predictors::structure, 0.5), usually);
  EXPECT_GT(with(&Predictors::template_px, 80.0), usually);
  EXPECT_LT(with(&Predictors::background, 0.3), usually);
}

TEST(FixProbability, OneDateIsJudgedByWhatItShowsAndByViewsOfOtherDays) {
  Predictors p = usual();
  p.dates = 1;
  const double usually = fix_probability(p);
  p.least_logit = -9;
  EXPECT_EQ(fix_probability(p), usually) << "the worst of more or fewer views says nothing";
  p.mean_logit = 4;
  const double found = fix_probability(p);
  EXPECT_GT(found, usually);
  p.structure = 0.6;
  EXPECT_GT(fix_probability(p), found);
  const double edges = fix_probability(p, nav::Method::kEdge);
  p.mean_logit = 9;
  EXPECT_EQ(fix_probability(p, nav::Method::kEdge), edges) << "a date matched with itself proves nothing";
  p.crest = 0.9;
  EXPECT_GT(fix_probability(p, nav::Method::kEdge), edges);
}

TEST(FixProbability, NothingIsKnownWithoutADateAndNothingIsCertain) {
  EXPECT_EQ(fix_probability({}), 0);
  Predictors p = usual();
  p.least_logit = p.mean_logit = kLargestLogit;
  p.structure = 1;
  p.template_px = 400;
  EXPECT_LE(fix_probability(p), 0.995);
  p.least_logit = p.mean_logit = -kLargestLogit;
  p.structure = 0;
  p.template_px = 4;
  EXPECT_GE(fix_probability(p), 0.005 - 1e-12);
}

TEST(FixProbability, IsThatOfTheMatcher) {
  using nav::Method;
  const Predictors p = usual();
  EXPECT_GT(fix_probability(p, Method::kOrientation), 0.5);
  for (const Method method : nav::kMethods) {
    Predictors better = p;
    better.least_logit = better.mean_logit = 5;
    EXPECT_GT(fix_probability(better, method), fix_probability(p, method)) << nav::name_of(method);
  }
  EXPECT_LT(fix_probability(p, Method::kContour), fix_probability(p, Method::kOrientation))
      << "of one place and evidence alike: contours are found least often";
}

TEST(FalseFixes, AreAShareOfTheMisses) {
  EXPECT_NEAR(false_fix_probability(0.99), 0.001, 1e-9);
  EXPECT_NEAR(false_fix_probability(0.5), 0.05, 1e-9) << "the gate's promise holds over all places, not here";
  EXPECT_NEAR(false_fix_probability(0), 0.1, 1e-9);
}

TEST(FixCovariance, ScalesWhatTheMatchesStatedAndHasAFloor) {
  const auto c = fix_covariance_m2(usual(), 4);
  EXPECT_DOUBLE_EQ(c[0], 0.5 * 30 + 0.16 * 16);
  EXPECT_DOUBLE_EQ(c[1], 0.5 * 10);
  EXPECT_EQ(c[1], c[2]);
  EXPECT_DOUBLE_EQ(c[3], 0.5 * 50 + 0.16 * 16);
}

TEST(FixCovariance, OfADateMatchedWithItselfIsFarTooSharp) {
  Predictors alone = usual();
  alone.dates = 1;
  const auto itself = fix_covariance_m2(alone, 4);
  alone.views = 3;
  EXPECT_GT(itself[0], 4 * fix_covariance_m2(alone, 4)[0]);
  EXPECT_DOUBLE_EQ(fix_covariance_m2(alone, 4)[0], 30 + 0.4 * 16) << "as the drawn views state it, and a floor";
}

TEST(FixCovariance, IsNowhereBelowTheBound) {
  Predictors p = usual();
  p.covariance_m2 = {10, 0, 0, 10};
  p.least_covariance_m2 = {1, 0, 0, 400};
  const auto c = fix_covariance_m2(p, 4);
  EXPECT_DOUBLE_EQ(c[0], 0.5 * 10 + 0.16 * 16);
  EXPECT_NEAR(c[3], 400, 1e-9) << "along a road nobody knows better";
}

}  // namespace
}  // namespace landfix::navigability
