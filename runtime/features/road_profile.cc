#include "runtime/features/road_profile.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <span>

#include "runtime/features/road_filter.h"

namespace landfix::features {
namespace {

constexpr int kSteps = 15;  // along, 2 pixels each
constexpr float kStepPx = 2;
constexpr int kReach = 12, kColumns = 2 * kReach + 1;  // across
using Row = std::array<float, kColumns>;
using Colours = std::array<Row, 4>;  // the last one is the hue

struct Patch {
  Colours mean{}, ahead{}, behind{};  // over the window and over its halves
  Row scatter{}, hue_scatter{};       // standard deviation along, over the first three bands and of the hue
};

struct Window {
  std::array<float, kSteps> whole{}, half{};  // of `half`, the first entries serve behind, the last ahead
};

Window make_window() {
  Window w;
  float sum = 0, half = 0;
  for (int i = 0; i < kSteps; ++i) {
    const float u = float(i - kSteps / 2) * kStepPx;
    w.whole[size_t(i)] = 0.5f + 0.5f * std::cos(std::numbers::pi_v<float> * u / 16);
    sum += w.whole[size_t(i)];
    if (u > 0) half += w.whole[size_t(i)];
  }
  for (size_t i = 0; i < kSteps; ++i) {
    w.half[i] = i == kSteps / 2 ? 0 : w.whole[i] / half;
    w.whole[i] /= sum;
  }
  return w;
}

// The bands of a pixel, or sums of them.
using Bands = float __attribute__((vector_size(16)));

Bands load(const cv::Vec4f* pixel) {
  Bands b;
  std::memcpy(&b, pixel, sizeof b);
  return b;
}

// The part of the image that a profile needs, with the pixel of its place at (kRoadProfileHaloPx, kRoadProfileHaloPx).
struct Surroundings {
  const cv::Vec4f* centre;
  ptrdiff_t stride;           // in pixels
  cv::Mat copied;             // where it reaches beyond the border
  float right = 0, down = 0;  // from that pixel's centre to the place
};

Surroundings surroundings_of(const cv::Mat& bands, double place_x, double place_y) {
  constexpr int kHalo = kRoadProfileHaloPx;
  const int x = int(std::lround(place_x)), y = int(std::lround(place_y));
  const float right = float(place_x - x), down = float(place_y - y);
  if (x >= kHalo && y >= kHalo && x + kHalo < bands.cols && y + kHalo < bands.rows)
    return {bands.ptr<cv::Vec4f>(y) + x, ptrdiff_t(bands.step1() / 4), {}, right, down};
  Surroundings s;
  s.right = right;
  s.down = down;
  s.copied.create(2 * kHalo + 1, 2 * kHalo + 1, CV_32FC4);
  for (int row = -kHalo; row <= kHalo; ++row) {
    const cv::Vec4f* from = bands.ptr<cv::Vec4f>(cv::borderInterpolate(y + row, bands.rows, cv::BORDER_REFLECT_101));
    for (int column = -kHalo; column <= kHalo; ++column)
      s.copied.at<cv::Vec4f>(row + kHalo, column + kHalo) =
          from[cv::borderInterpolate(x + column, bands.cols, cv::BORDER_REFLECT_101)];
  }
  s.centre = s.copied.ptr<cv::Vec4f>(kHalo) + kHalo;
  s.stride = 2 * kHalo + 1;
  return s;
}

// Bilinear, relative to the centre.
inline Bands sample(const Surroundings& from, float dx, float dy) {
  // Never below -kRoadProfileHaloPx, so that the conversion rounds down.
  const int column = int(dx + kRoadProfileHaloPx) - kRoadProfileHaloPx,
            row = int(dy + kRoadProfileHaloPx) - kRoadProfileHaloPx;
  const float ax = dx - float(column), ay = dy - float(row);
  const cv::Vec4f* top = from.centre + row * from.stride + column;
  const cv::Vec4f* bottom = top + from.stride;
  const Bands a = load(top), c = load(bottom);
  const Bands upper = a + ax * (load(top + 1) - a), lower = c + ax * (load(bottom + 1) - c);
  return upper + ay * (lower - upper);
}

struct Sums {
  std::array<Bands, kColumns> mean{}, ahead{}, behind{}, square{};
};

Sums sums_over(const Surroundings& from, float theta) {
  static const Window kWindow = make_window();
  const float c = std::cos(theta), s = std::sin(theta);
  Sums sums;
  for (size_t i = 0; i < kSteps; ++i) {
    const float u = float(int(i) - kSteps / 2) * kStepPx, whole = kWindow.whole[i], half = kWindow.half[i];
    std::array<Bands, kColumns>& side = int(i) < kSteps / 2 ? sums.behind : sums.ahead;
    for (size_t j = 0; j < kColumns; ++j) {
      const float v = float(int(j) - kReach);
      const Bands value = sample(from, u * c - v * s + from.right, u * s + v * c + from.down);
      sums.mean[j] += whole * value;
      side[j] += half * value;
      sums.square[j] += whole * value * value;
    }
  }
  return sums;
}

Patch patch_at(const cv::Mat& bands, double x, double y, float theta) {
  const Sums sums = sums_over(surroundings_of(bands, x, y), theta);
  Patch p;
  for (size_t j = 0; j < kColumns; ++j) {
    float variance[4];
    for (size_t b = 0; b < 4; ++b) {
      p.mean[b][j] = sums.mean[j][b];
      p.ahead[b][j] = sums.ahead[j][b];
      p.behind[b][j] = sums.behind[j][b];
      variance[b] = sums.square[j][b] - sums.mean[j][b] * sums.mean[j][b];
    }
    p.scatter[j] = std::sqrt(std::max(0.0f, variance[0] + variance[1] + variance[2]));
    p.hue_scatter[j] = std::sqrt(std::max(0.0f, variance[3]));
  }
  return p;
}

float mean_of(const Row& row, int first, int last) {
  float sum = 0;
  for (int v = first; v <= last; ++v) sum += row[size_t(v + kReach)];
  return sum / float(last - first + 1);
}

struct Strip {
  float width_px = 0, response = -9;
};

// As of road_response(), on the patch, of the bands `first` to `last`.
Strip best_strip(const Patch& p, size_t first, size_t last, const Row& scatter) {
  Strip best;
  for (const int reach : kRoadReach) {
    float right = 0, left = 0, uneven = 0;
    const int half = std::max(1, (reach + 1) / 2);
    for (size_t k = first; k <= last; ++k) {
      const Row& row = p.mean[k];
      const float m = mean_of(row, -reach, reach), a = mean_of(row, reach + 1, reach + 3) - m;
      const float b = mean_of(row, -reach - 3, -reach - 1) - m;
      const float u = mean_of(row, reach - half + 1, reach) - mean_of(row, -reach, -reach + half - 1);
      right += a * a;
      left += b * b;
      uneven += u * u;
    }
    const float r = (std::sqrt(std::min(right, left)) - std::sqrt(uneven)) / (mean_of(scatter, -reach, reach) + 2);
    if (r > best.response) best = {float(2 * reach + 1), r};
  }
  return best;
}

// Appends features one by one.
class Writer {
 public:
  explicit Writer(RoadProfile& to) : to_(to) {}
  void add(float value) { to_[count_++] = value; }
  // The lesser and the greater of both sides at distances from the centre.
  void add_sides(const Row& row, std::span<const int> distances) {
    for (const int d : distances) {
      const float a = row[size_t(kReach - d)], b = row[size_t(kReach + d)];
      add(std::min(a, b));
      add(std::max(a, b));
    }
  }

