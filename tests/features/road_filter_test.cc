// The oriented filter for roads against a plain reference, and what its candidates and profiles promise.
#include "runtime/features/road_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "runtime/features/road_profile.h"

namespace landfix::features {
namespace {

constexpr double kPi = std::numbers::pi;

// Noise that is the same everywhere, with a bright band 5 pixels wide through `through` in direction `theta`.
cv::Mat band_image(const cv::Size& size, cv::Point2d through, double theta, int type = CV_8UC1) {
  cv::Mat image(size, type);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double across = -(x - through.x) * std::sin(theta) + (y - through.y) * std::cos(theta);
      const double cover = std::clamp(3 - std::abs(across), 0.0, 1.0);
      const uint32_t noise = (uint32_t(x) * 73856093u ^ uint32_t(y) * 19349663u) * 2654435761u >> 29;
      for (int k = 0; k < image.channels(); ++k)
        image.ptr(y)[x * image.channels() + k] = uint8_t(90 + 20 * k + noise + cover * (60 - 15 * k));
    }
  }
  return image;
}

// The formula, term by term, in double precision.
double reference_at(const cv::Mat& bands, int x, int y, int direction, int reach) {
  const double theta = direction * kPi / 16, c = std::cos(theta), s = std::sin(theta);
  const bool flat = std::abs(c) >= std::abs(s);
  const double per_step = 1 / (flat ? std::abs(c) : std::abs(s)), slope = flat ? s / c : c / s;
  const auto at = [&](int column, int row) {
    const cv::Vec4f& v = bands.at<cv::Vec4f>(cv::borderInterpolate(row, bands.rows, cv::BORDER_REFLECT_101),
                                             cv::borderInterpolate(column, bands.cols, cv::BORDER_REFLECT_101));
    return cv::Vec3d(v[0], v[1], v[2]);
  };
  // Mean and variance along, at an offset across.
  const auto along = [&](int d, cv::Vec3d& mean, double& variance) {
    const int cx = x + int(std::lround(-d * s)), cy = y + int(std::lround(d * c));
    double weights = 0, square = 0;
    mean = {0, 0, 0};
    for (int i = -10; i <= 10; i += 2) {
      if (std::abs(i) * per_step > 10 + 1e-9) continue;
      const double hann = 0.5 + 0.5 * std::cos(kPi * i * per_step / 11);
      const int low = int(std::floor(i * slope + 1e-9));
      for (int k = 0; k < 2; ++k) {
        const double part = std::max(0.0, i * slope - low), w = hann * (k == 0 ? 1 - part : part);
        const cv::Vec3d v = flat ? at(cx + i, cy + low + k) : at(cx + low + k, cy + i);
        mean += v * w;
        square += v.dot(v) * w;
        weights += w;
      }
    }
    mean *= 1 / weights;
    variance = std::max(0.0, square / weights - mean.dot(mean));
  };
  const auto strip = [&](int first, int last, double& variance) {
    cv::Vec3d sum(0, 0, 0), mean;
    variance = 0;
    for (int d = first; d <= last; ++d) {
      double v = 0;
      along(d, mean, v);
      sum += mean;
      variance += v / (last - first + 1);
    }
    return cv::Vec3d(sum * (1.0 / (last - first + 1)));
  };
  double v = 0, unused = 0;
  const int half = std::max(1, (reach + 1) / 2);
  const cv::Vec3d m = strip(-reach, reach, v), p = strip(reach + 1, reach + 3, unused),
                  n = strip(-reach - 3, -reach - 1, unused), r = strip(reach - half + 1, reach, unused),
                  l = strip(-reach, -reach + half - 1, unused);
  return (std::min(cv::norm(p - m), cv::norm(n - m)) - cv::norm(r - l)) / (std::sqrt(v) + 2);
}

TEST(RoadFilter, IsWhatItsFormulaSays) {
  cv::Mat bands, response, direction;
  road_bands(band_image({60, 50}, {30, 24}, 0.6, CV_8UC3), bands);
  road_response(bands, response, direction);
  // On the band, beside it, at the border and in a corner.
  for (const cv::Point& p : {cv::Point(30, 24), cv::Point(36, 20), cv::Point(59, 30), cv::Point(0, 0)}) {
    double best = -9;
    for (int d = 0; d < kRoadDirections; ++d)
      for (const int reach : kRoadReach) best = std::max(best, reference_at(bands, p.x, p.y, d, reach));
    EXPECT_NEAR(response.at<float>(p), best, 2e-3 * std::max(1.0, best)) << p;
  }
}

TEST(RoadFilter, FindsABandsMiddleAndDirection) {
  for (const double theta : {0.0, 0.35, 0.8, 1.3, 1.9, 2.6}) {
    const cv::Point2d middle(50, 50);
    cv::Mat bands;
    road_bands(band_image({101, 101}, middle, theta), bands);
    int on_line = 0;
    for (const RoadCandidate& c : road_candidates(bands, {})) {
      const double across = -(c.x - middle.x) * std::sin(theta) + (c.y - middle.y) * std::cos(theta);
      if (std::hypot(c.x - 50, c.y - 50) > 30 || std::abs(across) > 1) continue;
      ++on_line;
      EXPECT_NEAR(std::remainder(double(c.theta_rad) - theta, kPi), 0, 0.1);  // half a step
    }
    EXPECT_GE(on_line, 40) << theta;  // of 60 pixels along; 43 to 60 lie on a line of the raster
  }
}

TEST(RoadFilter, KeepsAwayFromWhereThereIsNoData) {
  cv::Mat bands;
  road_bands(band_image({101, 101}, {50, 50}, 0), bands);
  cv::Mat valid(101, 101, CV_8UC1, cv::Scalar(255));
  valid.colRange(60, 101).setTo(0);
  int left = 0;
  for (const RoadCandidate& c : road_candidates(bands, valid)) {
    EXPECT_LT(c.x, 50);  // 10 pixels away from column 60
    left += c.y == 50;
  }
  EXPECT_GE(left, 45);  // all of columns 0 to 49 but some
}

TEST(RoadProfile, IsTheSameFromBothEndsAndMirrored) {
  // Turned by 180 degrees and mirrored, the image shows the same road; only the two sides change places.
  const cv::Mat image = band_image({81, 81}, {40, 41}, 0, CV_8UC3);
  cv::Mat flipped, bands, flipped_bands;
  cv::flip(image, flipped, 0);
  road_bands(image, bands);
  road_bands(flipped, flipped_bands);
  RoadProfile a, b;
  EXPECT_EQ(road_profile(bands, 40, 41, 0, a), road_profile(flipped_bands, 40, 39, 0, b));
  for (size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-3 * std::max(1.0f, std::abs(a[i]))) << i;
}

TEST(RoadProfile, SaysHowWideTheBandIs) {
  cv::Mat bands;
  road_bands(band_image({81, 81}, {40, 40}, 0.4), bands);
  RoadProfile profile;
  EXPECT_EQ(road_profile(bands, 40, 40, 0.4f, profile), 5);
  // Difference in luma two pixels beyond its edge, the lesser of both sides: 60 less than the band's.
  EXPECT_NEAR(profile[20 + 2 * 4], -60, 6);
}

}  // namespace
}  // namespace landfix::features
