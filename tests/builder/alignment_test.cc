// Shifts between drawn images that are known, and images whose shift cannot be known.
#include "builder/ingest/alignment.h"

#include <cmath>

#include "tests/builder/ingest_fixture.h"

namespace landfix::ingest {
namespace {

// Ground without end, in metres: soft-edged fields and houses at random places of a grid of 12 m, drawn exactly, so
// that shifted pixels are those of a shifted camera.
double ground(double east, double south, uint64_t seed) {
  double value = 90;
  const auto cell_x = int64_t(std::floor(east / 12)), cell_y = int64_t(std::floor(south / 12));
  for (int64_t cy = cell_y - 1; cy <= cell_y + 1; ++cy)
    for (int64_t cx = cell_x - 1; cx <= cell_x + 1; ++cx) {
      uint64_t h =
          (uint64_t(cx) * 0x9E3779B97F4A7C15) ^ (uint64_t(cy) * 0xC2B2AE3D27D4EB4F) ^ (seed * 0x165667B19E3779F9);
      h = (h ^ (h >> 29)) * 0xBF58476D1CE4E5B9;
      h ^= h >> 32;
      const double x = double(cx) * 12 + double(h % 97) / 8, y = double(cy) * 12 + double((h >> 8) % 97) / 8;
      const double half_width = 2 + double((h >> 16) % 32) / 8, half_height = 2 + double((h >> 24) % 32) / 8;
      const double inside = std::min(half_width - std::abs(east - x), half_height - std::abs(south - y));
      value += (double((h >> 40) % 121) - 60) / (1 + std::exp(-inside / 0.6));
    }
  return std::clamp(value, 1.0, 255.0);
}

// 400 m of ground at 1 m; `east` and `south`: how far the file says it lies beyond where it does.
Sketch photo(double east, double south, uint64_t seed = 1, double gain = 1) {
  Sketch s;
  s.crs = "EPSG:32636";
  const double geotransform[6] = {600'000, 1, 0, 3'500'000, 0, -1};
  std::copy(geotransform, geotransform + 6, s.geotransform);
  s.width = s.height = 400;
  s.bands = 1;
  s.value = [=](int, int x, int y) { return std::round(gain * ground(x + 0.5 - east, y + 0.5 - south, seed)); };
  return s;
}

class AlignmentTest : public Ingest {
 protected:
  // Measured at 1 m, each file with its date.
  std::vector<Alignment> measure(const std::vector<std::pair<std::string, Sketch>>& files) {
    std::vector<SourceOptions> options;
    for (const auto& [date, sketch] : files)
      options.push_back({write(std::to_string(options.size()) + ".tif", sketch), date, {}, {}});
    images_ = std::make_unique<ImageSet>(options);
    return measure_alignment(*images_, 0);
  }
  std::unique_ptr<ImageSet> images_;
};

TEST_F(AlignmentTest, FindsShiftsToAFractionOfAPixel) {
  // One is darker, one is a negative: the shift does not mind.
  Sketch negative = photo(-0.4, 0.7);
  negative.value = [value = negative.value](int b, int x, int y) { return 255 - value(b, x, y); };
  const auto found = measure({{"2018-07-16", photo(0, 0)},
                              {"2009-08-18", photo(3.3, -1.6, 1, 0.6)},
                              {"2014-07-20", negative},
                              {"", photo(-11.25, 7.5)}});
  EXPECT_FALSE(found[0].reference);
  EXPECT_FALSE(found[0].measured);
  const double expected[4][2] = {{0, 0}, {3.3, 1.6}, {-0.4, -0.7}, {-11.25, -7.5}};  // east, north
  for (size_t i = 1; i < 4; ++i) {
    ASSERT_TRUE(found[i].measured) << i;
    EXPECT_EQ(found[i].reference, 0u);
    EXPECT_NEAR(found[i].east_m, expected[i][0], 0.15) << i;
    EXPECT_NEAR(found[i].north_m, expected[i][1], 0.15) << i;
    EXPECT_GE(found[i].windows, 6) << i;  // of 9
    EXPECT_EQ(found[i].agreeing, found[i].windows) << i;
    EXPECT_LT(found[i].spread_m, 0.3) << i;
  }
  const std::vector<std::string> names = {"first", "second", "third", "fourth"};
  const std::string text = text_of(found[1], names);
  EXPECT_NE(text.find("m east, 1."), std::string::npos) << text;
  EXPECT_NE(text.find("by comparison with first ("), std::string::npos) << text;
  EXPECT_EQ(text_of(found[0], names), "");
}

TEST_F(AlignmentTest, MovingASourceRemovesItsShift) {
  const auto found = measure({{"2018-07-16", photo(0, 0)}, {"2009-08-18", photo(4.4, 2.8)}});
  const GridBounds before = images_->sources()[1].bounds;
  images_->move_source(1, -found[1].east_m, -found[1].north_m);
  EXPECT_NEAR(images_->sources()[1].bounds.west_m, before.west_m - 4.4, 0.15);
  const auto again = measure_alignment(*images_, 0);
  EXPECT_NEAR(again[1].east_m, 0, 0.1);
  EXPECT_NEAR(again[1].north_m, 0, 0.1);
  // Pixels follow: what was 4.4 m further east is where the reference shows it.
  const PixelWindow window{1, 600'100, -3'499'900, 200, 200};
  const cv::Mat reference = images_->read_source(0, window)->bands, moved = images_->read_source(1, window)->bands;
  EXPECT_LT(cv::norm(reference, moved, cv::NORM_L1) / 40'000, 3);  // gray levels, on average
}

TEST_F(AlignmentTest, TakesTheBestPlacedAsReference) {
  write_text("1.tif.json", R"({"georegistration_error_m": 0.5})");
  write_text("2.tif.json", R"({"georegistration_error_m": 2})");
  const auto found = measure({{"2018-07-16", photo(2, 0)}, {"2009-08-18", photo(0, 0)}, {"2010-08-18", photo(0, 3)}});
  EXPECT_FALSE(found[1].reference);
  EXPECT_EQ(found[0].reference, 1u);
  EXPECT_NEAR(found[0].east_m, 2, 0.15);
  EXPECT_NEAR(found[2].north_m, -3, 0.15);
}

TEST_F(AlignmentTest, WorksBetweenFilesOfOneDateAndAlongChains) {
  // Each overlaps only the one before it.
  Sketch second = photo(1.5, 0.5), third = photo(1.5 + 1, 0.5 - 2);
  const auto east_by = [](Sketch s, double metres) {
    s.geotransform[0] += metres;
    s.value = [value = s.value, metres](int b, int x, int y) { return value(b, x + int(metres), y); };
    return s;
  };
  second = east_by(second, 210);
  third = east_by(third, 420);
  const auto found = measure({{"2018-07-16", photo(0, 0)}, {"2018-07-16", second}, {"2018-07-16", third}});
  ASSERT_TRUE(found[1].measured && found[2].measured);
  EXPECT_EQ(found[2].reference, 1u);
  EXPECT_NEAR(found[1].east_m, 1.5, 0.15);
  EXPECT_NEAR(found[2].east_m, 2.5, 0.25);
  EXPECT_NEAR(found[2].north_m, 1.5, 0.25);
}

TEST_F(AlignmentTest, SaysNothingWhereWindowsDisagree) {
  Sketch torn = photo(0, 0);  // stripes that are shifted each its own way
  torn.value = [](int, int x, int y) {
    return std::round(ground(x + 0.5 + double(x / 50 % 3 * 7), y + 0.5 + double(y / 50 % 4 * 6), 1));
  };
  const auto found = measure({{"2018-07-16", photo(0, 0)}, {"2009-08-18", torn}});
  EXPECT_FALSE(found[1].measured);
  EXPECT_EQ(found[1].east_m, 0);
  EXPECT_EQ(found[1].north_m, 0);
  EXPECT_NE(text_of(found[1], {"first", "second"}).find("shift against first not measurable"), std::string::npos);
}

TEST_F(AlignmentTest, SaysNothingWhereNothingIsInCommon) {
  Sketch flat = photo(0, 0), far = photo(0, 0);
  flat.value = [](int, int, int) { return 120; };
  far.geotransform[0] += 5000;
  const auto found =
      measure({{"2018-07-16", photo(0, 0)}, {"2014-07-20", photo(0, 0, 2)}, {"2012-08-18", flat}, {"2009-08-18", far}});
  EXPECT_FALSE(found[1].measured);  // other ground altogether
  EXPECT_FALSE(found[2].measured);
  EXPECT_EQ(found[2].windows, 0);
  EXPECT_FALSE(found[3].reference);
}

}  // namespace
}  // namespace landfix::ingest
