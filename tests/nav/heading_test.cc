// Heading from lines on drawn country: seen by a camera, rectified with a wrong heading, compared with the map.
#include "runtime/nav/heading.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "runtime/nav/rectify.h"
#include "tests/nav/scene.h"

namespace landfix::nav {
namespace {

using features::GridImage;
using testing::Random;

constexpr double kDegree = 0.017453292519943295;
constexpr int kSide = 700;  ///< metres and pixels of a drawn country

cv::Point at(const cv::Point2d& p) { return {int(std::lround(16 * p.x)), int(std::lround(16 * p.y))}; }

/// Fields in rows between roads, all turned by one angle, with hedges across at random: `layout` decides where things
/// are, `shades` how bright (another season: as likely darker than their neighbours as brighter).
GridImage country(uint64_t layout, uint64_t shades) {
  Random where(layout), how(shades);
  const double angle = where.uniform(0, CV_PI);
  const cv::Point2d along(std::cos(angle), std::sin(angle)), across(-along.y, along.x), middle(kSide / 2., kSide / 2.);
  cv::Mat image(kSide, kSide, CV_8UC1, cv::Scalar(how.uniform(60, 160)));
  for (double v = -550; v < 550;) {
    const double next_v = v + where.uniform(35, 90), skew = where.uniform(-0.15, 0.15);
    for (double u = -550; u < 550;) {
      const double next_u = u + where.uniform(30, 150);
      const auto corner = [&](double a, double b) { return at(middle + (a + skew * (b - v)) * along + b * across); };
      const std::vector<cv::Point> field{corner(u, v), corner(next_u, v), corner(next_u, next_v), corner(u, next_v)};
      cv::fillConvexPoly(image, field, cv::Scalar(how.uniform(40, 200)), cv::LINE_AA, 4);
      u = next_u;
    }
    v = next_v;
  }
  for (int i = 0; i < 6; ++i) {  // roads, two of three along the rows
    const cv::Point2d direction = i % 3 == 2 ? cv::Point2d(std::cos(angle + 1.1), std::sin(angle + 1.1)) : along;
    const cv::Point2d through = middle + where.uniform(-250, 250) * cv::Point2d(-direction.y, direction.x);
    cv::line(image, at(through - 900 * direction), at(through + 900 * direction), cv::Scalar(how.uniform(20, 230)), 6,
             cv::LINE_AA, 4);
  }
  return {image, {}, -kSide / 2., kSide / 2., 1};
}

/// What a camera 95 m up sees of a scene around a place, rectified with a heading that is too small by `offset_rad`.
GridImage look(const GridImage& scene, double east_m, double north_m, double heading_rad, double offset_rad,
               Random& random) {
  const Camera camera = camera_from_field_of_view(210, 210, 90 * kDegree);
  const cv::Mat picture = testing::take_picture(scene, camera, {east_m, north_m, 95, {0, 0, heading_rad}});
  cv::Mat noise(picture.size(), CV_32F), image;
  cv::RNG(uint64_t(random.uniform(1, 1e9))).fill(noise, cv::RNG::NORMAL, 0, 8);
  cv::add(picture, noise, image, cv::noArray(), CV_8U);
  GridImage patch;
  EXPECT_EQ(rectify(image, camera, {0, 0, heading_rad - offset_rad}, 95, 1, patch), Status::kOk);
  return patch;
}

/// The part of a map around a place, as large as the patch's footprint.
GridImage around(const GridImage& map, double east_m, double north_m) {
  const int column = int(std::lround(map.column_of(east_m))), row = int(std::lround(map.row_of(north_m)));
  return {map.pixels(cv::Rect(column - 105, row - 105, 210, 210)), {}, east_m - 105, north_m + 105, 1};
}

TEST(Heading, IsFoundOnFieldsAndRoadsWhateverTheirShade) {
  Random random(5);
  int found = 0, honest = 0, cases = 200;
  std::vector<double> errors_deg;
  for (int i = 0; i < cases; ++i) {
    const uint64_t layout = 1000 + uint64_t(i / 8);
    const GridImage map = country(layout, 1), season = country(layout, 2);
    const double east = random.uniform(-100, 100), north = random.uniform(-100, 100);
    const double offset = random.uniform(-45, 45) * kDegree;
    const GridImage patch = look(season, east, north, random.uniform(-3.1, 3.1), offset, random);
    HeadingOffset h;
    // The map is asked up to 15 m beside the true place.
    const Status status =
        align_heading(patch, around(map, east + random.uniform(-15, 15), north + random.uniform(-15, 15)), h);
    if (status != Status::kOk) continue;
    ++found;
    errors_deg.push_back(std::abs(h.offset_rad - offset) / kDegree);
    honest += std::abs(h.offset_rad - offset) < 3 * h.sigma_rad;
  }
  std::sort(errors_deg.begin(), errors_deg.end());
  std::printf("found %d of %d, error median %.3f, 95 %% %.3f, worst %.3f degrees, within 3 sigma %.3f\n", found, cases,
              errors_deg[errors_deg.size() / 2], errors_deg[errors_deg.size() * 95 / 100], errors_deg.back(),
              double(honest) / found);
  EXPECT_GE(found, 0.9 * cases);
  EXPECT_LT(errors_deg[errors_deg.size() * 95 / 100], 0.5);
  EXPECT_GE(honest, 0.95 * found);
}

TEST(Heading, SigmaIsNoExcuse) {
  // On an ordinary view the stated sigma is well below half a degree.
  Random random(9);
  const GridImage map = country(77, 1), season = country(77, 3);
  HeadingOffset h;
  ASSERT_EQ(align_heading(look(season, 0, 0, 1, 0.3, random), around(map, 0, 0), h), Status::kOk);
  EXPECT_NEAR(h.offset_rad, 0.3, 0.5 * kDegree);
  EXPECT_LT(h.sigma_rad, 0.5 * kDegree);
  EXPECT_GT(h.sigma_rad, 0);
  EXPECT_GT(h.gap, 0.2);
}

TEST(Heading, IsNotReadFromAForest) {
  // The same texture in all directions, and not the one of the map: nothing to align.
  Random random(3);
  int answered = 0;
  for (uint64_t i = 0; i < 20; ++i) {
    const GridImage forest{testing::random_texture(kSide, kSide, 100 + i), {}, -kSide / 2., kSide / 2., 1};
    const GridImage later{testing::random_texture(kSide, kSide, 200 + i), {}, -kSide / 2., kSide / 2., 1};
    HeadingOffset h;
    const Status status =
        align_heading(look(later, 0, 0, 1, random.uniform(-0.7, 0.7), random), around(forest, 0, 0), h);
    ASSERT_TRUE(status == Status::kOk || status == Status::kNoTexture);
    answered += status == Status::kOk;
  }
  EXPECT_LE(answered, 1);
}

TEST(Heading, AnswersNoTextureForBlankImages) {
  const GridImage map = around(country(1, 1), 0, 0);
  const GridImage blank{cv::Mat(210, 210, CV_8UC1, cv::Scalar(255)), {}, 0, 0, 1};
  HeadingOffset h;
  EXPECT_EQ(align_heading(blank, map, h), Status::kNoTexture);
  EXPECT_EQ(align_heading(map, blank, h), Status::kNoTexture);
  GridImage masked = map;
  masked.valid = cv::Mat::zeros(map.pixels.size(), CV_8UC1);
  EXPECT_EQ(align_heading(map, masked, h), Status::kNoTexture);
  EXPECT_EQ(h.quality, 0);
  EXPECT_EQ(align_heading(map, map, h), Status::kOk);
  EXPECT_NEAR(h.offset_rad, 0, 0.02 * kDegree);
}

TEST(Heading, RefusesWhatItCannotUse) {
  const GridImage map = around(country(1, 1), 0, 0);
  HeadingOffset h;
  EXPECT_EQ(align_heading({}, map, h), Status::kBadImage);
  EXPECT_EQ(align_heading(map, {cv::Mat(9, 9, CV_8UC3), {}, 0, 0, 1}, h), Status::kBadImage);
  EXPECT_EQ(align_heading(map, {map.pixels, cv::Mat(9, 9, CV_8UC1), 0, 0, 1}, h), Status::kBadImage);
  GridImage coarse = map;
  coarse.gsd_m = 2;
  EXPECT_EQ(align_heading(map, coarse, h), Status::kBadValue);
  HeadingOptions options;
  options.max_offset_rad = 2;
  EXPECT_EQ(align_heading(map, map, h, options), Status::kBadValue);
  options.max_offset_rad = std::nan("");
  EXPECT_EQ(align_heading(map, map, h, options), Status::kBadValue);
  const GridImage tiny{cv::Mat(3, 3, CV_8UC1, cv::Scalar(3)), {}, 0, 0, 1};
  EXPECT_EQ(align_heading(tiny, tiny, h), Status::kNoTexture);
}

}  // namespace
}  // namespace landfix::nav
