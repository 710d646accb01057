// Shade is lifted to what is around it, and no longer drags a correlation along.
#include "runtime/features/shade.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace landfix::features {
namespace {

GridImage image_of(const cv::Mat& pixels, double gsd_m = 1) {
  GridImage image;
  image.pixels = pixels.clone();
  image.gsd_m = gsd_m;
  return image;
}

TEST(Shade, IsLiftedToTheLevelAroundIt) {
  // A shadow of 4 x 4 m on ground of 100: the mean of the 31 x 31 around its middle is 100 - 80 * 16 / 961 = 98.7, and
  // 0.9 of that 88.8.
  GridImage image = image_of(cv::Mat(61, 61, CV_8UC1, cv::Scalar(100)));
  image.pixels(cv::Rect(28, 28, 4, 4)).setTo(20);
  lift_shade(image);
  EXPECT_NEAR(image.pixels.at<uint8_t>(30, 30), 89, 1);
  EXPECT_EQ(image.pixels.at<uint8_t>(10, 10), 100);  // what is light stays
  EXPECT_EQ(image.pixels.at<uint8_t>(0, 0), 100);    // also at the rim, where the window is cut
}

TEST(Shade, CountsOnlyValidPixels) {
  // Left half without data (0): it must not darken the mean that the right half is lifted to.
  GridImage image = image_of(cv::Mat(61, 61, CV_8UC1, cv::Scalar(100)));
  image.valid = cv::Mat(61, 61, CV_8UC1, cv::Scalar(255));
  image.pixels(cv::Rect(0, 0, 30, 61)).setTo(0);
  image.valid(cv::Rect(0, 0, 30, 61)).setTo(0);
  image.pixels.at<uint8_t>(30, 32) = 20;
  const cv::Mat valid = image.valid.clone();
  lift_shade(image);
  EXPECT_NEAR(image.pixels.at<uint8_t>(30, 32), 90, 1);
  EXPECT_EQ(cv::countNonZero(image.valid != valid), 0);
}

TEST(Shade, IsNotLookedForWherePixelsAreLargerThanIt) {
  GridImage image = image_of(cv::Mat(31, 31, CV_8UC1, cv::Scalar(100)), 4);
  image.pixels.at<uint8_t>(15, 15) = 20;
  lift_shade(image);
  EXPECT_EQ(image.pixels.at<uint8_t>(15, 15), 20);
}

TEST(Shade, RefusesColour) {
  GridImage image = image_of(cv::Mat(3, 3, CV_8UC3, cv::Scalar::all(1)));
  EXPECT_THROW(lift_shade(image), cv::Exception);
}

/// A grove: crowns of 5 px that are a little lighter than the ground, each with a shadow beside it.
cv::Mat grove(cv::Point shadow) {
  cv::Mat picture(240, 240, CV_8UC1, cv::Scalar(110));
  cv::RNG random(5);
  std::vector<cv::Point> trees;
  for (int i = 0; i < 160; ++i) trees.emplace_back(random.uniform(0, 240), random.uniform(0, 240));
  for (const cv::Point& tree : trees) cv::circle(picture, tree + shadow, 5, 40, cv::FILLED);
  for (const cv::Point& tree : trees) cv::circle(picture, tree, 5, 135, cv::FILLED);
  return picture;
}

/// Where a picture of the middle is found in the other: distance from the truth in pixels.
double displacement(const GridImage& map, const GridImage& camera) {
  cv::Mat surface;
  cv::matchTemplate(map.pixels, camera.pixels(cv::Rect(60, 60, 120, 120)), surface, cv::TM_CCOEFF_NORMED);
  cv::Point peak;
  cv::minMaxLoc(surface, nullptr, nullptr, nullptr, &peak);
  return std::hypot(peak.x - 60, peak.y - 60);
}

TEST(Shade, LetsTheMatchStayWhereTheTreesAre) {
  // Shadows 7 px to the west in the morning, 7 px to the east in the evening: they lie 14 px apart and outvote the
  // crowns.
  GridImage morning = image_of(grove({-7, 2})), evening = image_of(grove({7, 2}));
  EXPECT_GT(displacement(morning, evening), 4);
  lift_shade(morning);
  lift_shade(evening);
  EXPECT_LT(displacement(morning, evening), 1.5);
}

}  // namespace
}  // namespace landfix::features
