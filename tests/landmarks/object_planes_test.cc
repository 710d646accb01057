// The numbers of pixels: local, and blind to turning, mirroring and brightness.
#include "runtime/features/object_planes.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/imgproc.hpp>

namespace landfix::features {
namespace {

uint32_t noise_at(int x, int y) {
  uint32_t h = uint32_t(x) * 73856093u ^ uint32_t(y) * 19349663u;
  h = (h ^ (h >> 13)) * 2654435761u;
  return h ^ (h >> 16);
}

cv::Mat textured(const cv::Size& size, int type) {
  cv::Mat image(size, type);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width * image.channels(); ++x) image.ptr(y)[x] = uint8_t(60 + (noise_at(x, y) >> 26));
  cv::GaussianBlur(image, image, {5, 5}, 1.2);
  cv::rectangle(image, {size.width / 3, size.height / 3, 22, 14}, cv::Scalar(200, 150, 120), cv::FILLED);
  return image;
}

std::vector<cv::Mat> planes_of(const cv::Mat& image, const cv::Mat& valid = {}) {
  std::vector<cv::Mat> planes;
  FourfoldGradient gradient;
  object_planes(image, valid, planes, gradient);
  return planes;
}

int greatest_difference(const cv::Mat& a, const cv::Mat& b) { return int(cv::norm(a, b, cv::NORM_INF)); }

TEST(ObjectPlanes, AsManyAsSaid) {
  EXPECT_EQ(planes_of(textured({80, 70}, CV_8UC1)).size(), size_t(kObjectPlanesGray));
  EXPECT_EQ(planes_of(textured({80, 70}, CV_8UC3)).size(), size_t(kObjectPlanesColour));
}

TEST(ObjectPlanes, DependOnWhatIsWithinReachAlone) {
  const cv::Mat image = textured({260, 240}, CV_8UC3);
  cv::Mat valid(image.size(), CV_8U, cv::Scalar(255));
  valid(cv::Rect(100, 60, 20, 30)).setTo(0);
  const cv::Rect part(40, 30, 180, 170),
      inner(kObjectReach_px, kObjectReach_px, 180 - 2 * kObjectReach_px, 170 - 2 * kObjectReach_px);
  const std::vector<cv::Mat> whole = planes_of(image, valid), cut = planes_of(image(part).clone(), valid(part).clone());
  for (size_t k = 0; k < whole.size(); ++k)
    EXPECT_EQ(greatest_difference(whole[k](part)(inner), cut[k](inner)), 0) << "plane " << k;
}

TEST(ObjectPlanes, TurnAndMirrorWithTheImage) {
  // Tones are rounded; half a step of 255 may fall either way. A quarter turn exchanges sums of equal parts only.
  const cv::Mat image = textured({200, 160}, CV_8UC3);
  const std::vector<cv::Mat> planes = planes_of(image);
  cv::Mat turned, mirrored, expected;
  cv::rotate(image, turned, cv::ROTATE_90_CLOCKWISE);
  cv::flip(image, mirrored, 1);
  const std::vector<cv::Mat> of_turned = planes_of(turned), of_mirrored = planes_of(mirrored);
  for (size_t k = 0; k < planes.size(); ++k) {
    cv::rotate(planes[k], expected, cv::ROTATE_90_CLOCKWISE);
    EXPECT_LE(greatest_difference(expected, of_turned[k]), 1) << "plane " << k;
    cv::flip(planes[k], expected, 1);
    EXPECT_LE(greatest_difference(expected, of_mirrored[k]), 1) << "plane " << k;
  }
}

TEST(ObjectPlanes, HardlyChangeWithTheBrightness) {
  const cv::Mat image = textured({160, 150}, CV_8UC3);
  cv::Mat darker;
  image.convertTo(darker, -1, 0.75);
  const std::vector<cv::Mat> a = planes_of(image), b = planes_of(darker);
  for (const int k : {int(kPlaneTone), int(kPlaneTone3), int(kPlaneRedGreen), int(kPlaneBlueYellow)}) {
    // A quarter less light is 37 steps of tone, or 24 of a plane; surroundings take all of it away but what the noise
    // floor of 16 bends.
    EXPECT_LT(cv::mean(cv::abs(cv::Mat(a[size_t(k)]) - cv::Mat(b[size_t(k)])))[0], 3) << "plane " << k;
  }
  EXPECT_LT(std::abs(cv::mean(a[kPlaneTone])[0] - cv::mean(b[kPlaneTone])[0]), 1);
}

TEST(ObjectPlanes, OfEvenGroundAreEven) {
  for (const int type : {CV_8UC1, CV_8UC3}) {
    for (const cv::Mat& plane : planes_of(cv::Mat(90, 90, type, cv::Scalar(120, 90, 60)))) {
      double low = 0, high = 0;
      cv::minMaxLoc(plane, &low, &high);
      EXPECT_EQ(low, high);
    }
  }
}

}  // namespace
}  // namespace landfix::features
