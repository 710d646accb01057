#include "runtime/features/contour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "runtime/features/gradient.h"
#include "runtime/features/vectorized.h"

namespace landfix::features {
namespace {

constexpr int kLargestTruncation = 15, kLargestRadius = 64;

void check(const ContourOptions& o) {
  CV_Assert(o.window_radius_px >= 1 && o.window_radius_px <= kLargestRadius && o.floor >= 1 && o.min_length_px >= 1 &&
            o.truncation_px >= 1 && o.truncation_px <= kLargestTruncation && o.contrast >= 0);
}

// Of a row of gradients; in their unit. Rounding of a square root is exact by IEEE 754.
LANDFIX_VECTORIZED void magnitude_row(const int16_t* gx, const int16_t* gy, const uint8_t* known, int width,
                                      uint16_t* out) {
  for (int x = 0; x < width; ++x) {
    const float m = std::sqrt(float(gx[x] * gx[x] + gy[x] * gy[x])) + 0.5f;
    out[x] = known[x] ? uint16_t(int(m)) : uint16_t(0);
  }
}

cv::Mat magnitude(const cv::Mat& gx, const cv::Mat& gy, const cv::Mat& known) {
  cv::Mat out(gx.size(), CV_16UC1);
  for (int y = 0; y < out.rows; ++y)
    magnitude_row(gx.ptr<int16_t>(y), gy.ptr<int16_t>(y), known.ptr<uint8_t>(y), out.cols, out.ptr<uint16_t>(y));
  return out;
}

// Integer sums over the square around each pixel, nothing beyond the border.
cv::Mat sums_around(const cv::Mat& image, int radius) {
  const cv::Size side(2 * radius + 1, 2 * radius + 1);
  cv::Mat out;
  cv::boxFilter(image, out, CV_32S, side, {-1, -1}, false, cv::BORDER_CONSTANT);
  return out;
}

// The neighbours across the edge, of four directions: a gradient within 22.5° of an axis or a diagonal.
inline void neighbours(int gx, int gy, int& dx, int& dy) {
  const int ax = std::abs(gx), ay = std::abs(gy);
  // tan 22.5° = 0.41421 = 13573 / 32768 to 2e-6.
  dx = ay * 32768LL > ax * 79109LL ? 0 : 1;
  dy = ay * 32768LL < ax * 13573LL ? 0 : 1;
  if ((gx < 0) != (gy < 0)) dy = -dy;
}

// One of two equal neighbours wins, the same wherever the window begins.
bool is_ridge(const cv::Mat& m, const cv::Mat& gx, const cv::Mat& gy, int x, int y) {
  int dx, dy;
  neighbours(gx.at<int16_t>(y, x), gy.at<int16_t>(y, x), dx, dy);
  const int here = m.at<uint16_t>(y, x);
  return here > m.at<uint16_t>(y - dy, x - dx) && here >= m.at<uint16_t>(y + dy, x + dx);
}

// Leaves 8-connected chains of `least` pixels and more. The border of the mask is 0.
void drop_short_chains(cv::Mat& mask, size_t least) {
  constexpr uint8_t kUnseen = 255, kSeen = 1;
  std::vector<cv::Point> chain;
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x) {
      if (mask.at<uint8_t>(y, x) != kUnseen) continue;
      mask.at<uint8_t>(y, x) = kSeen;
      chain.assign(1, {x, y});
      for (size_t i = 0; i < chain.size(); ++i)
        for (int n = 0; n < 9; ++n) {
          const cv::Point p = chain[i] + cv::Point(n % 3 - 1, n / 3 - 1);
          if (mask.at<uint8_t>(p) != kUnseen) continue;
          mask.at<uint8_t>(p) = kSeen;
          chain.push_back(p);
        }
      if (chain.size() < least)
        for (const cv::Point& p : chain) mask.at<uint8_t>(p) = 0;
    }
  mask = mask > 0;
}

// 255 where the magnitude reaches the floor and `contrast` times the mean around, `sum` / `count`.
LANDFIX_VECTORIZED void strong_row(const uint16_t* m, const int32_t* sum, const int32_t* count, int width, int floor,
                                   float contrast, uint8_t* out) {
  for (int x = 0; x < width; ++x)
    out[x] = m[x] >= floor && float(m[x]) * float(count[x]) >= contrast * float(sum[x]) ? 255 : 0;
}

void find(const cv::Mat& gray, const cv::Mat& valid, const ContourOptions& o, cv::Mat& gx, cv::Mat& gy, cv::Mat& mask,
          cv::Mat& known) {
  check(o);
  CV_Assert(gray.type() == CV_8UC1);
  const cv::Mat is_known = eroded(checked_mask(gray, valid), kGradientRadiusPx);
  gradient(gray, gx, gy);
  const cv::Mat m = magnitude(gx, gy, is_known);
  const cv::Mat sum = sums_around(m, o.window_radius_px), count = sums_around(is_known, o.window_radius_px);
  const int floor = o.floor * kGradientScale;
  const auto contrast = float(o.contrast * 255);  // of a sum against a count of 255 each
  cv::Mat out = cv::Mat::zeros(gray.size(), CV_8UC1);
  for (int y = kGradientRadiusPx; y + kGradientRadiusPx < gray.rows; ++y) {
    uint8_t* row = out.ptr<uint8_t>(y);
    strong_row(m.ptr<uint16_t>(y), sum.ptr<int32_t>(y), count.ptr<int32_t>(y), gray.cols, floor, contrast, row);
    for (int x = kGradientRadiusPx; x + kGradientRadiusPx < gray.cols; ++x)
      if (row[x] && !is_ridge(m, gx, gy, x, y)) row[x] = 0;
  }
  drop_short_chains(out, size_t(o.min_length_px));
  mask = out;
  known = is_known;
}

// Rows from each pixel up or down to the nearest contour of its column, at most `limit`.
cv::Mat distance_in_column(const cv::Mat& mask, int limit) {
  cv::Mat out(mask.size(), CV_8UC1);
  std::vector<uint8_t> distance(size_t(mask.cols), uint8_t(limit));
  const auto pass = [&](int y, bool first) {
    const uint8_t* is_contour = mask.ptr<uint8_t>(y);
    uint8_t* to = out.ptr<uint8_t>(y);
    for (int x = 0; x < mask.cols; ++x) {
      const int next = is_contour[x] ? 0 : std::min(distance[size_t(x)] + 1, limit);
      distance[size_t(x)] = uint8_t(next);
      to[x] = first ? uint8_t(next) : std::min(to[x], uint8_t(next));
    }
  };
  for (int y = 0; y < mask.rows; ++y) pass(y, true);
  std::fill(distance.begin(), distance.end(), uint8_t(limit));
  for (int y = mask.rows - 1; y >= 0; --y) pass(y, false);
  return out;
}

// Smallest squared distance over the columns within `reach`; `square` is padded by `reach` at both ends.
LANDFIX_VECTORIZED void nearest_in_row(const uint16_t* square, int width, int reach, uint16_t* out) {
  for (int x = 0; x < width; ++x) out[x] = square[x + reach];
  for (int d = 1; d <= reach; ++d)
    for (int x = 0; x < width; ++x) {
      const uint16_t nearer = std::min(square[x + reach - d], square[x + reach + d]);
      out[x] = std::min(out[x], uint16_t(nearer + d * d));
    }
}

}  // namespace

