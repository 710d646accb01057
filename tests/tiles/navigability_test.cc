#include "tiles/navigability.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace landfix::tiles {
namespace {

Navigability place() {
  Navigability n;
  n.fix_probability = {0.93, 0.9, 0.4, 0.02, std::nan("")};
  n.false_probability = 0.0007;
  n.major_m = 7.5, n.minor_m = 1.2, n.direction_rad = 2.9;
  n.rival_m = 141, n.rival_bearing_rad = 5.5, n.rival_strength = 0.83;
  n.landmarks = 12, n.diversity = 0.61;
  n.reasons = 1u << unsigned(Reason::kRepeats) | 1u << unsigned(Reason::kOneDate);
  n.dates = 4;
  return n;
}

double logit(double p) { return std::log(p / (1 - p)); }

TEST(Navigability, APixelKeepsAPlace) {
  const Navigability n = place();
  const auto back = decode_navigability(encode_navigability(n));
  ASSERT_TRUE(back);
  for (size_t i = 0; i < 4; ++i)  // half of a step of 0.0725 in log odds
    EXPECT_NEAR(logit(back->fix_probability[i]), logit(n.fix_probability[i]), 0.0363) << i;
  EXPECT_TRUE(std::isnan(back->fix_probability[4]));
  EXPECT_NEAR(logit(back->false_probability), logit(n.false_probability), 0.0363);
  EXPECT_NEAR(back->major_m / n.major_m, 1, 0.022);  // half of 4.4 %
  EXPECT_NEAR(back->minor_m / n.minor_m, 1, 0.022);
  EXPECT_NEAR(back->direction_rad, n.direction_rad, std::numbers::pi / 254 / 2);
  EXPECT_NEAR(back->rival_m / n.rival_m, 1, 0.022);
  EXPECT_NEAR(back->rival_bearing_rad, n.rival_bearing_rad, std::numbers::pi / 254);
  EXPECT_NEAR(back->rival_strength, n.rival_strength, 0.002);
  EXPECT_EQ(back->landmarks, 12u);
  EXPECT_NEAR(back->diversity, n.diversity, 0.002);
  EXPECT_TRUE(back->has(Reason::kRepeats));
  EXPECT_TRUE(back->has(Reason::kOneDate));
  EXPECT_FALSE(back->has(Reason::kWater));
  EXPECT_EQ(back->dates, 4u);
}

TEST(Navigability, WhatIsBeyondTheScaleStaysAtItsEnd) {
  Navigability n = place();
  n.fix_probability = {0, 1, 1e-9, 1 - 1e-9, 0.5};
  n.major_m = 1e9, n.minor_m = 1e-9, n.direction_rad = -0.001, n.rival_strength = 7, n.landmarks = 100000;
  const auto back = decode_navigability(encode_navigability(n));
  ASSERT_TRUE(back);
  for (const size_t low : {0u, 2u}) EXPECT_NEAR(back->fix_probability[low], 1e-4, 1e-6);
  for (const size_t high : {1u, 3u}) EXPECT_NEAR(back->fix_probability[high], 0.9999, 1e-6);
  EXPECT_EQ(back->fix_probability[4], 0.5);
  EXPECT_NEAR(back->major_m, 6000, 100);
  EXPECT_EQ(back->minor_m, 0.1);
  EXPECT_EQ(back->direction_rad, 0);  // -0.001 is as near to it as to pi
  EXPECT_EQ(back->rival_strength, 1);
  EXPECT_EQ(back->landmarks, 254u);
}

TEST(Navigability, EveryPixelThatIsReadIsWrittenAgain) {
  // Codes are those of the format: a reader and a writer of the same version agree in both directions.
  for (int code = 1; code < 256; ++code) {
    NavigabilityPixel pixel = encode_navigability(place());
    for (const size_t channel : {0u, 4u, 5u, 6u, 7u, 9u, 11u, 12u, 13u, 14u, 15u, 16u}) pixel[channel] = uint8_t(code);
    if (code < 255) pixel[8] = pixel[10] = uint8_t(code);
    const auto read = decode_navigability(pixel);
    ASSERT_TRUE(read);
    EXPECT_EQ(encode_navigability(*read), pixel) << code;
  }
}

TEST(Navigability, AnyBytesAreReadOrWithoutData) {
  EXPECT_FALSE(decode_navigability(NavigabilityPixel{}));
  EXPECT_FALSE(decode_navigability(std::vector<uint8_t>(kNavigabilityChannels - 1, 9)));
  const auto all = decode_navigability(std::vector<uint8_t>(kNavigabilityChannels + 3, 255));
  ASSERT_TRUE(all);
  EXPECT_LT(all->direction_rad, std::numbers::pi);
  EXPECT_LT(all->rival_bearing_rad, 2 * std::numbers::pi);
}

TEST(Navigability, LayersAreNamedByTheirFootprint) {
  EXPECT_EQ(layer_of({160, 320}), "navigability/160/320");
  EXPECT_EQ(layer_of({62.5, 100}), "navigability/62.5/100");
  EXPECT_EQ(footprint_of("navigability/62.5/100"), (Footprint{62.5, 100}));
  for (const char* other :
       {"gray", "navigability", "navigability/160", "navigability/160/", "navigability/-1/160", "navigability/0/160",
        "navigability/160/nan", "navigability/160/inf", "navigability/160/320 ", "navigability/ 160/320"})
    EXPECT_FALSE(footprint_of(other)) << other;
}

}  // namespace
}  // namespace landfix::tiles
