#include "runtime/features/road_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "runtime/features/vectorized.h"

namespace landfix::features {
namespace {

constexpr int kLinePx = 10;                    // half length of the window along
constexpr int kSidePx = 3;                     // width of a side
constexpr int kAcross = 6 + kSidePx;           // widest reach across
constexpr int kPadPx = kLinePx + kAcross + 1;  // of the planes
constexpr int kOffsets = 2 * kAcross + 1, kChunk = 32;
// The four bands, the variance of the first three, and that of the last.
constexpr int kPlanes = 6, kSpread = 4, kHueSpread = 5;
constexpr int kStripRows = 48;  // at a time: their means stay in the cache
constexpr float kNoise = 2;     // gray levels: keeps the response of even ground finite
constexpr int kCleanPx = 10;
constexpr double kStep_rad = std::numbers::pi / kRoadDirections;

struct Tap {
  int dx, dy;
  float weight;
};

// A Hann window along the direction, two steps of its longer axis at a time, linear between the two pixels across.
std::vector<Tap> line_taps(double theta) {
  const double c = std::cos(theta), s = std::sin(theta);
  const bool flat = std::abs(c) >= std::abs(s);
  const double slope = flat ? s / c : c / s, per_step = 1 / (flat ? std::abs(c) : std::abs(s));
  std::vector<Tap> taps;
  double sum = 0;
  const int n = int(std::floor(kLinePx / per_step)) & ~1;
  for (int i = -n; i <= n; i += 2) {
    const double hann = 0.5 + 0.5 * std::cos(std::numbers::pi * i * per_step / (kLinePx + 1));
    const int low = int(std::floor(i * slope + 1e-9));
    const double part = std::max(0.0, i * slope - low);
    for (int k = 0; k < 2; ++k) {
      const double weight = hann * (k == 0 ? 1 - part : part);
      if (weight < 1e-6) continue;
      taps.push_back({flat ? i : low + k, flat ? low + k : i, float(weight)});
      sum += weight;
    }
  }
  for (Tap& t : taps) t.weight = float(t.weight / sum);
  return taps;
}

using Chunk = std::array<float, kChunk>;
using Planes = std::array<cv::Mat, kPlanes>;

// Weighted means along the line over a chunk of a row.
LANDFIX_VECTORIZED void average_chunk(const cv::Mat& plane, const std::vector<Tap>& taps, int x, int y, float* mean) {
  using Eight = float __attribute__((vector_size(32)));  // sums that stay in registers
  constexpr size_t kSums = 4;
  for (int part = 0; part < kChunk; part += 8 * int(kSums)) {
    Eight sums[kSums] = {};
    for (const Tap& t : taps) {
      const float* from = plane.ptr<float>(y + t.dy) + x + t.dx + part;
      for (size_t k = 0; k < kSums; ++k) {
        Eight values;
        std::memcpy(&values, from + 8 * k, sizeof values);
        sums[k] += t.weight * values;
      }
    }
    std::memcpy(mean + x + part, sums, sizeof sums);
  }
}

// The means of the squares become variances.
LANDFIX_VECTORIZED void subtract_squares(float* const means[], int x) {
  const float *a = means[0] + x, *b = means[1] + x, *c = means[2] + x, *hue = means[3] + x;
  float *spread = means[kSpread] + x, *hue_spread = means[kHueSpread] + x;
  for (int i = 0; i < kChunk; ++i) {
    spread[i] = std::max(0.0f, spread[i] - (a[i] * a[i] + b[i] * b[i] + c[i] * c[i]));
    hue_spread[i] = std::max(0.0f, hue_spread[i] - hue[i] * hue[i]);
  }
}

// Rows `first` to `last` of the planes, into rows 0 and on of the means.
void average_along(const Planes& planes, const std::vector<Tap>& taps, int first, int last, Planes& means) {
  for (int y = first; y < last; ++y) {
    float* to[kPlanes];
    for (size_t p = 0; p < kPlanes; ++p) to[p] = means[p].ptr<float>(y - first);
    for (int x = kLinePx + 1; x + kChunk + kLinePx + 1 <= planes[0].cols; x += kChunk) {
      for (size_t p = 0; p < kPlanes; ++p) average_chunk(planes[p], taps, x, y, to[p]);
      subtract_squares(to, x);
    }
  }
}

// Running sums across the line at one stretch of a row: entry d + 1 less entry c is the sum of offsets c to d.
using Sums = std::array<std::array<Chunk, kOffsets + 1>, kPlanes>;

// One over the number of offsets from `first` to `last` times their sum.
struct Strip {
  Strip(int first, int last)
      : from(size_t(first + kAcross)), to(size_t(last + kAcross + 1)), share(1.0f / float(last - first + 1)) {}
  float mean(const std::array<Chunk, kOffsets + 1>& sums, size_t i) const {
    return (sums[to][i] - sums[from][i]) * share;
  }
  size_t from, to;
  float share;
};

// What a width compares.
struct Strips {
  explicit Strips(int reach)
      : middle(-reach, reach),
        right(reach + 1, reach + kSidePx),
        left(-reach - kSidePx, -reach - 1),
        right_half(reach - std::max(1, (reach + 1) / 2) + 1, reach),
        left_half(-reach, -reach + std::max(1, (reach + 1) / 2) - 1) {}
  Strip middle, right, left, right_half, left_half;
};

inline void respond(const Sums& sums, const Strips& s, Chunk& greatest) {
  for (size_t i = 0; i < kChunk; ++i) {
    float right = 0, left = 0, uneven = 0;
    for (size_t b = 0; b < 3; ++b) {
      const float m = s.middle.mean(sums[b], i), p = s.right.mean(sums[b], i) - m, n = s.left.mean(sums[b], i) - m;
      const float u = s.right_half.mean(sums[b], i) - s.left_half.mean(sums[b], i);
      right += p * p;
      left += n * n;
      uneven += u * u;
    }
    const float spread = std::sqrt(std::max(0.0f, s.middle.mean(sums[kSpread], i)));
    const float r = (std::sqrt(std::min(right, left)) - std::sqrt(uneven)) / (spread + kNoise);
    greatest[i] = std::max(greatest[i], r);
  }
}

inline void respond_to_hue(const Sums& sums, const Strips& s, Chunk& greatest) {
  const std::array<Chunk, kOffsets + 1>& hue = sums[3];
  for (size_t i = 0; i < kChunk; ++i) {
    const float m = s.middle.mean(hue, i), p = std::abs(s.right.mean(hue, i) - m),
                n = std::abs(s.left.mean(hue, i) - m);
    const float u = std::abs(s.right_half.mean(hue, i) - s.left_half.mean(hue, i));
    const float spread = std::sqrt(std::max(0.0f, s.middle.mean(sums[kHueSpread], i)));
    greatest[i] = std::max(greatest[i], (std::min(p, n) - u) / (spread + kNoise));
  }
}

std::array<cv::Point, kOffsets> offsets_across(double theta) {
  std::array<cv::Point, kOffsets> across;
  for (int d = -kAcross; d <= kAcross; ++d)
    across[size_t(d + kAcross)] = {int(std::lround(-d * std::sin(theta))), int(std::lround(d * std::cos(theta)))};
  return across;
}

// The response of one direction at a chunk whose first pixel is (x, y) of the means: the greatest over the widths.
LANDFIX_VECTORIZED void respond_chunk(const Planes& means, const std::array<cv::Point, kOffsets>& across, int x, int y,
                                      Sums& sums, Chunk& greatest) {
  for (size_t p = 0; p < kPlanes; ++p) {
    for (size_t d = 0; d < kOffsets; ++d) {
      const float* row = means[p].ptr<float>(y + across[d].y) + x + across[d].x;
      for (size_t i = 0; i < kChunk; ++i) sums[p][d + 1][i] = sums[p][d][i] + row[i];
    }
  }
  greatest.fill(-9);
  for (const int reach : kRoadReach) {
    const Strips strips(reach);
    respond(sums, strips, greatest);
    respond_to_hue(sums, strips, greatest);
  }
}

// Rows of the response from `first` on, as many as the means have but for the pads.
void keep_greatest(const Planes& means, int direction, int first, int last, cv::Mat& response, cv::Mat& best) {
  const std::array<cv::Point, kOffsets> across = offsets_across(direction * kStep_rad);
  Sums sums;
  for (auto& plane : sums) plane[0].fill(0);
  Chunk r;
  for (int y = first; y < last; ++y) {
    for (int x = 0; x < response.cols; x += kChunk) {
      respond_chunk(means, across, x + kPadPx, y - first + kAcross, sums, r);
      float* to = response.ptr<float>(y) + x;
      uint8_t* which = best.ptr(y) + x;
      const int count = std::min(kChunk, response.cols - x);
      for (int i = 0; i < count; ++i) {
        if (r[size_t(i)] <= to[i]) continue;
        to[i] = r[size_t(i)];
        which[i] = uint8_t(direction);
      }
    }
  }
}

// The bands apart, and their squares, with room around for every window.
Planes planes_of(const cv::Mat& bands) {
  cv::Mat padded;
  // To the right there is room for a whole chunk.
  cv::copyMakeBorder(bands, padded, kPadPx, kPadPx, kPadPx, kPadPx + 2 * kChunk, cv::BORDER_REFLECT_101);
  Planes planes;
  cv::split(padded, planes.data());
  planes[kSpread].create(padded.size(), CV_32FC1);
  planes[kHueSpread].create(padded.size(), CV_32FC1);
  for (int y = 0; y < padded.rows; ++y) {
    const float *a = planes[0].ptr<float>(y), *b = planes[1].ptr<float>(y), *c = planes[2].ptr<float>(y);
    const float* hue = planes[3].ptr<float>(y);
    float *square = planes[kSpread].ptr<float>(y), *hue_square = planes[kHueSpread].ptr<float>(y);
    for (int x = 0; x < padded.cols; ++x) {
      square[x] = a[x] * a[x] + b[x] * b[x] + c[x] * c[x];
      hue_square[x] = hue[x] * hue[x];
    }
  }
  return planes;
}

// Binomial-like smoothing with fixed weights (a Gaussian of sigma 0.7 over five pixels).
cv::Mat smoothed(const cv::Mat& response) {
  constexpr float kW[] = {0.57047f, 0.20563f, 0.009635f};
  cv::Mat padded, rows(response.rows + 4, response.cols, CV_32FC1), out(response.size(), CV_32FC1);
  cv::copyMakeBorder(response, padded, 2, 2, 2, 2, cv::BORDER_REFLECT_101);
  for (int y = 0; y < rows.rows; ++y) {
    const float* p = padded.ptr<float>(y) + 2;
    for (int x = 0; x < rows.cols; ++x)
      rows.at<float>(y, x) = kW[0] * p[x] + kW[1] * (p[x - 1] + p[x + 1]) + kW[2] * (p[x - 2] + p[x + 2]);
  }
  for (int y = 0; y < out.rows; ++y)
    for (int x = 0; x < out.cols; ++x)
      out.at<float>(y, x) = kW[0] * rows.at<float>(y + 2, x) +
                            kW[1] * (rows.at<float>(y + 1, x) + rows.at<float>(y + 3, x)) +
                            kW[2] * (rows.at<float>(y, x) + rows.at<float>(y + 4, x));
  return out;
}

// Ties go to the pixel that comes first across.
bool greatest_across(const cv::Mat& response, const cv::Mat& direction, int x, int y) {
  const double theta = direction.at<uint8_t>(y, x) * kStep_rad;
  for (int d = 1; d <= 2; ++d) {
    for (const int sign : {-1, 1}) {
      const int px = x + int(std::lround(-sign * d * std::sin(theta)));
      const int py = y + int(std::lround(sign * d * std::cos(theta)));
      if (px < 0 || py < 0 || px >= response.cols || py >= response.rows) continue;
      const float here = response.at<float>(y, x), there = response.at<float>(py, px);
      if (sign > 0 ? here <= there : here < there) return false;
    }
  }
  return true;
}

// Least-squares line through the neighbours that lie along and point alike.
float refined(const RoadCandidate& c, const cv::Mat& index, const std::vector<RoadCandidate>& all) {
  constexpr int kRadius = 7;
  const float cosine = std::cos(c.theta_rad), sine = std::sin(c.theta_rad);
  float along2 = 8, mixed = 0;
  int count = 0;
  for (int y = std::max(0, c.y - kRadius); y <= std::min(index.rows - 1, c.y + kRadius); ++y) {
    for (int x = std::max(0, c.x - kRadius); x <= std::min(index.cols - 1, c.x + kRadius); ++x) {
      const int other = index.at<int>(y, x), dx = x - c.x, dy = y - c.y;
      if (other < 0 || dx * dx + dy * dy > kRadius * kRadius) continue;
      const float turn = std::remainder(all[size_t(other)].theta_rad - c.theta_rad, std::numbers::pi_v<float>);
      const float along = float(dx) * cosine + float(dy) * sine, across = float(dy) * cosine - float(dx) * sine;
      if (std::abs(turn) > 0.4363f || std::abs(along) < 1.5f || std::abs(across) > 1.2f + 0.25f * std::abs(along))
        continue;
      along2 += along * along;
      mixed += along * across;
      ++count;
    }
  }
  if (count < 2) return c.theta_rad;
  const float theta = c.theta_rad + std::clamp(std::atan2(mixed, along2), -0.25f, 0.25f);
  return theta < 0 ? theta + std::numbers::pi_v<float>
                   : (theta >= std::numbers::pi_v<float> ? theta - std::numbers::pi_v<float> : theta);
}

}  // namespace

void road_bands(const cv::Mat& image, cv::Mat& bands) {
  CV_Assert(image.type() == CV_8UC1 || image.type() == CV_8UC3);
  bands.create(image.size(), CV_32FC4);
  for (int y = 0; y < image.rows; ++y) {
    cv::Vec4f* to = bands.ptr<cv::Vec4f>(y);
    for (int x = 0; x < image.cols; ++x) {
      if (image.channels() == 1) {
        to[x] = {float(image.at<uint8_t>(y, x)), 0, 0, 0};
        continue;
      }
      const cv::Vec3b& c = image.at<cv::Vec3b>(y, x);
      const float r = c[0], g = c[1], b = c[2];
      const float red = r - g, yellow = 0.5f * (r + g) - b;
      to[x] = {0.299f * r + 0.587f * g + 0.114f * b, 0.7f * red, 0.7f * yellow,
               300 * (red - 0.45f * yellow) / (r + g + b + 24)};
    }
  }
}

void road_response(const cv::Mat& bands, cv::Mat& response, cv::Mat& direction) {
  CV_Assert(bands.type() == CV_32FC4);
  response.create(bands.size(), CV_32FC1);
  response.setTo(-9);
  direction.create(bands.size(), CV_8UC1);
  direction.setTo(0);
  const Planes planes = planes_of(bands);
  Planes means;
  for (cv::Mat& m : means) m.create(kStripRows + 2 * kAcross, planes[0].cols, CV_32FC1);
  std::vector<std::vector<Tap>> taps;
  for (int d = 0; d < kRoadDirections; ++d) taps.push_back(line_taps(d * kStep_rad));
  for (int first = 0; first < bands.rows; first += kStripRows) {
    const int last = std::min(bands.rows, first + kStripRows), top = first + kPadPx - kAcross;
    for (int d = 0; d < kRoadDirections; ++d) {
      average_along(planes, taps[size_t(d)], top, last + kPadPx + kAcross, means);
      keep_greatest(means, d, first, last, response, direction);
    }
  }
}

std::vector<RoadCandidate> road_candidates(const cv::Mat& bands, const cv::Mat& valid) {
  cv::Mat response, direction, clean;
  road_response(bands, response, direction);
  response = smoothed(response);
  if (!valid.empty()) {
    cv::erode(valid, clean, cv::Mat::ones(2 * kCleanPx + 1, 2 * kCleanPx + 1, CV_8UC1), {-1, -1}, 1,
              cv::BORDER_CONSTANT, cv::Scalar(255));
  }
  std::vector<RoadCandidate> found;
  cv::Mat index(bands.size(), CV_32SC1, cv::Scalar(-1));
  for (int y = 0; y < bands.rows; ++y) {
    for (int x = 0; x < bands.cols; ++x) {
      if (response.at<float>(y, x) < kRoadResponse || (!clean.empty() && clean.at<uint8_t>(y, x) == 0)) continue;
      if (!greatest_across(response, direction, x, y)) continue;
      index.at<int>(y, x) = int(found.size());
      found.push_back({x, y, float(direction.at<uint8_t>(y, x) * kStep_rad), response.at<float>(y, x)});
    }
  }
  std::vector<RoadCandidate> out = found;
  for (RoadCandidate& c : out) c.theta_rad = refined(c, index, found);
  return out;
}

}  // namespace landfix::features