 private:
  RoadProfile& to_;
  size_t count_ = 0;
};

float distance(const Colours& row, size_t j, size_t k) {
  float sum = 0;
  for (size_t b = 0; b < 3; ++b) sum += (row[b][j] - row[b][k]) * (row[b][j] - row[b][k]);
  return std::sqrt(sum);
}

float chroma(const Colours& row, size_t j) { return std::sqrt(row[1][j] * row[1][j] + row[2][j] * row[2][j]); }

}  // namespace

float road_profile(const cv::Mat& bands, double x, double y, float theta_rad, RoadProfile& profile) {
  static constexpr int kFar[] = {1, 2, 3, 4, 5, 6, 7, 8, 10, 12}, kRelative[] = {2, 3, 4, 5, 6, 8},
                       kChroma[] = {2, 3, 4, 5, 6, 8, 10};
  const Patch p = patch_at(bands, x, y, theta_rad);
  float centre[3], ahead = mean_of(p.ahead[0], -1, 1), behind = mean_of(p.behind[0], -1, 1), halves = 0;
  for (size_t b = 0; b < 3; ++b) {
    centre[b] = mean_of(p.mean[b], -1, 1);
    const float d = mean_of(p.ahead[b], -1, 1) - mean_of(p.behind[b], -1, 1);
    halves += d * d;
  }
  const float scatter = mean_of(p.scatter, -1, 1);
  const float hue = mean_of(p.mean[3], -1, 1), hue_scatter = mean_of(p.hue_scatter, -1, 1);
  const float hue_halves = std::abs(mean_of(p.ahead[3], -1, 1) - mean_of(p.behind[3], -1, 1));
  Row colour, luma, gradient, same, relative, saturation, tint;
  const float middle = (chroma(p.mean, kReach - 1) + chroma(p.mean, kReach) + chroma(p.mean, kReach + 1)) / 3;
  for (size_t j = 0; j < kColumns; ++j) {
    float sum = 0;
    for (size_t b = 0; b < 3; ++b) sum += (p.mean[b][j] - centre[b]) * (p.mean[b][j] - centre[b]);
    colour[j] = std::sqrt(sum);
    luma[j] = p.mean[0][j] - centre[0];
    const size_t k = std::clamp<size_t>(j, 1, kColumns - 2);
    gradient[j] = distance(p.mean, k - 1, k + 1);
    const float a = p.ahead[0][j] - ahead, b = p.behind[0][j] - behind;
    same[j] = std::min(std::abs(a), std::abs(b)) * (a * b >= 0 ? 1.0f : -1.0f);
    relative[j] = colour[j] / (scatter + 2);
    saturation[j] = chroma(p.mean, j) - middle;
    tint[j] = std::abs(p.mean[3][j] - hue);
  }
  const Strip plain = best_strip(p, 0, 2, p.scatter), tinted = best_strip(p, 3, 3, p.hue_scatter);
  const Strip& strip = tinted.response > plain.response ? tinted : plain;
  // Yellow paint on the middle: at a metre per pixel it is a tinge that the pixels beside it lack.
  const float yellow = p.mean[2][kReach] - std::max(mean_of(p.mean[2], 2, 3), mean_of(p.mean[2], -3, -2));
  Writer out(profile);
  for (const Row* row : std::array<const Row*, 5>{&colour, &luma, &gradient, &p.scatter, &same})
    out.add_sides(*row, kFar);
  for (const float value :
       {scatter, std::sqrt(halves), plain.width_px, plain.response, mean_of(p.scatter, -kReach, kReach), hue_scatter,
        hue_halves, tinted.width_px, tinted.response, mean_of(p.hue_scatter, -kReach, kReach), yellow})
    out.add(value);
  out.add_sides(relative, kRelative);
  out.add_sides(saturation, kChroma);
  out.add_sides(tint, kChroma);
  out.add_sides(p.hue_scatter, kChroma);
  return strip.width_px;
}

}  // namespace landfix::features
