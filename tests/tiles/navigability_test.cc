#include "tiles/navigability.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "tests/tiles/random.h"

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
  n.newest_day = 17728;  // 2018-07-16
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
  EXPECT_EQ(back->newest_day, 17728);
}

TEST(Navigability, ADateIsKeptFrom1970OnOrUnknown) {
  for (const auto& [day, kept] : std::vector<std::pair<std::optional<int>, std::optional<int>>>{
           {std::nullopt, std::nullopt}, {0, 0}, {-9000, 0}, {255, 255}, {256, 256}, {65534, 65534}, {70000, 65534}}) {
    Navigability n = place();
    n.newest_day = day;
    EXPECT_EQ(decode_navigability(encode_navigability(n))->newest_day, kept);
  }
}

TEST(Navigability, ChancesFallWithTheMapsAge) {
  const Navigability n = place();
  const Navigability typical = on_day(n, 17728 + 731);  // two years of 365.25 days, and half a day
  EXPECT_NEAR(typical.fix_probability[0], n.fix_probability[0], 1e-4) << "what the pack says holds for two years";
  EXPECT_FALSE(typical.has(Reason::kOld));
  const Navigability later = on_day(n, 17728 + 2922);  // eight years
  for (size_t i = 0; i < 4; ++i)                       // ln 9 - ln 3, times the slope of 0.6
    EXPECT_NEAR(logit(later.fix_probability[i]), logit(n.fix_probability[i]) - 0.6 * std::log(3), 1e-6) << i;
  EXPECT_TRUE(std::isnan(later.fix_probability[4])) << "what is not judged stays so";
  EXPECT_TRUE(later.has(Reason::kOld));
  EXPECT_TRUE(later.has(Reason::kRepeats));
  EXPECT_EQ(on_day(n, 10000).fix_probability[0], on_day(n, 17728).fix_probability[0]) << "a flight before the image";
  Navigability undated = n;
  undated.newest_day.reset();
  EXPECT_EQ(on_day(undated, 30000).fix_probability[0], n.fix_probability[0]);
  EXPECT_EQ(aged(0, 9), 0);
  EXPECT_EQ(aged(1, 9), 1);
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
    for (const size_t channel : {0u, 4u, 5u, 6u, 7u, 9u, 11u, 12u, 13u, 14u, 15u, 16u, 17u, 18u})
      pixel[channel] = uint8_t(code);
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
  tests::Random random(1);
  for (int i = 0; i < 20000; ++i) {
    std::vector<uint8_t> bytes(size_t(random.integer(0, 24)));
    for (uint8_t& b : bytes) b = random.byte();
    const auto read = decode_navigability(bytes);
    if (!read) continue;
    for (const double p : read->fix_probability) EXPECT_TRUE(std::isnan(p) || (p > 0 && p < 1));
    for (const double m : {read->major_m, read->minor_m, read->rival_m}) EXPECT_TRUE(m >= 0 && m < 6200);
    for (const double share : {read->rival_strength, read->diversity}) EXPECT_TRUE(share >= 0 && share <= 1);
    EXPECT_TRUE(read->direction_rad >= 0 && read->rival_bearing_rad >= 0 && read->newest_day.value_or(0) >= 0);
    const auto again = decode_navigability(encode_navigability(*read));  // never without data
    ASSERT_TRUE(again);
    EXPECT_EQ(again->reasons, read->reasons);
  }
}

TEST(Navigability, TheExampleOfTheSpecification) {
  // Codes and values as schemas/FORMAT.md, section 3.5.1, gives them.
  const NavigabilityPixel pixel = {160, 160, 128, 0, 0, 58, 86, 70, 128, 168, 1, 204, 4, 101, 8, 1, 2, 65, 69};
  const auto read = decode_navigability(pixel);
  ASSERT_TRUE(read);
  EXPECT_NEAR(read->fix_probability[1], 0.9106, 1e-4);
  EXPECT_EQ(read->fix_probability[2], 0.5);
  EXPECT_TRUE(std::isnan(read->fix_probability[3]));
  EXPECT_NEAR(read->false_probability, 0.0062, 1e-4);
  EXPECT_NEAR(read->major_m, 3.974, 1e-3);
  EXPECT_NEAR(read->minor_m, 1.987, 1e-3);
  EXPECT_NEAR(read->direction_rad, std::numbers::pi / 2, 1e-9);
  EXPECT_NEAR(read->rival_m, 138.7, 0.1);
  EXPECT_EQ(read->rival_bearing_rad, 0);
  EXPECT_NEAR(read->rival_strength, 0.799, 1e-3);
  EXPECT_EQ(read->landmarks, 3u);
  EXPECT_NEAR(read->diversity, 0.394, 1e-3);
  EXPECT_TRUE(read->has(Reason::kRepeats) && read->has(Reason::kOneDate));
  EXPECT_EQ(read->dates, 1u);
  EXPECT_EQ(read->newest_day, 17728);
  EXPECT_EQ(encode_navigability(*read), pixel);
}

TEST(Navigability, NodesLieAtMostHalfAViewApart) {
  EXPECT_EQ(navigability_level({160, 160}), 6);
  EXPECT_EQ(navigability_level({128, 160}), 6);
  EXPECT_EQ(navigability_level({127.9, 160}), 5);
  EXPECT_EQ(node_spacing_m({64, 160}), 32);
  EXPECT_EQ(node_spacing_m({5000, 160}), 64) << "no coarser for larger views";
  EXPECT_EQ(node_spacing_m({1, 160}), 1) << "no level is finer than 1 m per node";
}

TEST(Navigability, LayersAreNamedByTheirFootprint) {
  EXPECT_EQ(layer_of({160, 320}), "navigability/160/320");
  EXPECT_EQ(layer_of({62.5, 100}), "navigability/62.5/100");
  EXPECT_EQ(footprint_of("navigability/62.5/100"), (Footprint{62.5, 100}));
  for (const char* other :
       {"gray", "navigability", "navigability/160", "navigability/160/", "navigability/-1/160", "navigability/0/160",
        "navigability/160/nan", "navigability/160/inf", "navigability/160/0.0009", "navigability/1000001/160",
        "navigability/160/320 ", "navigability/ 160/320"})
    EXPECT_FALSE(footprint_of(other)) << other;
}

}  // namespace
}  // namespace landfix::tiles
