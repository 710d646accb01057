#include "builder/roads/road_scales.h"

#include <algorithm>

namespace landfix::landmarks {
namespace {

// Means of 2x2 pixels, rounded; a pixel is valid where all four are.
void halve(const cv::Mat& image, const cv::Mat& valid, cv::Mat& half, cv::Mat& half_valid) {
  const cv::Size size(image.cols / 2, image.rows / 2);
  half.create(size, image.type());
  const int channels = image.channels();
  for (int y = 0; y < size.height; ++y) {
    const uint8_t *a = image.ptr(2 * y), *b = image.ptr(2 * y + 1);
    for (int i = 0; i < size.width * channels; ++i) {
      const int k = (i / channels) * 2 * channels + i % channels;
      half.ptr(y)[i] = uint8_t((a[k] + a[k + channels] + b[k] + b[k + channels] + 2) / 4);
    }
  }
  if (valid.empty()) return;
  half_valid.create(size, CV_8UC1);
  for (int y = 0; y < size.height; ++y) {
    const uint8_t *a = valid.ptr(2 * y), *b = valid.ptr(2 * y + 1);
    for (int x = 0; x < size.width; ++x)
      half_valid.at<uint8_t>(y, x) = a[2 * x] && a[2 * x + 1] && b[2 * x] && b[2 * x + 1] ? 255 : 0;
  }
}

}  // namespace

RoadScales::RoadScales(const cv::Mat& image, const cv::Mat& valid) {
  cv::Mat half;
  halve(image, valid, half, valid_[1]);
  valid_[0] = valid;
  features::road_bands(image, bands_[0]);
  if (!half.empty()) features::road_bands(half, bands_[1]);
}

std::vector<features::RoadCandidate> RoadScales::candidates(int level) const {
  if (bands_[size_t(level)].empty()) return {};
  return features::road_candidates(bands_[size_t(level)], valid_[size_t(level)]);
}

float RoadScales::describe(const features::RoadCandidate& c, int level, features::RoadProfile& profile) const {
  return features::road_profile(bands_[size_t(level)], c.x, c.y, c.theta_rad, profile);
}

void RoadScales::describe(const features::RoadCandidate& c, int level, const features::RoadProfile& own,
                          RoadScaleProfile& profile) const {
  features::RoadProfile other{};
  if (level == 1)
    features::road_profile(bands_[0], 2 * c.x + 0.5, 2 * c.y + 0.5, c.theta_rad, other);
  else if (!bands_[1].empty())
    features::road_profile(bands_[1], 0.5 * c.x - 0.25, 0.5 * c.y - 0.25, c.theta_rad, other);
  const auto middle = std::copy_n((level == 0 ? own : other).begin(), own.size(), profile.begin());
  std::copy_n((level == 0 ? other : own).begin(), own.size(), middle);
  profile.back() = float(level);
}

}  // namespace landfix::landmarks