void contours(const cv::Mat& gray, const cv::Mat& valid, const ContourOptions& options, cv::Mat& mask, cv::Mat& known) {
  cv::Mat gx, gy;
  find(gray, valid, options, gx, gy, mask, known);
}

void contours(const cv::Mat& gray, const cv::Mat& valid, const ContourOptions& options, cv::Mat& mask, cv::Mat& known,
              cv::Mat& direction) {
  cv::Mat gx, gy;
  find(gray, valid, options, gx, gy, mask, known);
  cv::Mat out = cv::Mat::zeros(mask.size(), CV_32FC1);
  for (int y = 0; y < out.rows; ++y)
    for (int x = 0; x < out.cols; ++x)
      if (mask.at<uint8_t>(y, x))
        out.at<float>(y, x) = float(std::atan2(double(gy.at<int16_t>(y, x)), double(gx.at<int16_t>(y, x))));
  direction = out;
}

void contour_distance(const cv::Mat& mask, const cv::Mat& known, const ContourOptions& options, cv::Mat& distance) {
  check(options);
  CV_Assert(mask.type() == CV_8UC1 && known.type() == CV_8UC1 && mask.size() == known.size());
  const int reach = options.truncation_px, limit = reach + 1;
  // A distance of `reach` and more is stored alike: its square stands for all.
  std::array<uint8_t, kLargestTruncation * kLargestTruncation + 1> stored;
  for (size_t square = 0; square < stored.size(); ++square) {
    const double d = std::min(std::sqrt(double(square)), double(reach));
    stored[square] = uint8_t(1 + (d < 1.5 ? std::lround(d) : 2 * std::lround(d / 2)));
  }
  const cv::Mat column = distance_in_column(mask, limit);
  std::vector<uint16_t> square(size_t(mask.cols + 2 * reach), uint16_t(limit * limit)), nearest(size_t(mask.cols));
  cv::Mat out(mask.size(), CV_8UC1);
  for (int y = 0; y < mask.rows; ++y) {
    const uint8_t *from = column.ptr<uint8_t>(y), *is_known = known.ptr<uint8_t>(y);
    for (int x = 0; x < mask.cols; ++x) square[size_t(x + reach)] = uint16_t(from[x] * from[x]);
    nearest_in_row(square.data(), mask.cols, reach, nearest.data());
    uint8_t* to = out.ptr<uint8_t>(y);
    for (int x = 0; x < mask.cols; ++x)
      to[x] = is_known[x] ? stored[std::min(size_t(nearest[size_t(x)]), size_t(reach * reach))] : uint8_t(0);
  }
  distance = out;
}

}  // namespace landfix::features
