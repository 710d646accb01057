// What pictures over a map share: levels, dimming, lines with fractional ends, text with a rim, lengths of bars.
#include "tools/common/drawing.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "builder/error.h"

namespace landfix::tools {
namespace {

TEST(Drawing, TakesTheCoarsestLevelThatIsNoCoarserThanThePicture) {
  EXPECT_EQ(level_to_draw({0.5, 8}, 0.3), 0.5) << "there is none as fine";
  EXPECT_EQ(level_to_draw({0.5, 8}, 1.99), 1);
  EXPECT_EQ(level_to_draw({0.5, 8}, 2), 2);
  EXPECT_EQ(level_to_draw({0.5, 8}, 100), 8) << "there is none as coarse";
  EXPECT_EQ(level_to_draw({0, 0}, 1), 0) << "the map has no such layer";
}

TEST(Drawing, BarsHaveRoundLengths) {
  const double expected[][2] = {{1, 1}, {1.99, 1}, {2, 2}, {4.9, 2}, {5, 5}, {99, 50}, {100, 100}, {0.3, 0.2}};
  for (const auto& [most, length] : expected) EXPECT_NEAR(round_length(most), length, 1e-12) << most;
}

TEST(Drawing, DimsToSixtyPerCent) {
  const cv::Mat out = dimmed((cv::Mat_<uint8_t>(1, 2) << 0, 255));
  EXPECT_EQ(out.at<cv::Vec3b>(0, 0), cv::Vec3b(10, 10, 10));
  EXPECT_EQ(out.at<cv::Vec3b>(0, 1), cv::Vec3b(163, 163, 163));  // 0.6 · 255 + 10
}

TEST(Drawing, LinesEndBetweenPixels) {
  // A horizontal line half-way between rows 10 and 11 gives both the same light.
  cv::Mat picture = cv::Mat::zeros(21, 21, CV_8UC3);
  draw_line(picture, {2, 10.5}, {18, 10.5}, {200, 200, 200});
  EXPECT_GT(picture.at<cv::Vec3b>(10, 10)[0], 50);
  EXPECT_NEAR(picture.at<cv::Vec3b>(10, 10)[0], picture.at<cv::Vec3b>(11, 10)[0], 10);
}

TEST(Drawing, TextHasARim) {
  cv::Mat picture(40, 40, CV_8UC3, cv::Scalar(128, 128, 128));
  draw_text(picture, "I", {10, 30}, {.colour = {255, 255, 255}, .rim = {0, 0, 0}, .scale = 0.55, .rim_width = 4});
  double low, high;
  cv::minMaxLoc(picture.reshape(1), &low, &high);
  EXPECT_LT(low, 30);
  EXPECT_GT(high, 200);  // thin strokes, anti-aliased
}

TEST(Drawing, PicturesAreWrittenWholeOrNotAtAll) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(::testing::TempDir()) / "landfix_drawing";
  fs::create_directories(folder);
  const cv::Mat picture(3, 4, CV_8UC3, cv::Scalar(1, 2, 3));
  write_picture((folder / "p.png").string(), picture);
  EXPECT_EQ(cv::norm(cv::imread((folder / "p.png").string()), picture), 0);
  try {
    write_picture((folder / "nowhere" / "p.png").string(), picture);
    FAIL() << "there is no such folder";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kIo);
  }
  fs::remove_all(folder);
}

}  // namespace
}  // namespace landfix::tools
