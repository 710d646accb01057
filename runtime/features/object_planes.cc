#include "runtime/features/object_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace landfix::features {
namespace {

// All sums are of whole numbers: they come out the same wherever a filter starts.
constexpr int kSurroundings = 61;  // pixels; side of the square that tones and colours are compared with
constexpr int kToneUnit = 128;     // steps per unit of the natural logarithm
constexpr int kNoise = 16;         // added before the logarithm: dark noise must not count
constexpr int kDarkTone = -45;     // of shadows against their surroundings
constexpr int kMiddle = 128;       // what stands for zero in a plane of signed values

uint8_t clamped(float value) { return uint8_t(std::clamp(value, 0.0f, 255.0f) + 0.5f); }

cv::Mat blur(const cv::Mat& a, int side) {  // CV_16S or CV_32F with whole numbers
  cv::Mat out;
  cv::boxFilter(a, out, CV_32F, {side, side}, {-1, -1}, true, cv::BORDER_REPLICATE);
  return out;
}

// Value times `scale` about the middle.
cv::Mat plane_of(const cv::Mat& a, float scale, float middle = kMiddle) {
  cv::Mat out(a.size(), CV_8U);
  for (int y = 0; y < a.rows; ++y) {
    const float* from = a.ptr<float>(y);
    uint8_t* to = out.ptr(y);
    for (int x = 0; x < a.cols; ++x) to[x] = clamped(from[x] * scale + middle);
  }
  return out;
}

cv::Mat difference(const cv::Mat& a, const cv::Mat& b, float scale) {
  cv::Mat out(a.size(), CV_8U);
  for (int y = 0; y < a.rows; ++y) {
    const float *p = a.ptr<float>(y), *q = b.ptr<float>(y);
    uint8_t* to = out.ptr(y);
    for (int x = 0; x < a.cols; ++x) to[x] = clamped((p[x] - q[x]) * scale + kMiddle);
  }
  return out;
}

cv::Mat deviation(const cv::Mat& a, int side, float scale) {  // a: CV_16S
  cv::Mat square(a.size(), CV_32F);
  for (int y = 0; y < a.rows; ++y) {
    const int16_t* from = a.ptr<int16_t>(y);
    float* to = square.ptr<float>(y);
    for (int x = 0; x < a.cols; ++x) to[x] = float(from[x]) * float(from[x]);
  }
  const cv::Mat mean = blur(a, side), of_squares = blur(square, side);
  cv::Mat out(a.size(), CV_8U);
  for (int y = 0; y < a.rows; ++y) {
    const float *m = mean.ptr<float>(y), *s = of_squares.ptr<float>(y);
    uint8_t* to = out.ptr(y);
    for (int x = 0; x < a.cols; ++x) to[x] = clamped(std::sqrt(std::max(s[x] - m[x] * m[x], 0.0f)) * scale);
  }
  return out;
}

// Tone and, of colour images, the two opponent colours; CV_16S.
struct Tones {
  cv::Mat tone, red_green, blue_yellow;
};

Tones tones_of(const cv::Mat& image) {
  std::array<int16_t, 256> log;
  for (int v = 0; v < 256; ++v)
    log[size_t(v)] = int16_t(std::lround(kToneUnit * std::log(double(v + kNoise) / kNoise)));
  Tones out;
  out.tone.create(image.size(), CV_16S);
  const bool colour = image.channels() == 3;
  if (colour) {
    out.red_green.create(image.size(), CV_16S);
    out.blue_yellow.create(image.size(), CV_16S);
  }
  for (int y = 0; y < image.rows; ++y) {
    const uint8_t* p = image.ptr(y);
    int16_t* tone = out.tone.ptr<int16_t>(y);
    if (!colour) {
      for (int x = 0; x < image.cols; ++x) tone[x] = log[p[x]];
      continue;
    }
    int16_t *rg = out.red_green.ptr<int16_t>(y), *by = out.blue_yellow.ptr<int16_t>(y);
    for (int x = 0; x < image.cols; ++x, p += 3) {
      const int r = log[p[0]], g = log[p[1]], b = log[p[2]];
      tone[x] = int16_t((77 * r + 150 * g + 29 * b + 128) >> 8);
      rg[x] = int16_t(2 * (r - g));
      by[x] = int16_t(2 * b - r - g);
    }
  }
  return out;
}

// What is left when the mean of the surroundings' valid pixels is taken away, rounded; 0 where nothing is valid.
cv::Mat against_surroundings(const cv::Mat& a, const cv::Mat& valid) {
  cv::Mat kept = a, weight;
  if (!valid.empty()) {
    kept = a.clone();
    kept.setTo(0, valid == 0);
    cv::Mat ones = valid != 0;
    ones.convertTo(ones, CV_16S, 1.0 / 255);
    cv::boxFilter(ones, weight, CV_32F, {kSurroundings, kSurroundings}, {-1, -1}, false, cv::BORDER_REPLICATE);
  }
  cv::Mat sum;
  cv::boxFilter(kept, sum, CV_32F, {kSurroundings, kSurroundings}, {-1, -1}, false, cv::BORDER_REPLICATE);
  cv::Mat out(a.size(), CV_16S);
  for (int y = 0; y < a.rows; ++y) {
    const int16_t* from = a.ptr<int16_t>(y);
    const float* total = sum.ptr<float>(y);
    int16_t* to = out.ptr<int16_t>(y);
    for (int x = 0; x < a.cols; ++x) {
      const float count = weight.empty() ? float(kSurroundings * kSurroundings) : weight.at<float>(y, x);
      const bool known = valid.empty() || valid.at<uint8_t>(y, x) != 0;
      to[x] = known ? int16_t(std::floor(float(from[x]) - total[x] / count + 0.5f)) : int16_t(0);
    }
  }
  return out;
}

struct Gradients {
  cv::Mat length, twofold_c, twofold_s, fourfold_c, fourfold_s;  // CV_16S
};

// Sixteenths of a step of tone per pixel; the angle doubled and fourfold.
Gradients gradients_of(const cv::Mat& tone) {
  const cv::Mat smooth = (cv::Mat_<float>(1, 3) << 1, 2, 1), step = (cv::Mat_<float>(1, 3) << -1, 0, 1),
                across = (cv::Mat_<float>(1, 3) << 3, 10, 3);
  cv::Mat smoothed, gx, gy;
  cv::sepFilter2D(tone, smoothed, CV_32F, smooth, smooth, {-1, -1}, 0, cv::BORDER_REPLICATE);
  cv::sepFilter2D(smoothed, gx, CV_32F, step, across, {-1, -1}, 0, cv::BORDER_REPLICATE);
  cv::sepFilter2D(smoothed, gy, CV_32F, across, step, {-1, -1}, 0, cv::BORDER_REPLICATE);
  Gradients out;
  for (cv::Mat* m : {&out.length, &out.twofold_c, &out.twofold_s, &out.fourfold_c, &out.fourfold_s})
    m->create(tone.size(), CV_16S);
  const auto whole = [](float v) { return int16_t(std::floor(v + 0.5f)); };
  for (int y = 0; y < tone.rows; ++y) {
    const float *px = gx.ptr<float>(y), *py = gy.ptr<float>(y);
    int16_t *l = out.length.ptr<int16_t>(y), *c2 = out.twofold_c.ptr<int16_t>(y), *s2 = out.twofold_s.ptr<int16_t>(y),
            *c4 = out.fourfold_c.ptr<int16_t>(y), *s4 = out.fourfold_s.ptr<int16_t>(y);
    for (int x = 0; x < tone.cols; ++x) {
      const float u = px[x] / 32, v = py[x] / 32, square = u * u + v * v, m = std::sqrt(square) + 1e-3f;
      const float c = (u * u - v * v) / m, s = 2 * u * v / m;
      l[x] = whole(m), c2[x] = whole(c), s2[x] = whole(s);
      c4[x] = whole((c * c - s * s) / m), s4[x] = whole(2 * c * s / m);
    }
  }
  return out;
}

// How far the gradients of a square point the same way, 0 to 255.
cv::Mat agreement(const cv::Mat& cosine, const cv::Mat& sine, const cv::Mat& length, int side) {
  const cv::Mat c = blur(cosine, side), s = blur(sine, side), l = blur(length, side);
  cv::Mat out(c.size(), CV_8U);
  for (int y = 0; y < c.rows; ++y) {
    const float *pc = c.ptr<float>(y), *ps = s.ptr<float>(y), *pl = l.ptr<float>(y);
    uint8_t* to = out.ptr(y);
    for (int x = 0; x < c.cols; ++x) to[x] = clamped(255 * std::sqrt(pc[x] * pc[x] + ps[x] * ps[x]) / (pl[x] + 8));
  }
  return out;
}

// Of the differences to eight neighbours at `radius` the lowest, the third lowest, the third highest and the highest.
void add_ranks(const cv::Mat& tone, int radius, std::vector<cv::Mat>& planes) {
  static constexpr int kNetwork[19][2] = {{0, 1}, {2, 3}, {4, 5}, {6, 7}, {0, 2}, {1, 3}, {4, 6},
                                          {5, 7}, {1, 2}, {5, 6}, {0, 4}, {3, 7}, {1, 5}, {2, 6},
                                          {1, 4}, {3, 6}, {2, 4}, {3, 5}, {3, 4}};
  const int d = int(std::lround(radius * 0.7071));
  const cv::Point offsets[8] = {{radius, 0},  {d, d},   {0, radius},  {-d, d},
                                {-radius, 0}, {-d, -d}, {0, -radius}, {d, -d}};
  cv::Mat padded;
  cv::copyMakeBorder(tone, padded, radius, radius, radius, radius, cv::BORDER_REPLICATE);
  std::array<cv::Mat, 4> out;
  for (cv::Mat& m : out) m.create(tone.size(), CV_8U);
  std::vector<uint8_t> lanes(size_t(tone.cols) * 8);
  for (int y = 0; y < tone.rows; ++y) {
    const auto lane = [&](int k) { return lanes.data() + size_t(k) * size_t(tone.cols); };
    for (int k = 0; k < 8; ++k)
      std::copy_n(padded.ptr(y + radius + offsets[k].y) + radius + offsets[k].x, tone.cols, lane(k));
    for (const auto& [i, j] : kNetwork) {
      uint8_t *a = lane(i), *b = lane(j);
      for (int x = 0; x < tone.cols; ++x) {
        const uint8_t low = std::min(a[x], b[x]), high = std::max(a[x], b[x]);
        a[x] = low, b[x] = high;
      }
    }
    const uint8_t* centre = tone.ptr(y);
    constexpr int kRanks[4] = {0, 2, 5, 7};
    for (size_t k = 0; k < 4; ++k) {
      const uint8_t* from = lane(kRanks[k]);
      uint8_t* to = out[k].ptr(y);
      for (int x = 0; x < tone.cols; ++x) to[x] = uint8_t(kMiddle + (int(from[x]) - int(centre[x])) / 2);
    }
  }
  planes.insert(planes.end(), out.begin(), out.end());
}

void add_tones(const cv::Mat& tone, std::vector<cv::Mat>& planes) {
  constexpr float kScale = 0.66f;
  cv::Mat single;
  tone.convertTo(single, CV_32F);
  const cv::Mat m3 = blur(tone, 3), m7 = blur(tone, 7), m13 = blur(tone, 13), m25 = blur(tone, 25);
  for (const cv::Mat* m : {&std::as_const(single), &m3, &m7, &m13, &m25}) planes.push_back(plane_of(*m, kScale));
  planes.push_back(difference(single, m7, 1));
  planes.push_back(difference(m3, m13, 1));
  planes.push_back(difference(m7, m25, 1));
  for (const int side : {3, 7, 13}) planes.push_back(deviation(tone, side, 2));
}

void add_gradients(const Gradients& g, std::vector<cv::Mat>& planes) {
  for (const int side : {3, 5, 11, 21}) planes.push_back(plane_of(blur(g.length, side), 0.4f, 0));
  for (const int side : {5, 9}) planes.push_back(agreement(g.twofold_c, g.twofold_s, g.length, side));
  for (const int side : {9, 17}) planes.push_back(agreement(g.fourfold_c, g.fourfold_s, g.length, side));
}

// Shadows and bright spots near by, wherever they lie.
void add_surroundings(const cv::Mat& tone3, const cv::Mat& tone, std::vector<cv::Mat>& planes) {
  for (const int side : {5, 9, 15}) {
    const cv::Mat square = cv::Mat::ones(side, side, CV_8U);
    cv::Mat low, high;
    cv::erode(tone3, low, square, {-1, -1}, 1, cv::BORDER_REPLICATE);
    cv::dilate(tone3, high, square, {-1, -1}, 1, cv::BORDER_REPLICATE);
    planes.push_back(low);
    planes.push_back(high);
  }
  cv::Mat dark = tone < kDarkTone;
  dark.convertTo(dark, CV_16S);
  for (const int side : {7, 13, 25}) planes.push_back(plane_of(blur(dark, side), 1, 0));
  add_ranks(tone3, 4, planes);
  add_ranks(tone3, 7, planes);
}

void add_colour(const cv::Mat& colour, const cv::Mat& valid, std::vector<cv::Mat>& planes) {
  constexpr float kScale = 0.7f;
  const cv::Mat relative = against_surroundings(colour, valid);
  cv::Mat kept = colour;
  if (!valid.empty()) {
    kept = colour.clone();
    kept.setTo(0, valid == 0);
  }
  for (const int side : {3, 5, 11}) planes.push_back(plane_of(blur(kept, side), kScale));
  for (const int side : {3, 5, 11}) planes.push_back(plane_of(blur(relative, side), kScale));
  planes.push_back(difference(blur(relative, 3), blur(relative, 15), kScale));
  planes.push_back(deviation(relative, 7, 2));
}

}  // namespace

void object_planes(const cv::Mat& image, const cv::Mat& valid, std::vector<cv::Mat>& planes,
                   FourfoldGradient& gradient) {
  planes.clear();
  const Tones tones = tones_of(image);
  const cv::Mat tone = against_surroundings(tones.tone, valid);
  add_tones(tone, planes);
  Gradients g = gradients_of(tone);
  add_gradients(g, planes);
  const cv::Mat tone3 = planes[kPlaneTone3];
  add_surroundings(tone3, tone, planes);
  if (image.channels() == 3) {
    add_colour(tones.red_green, valid, planes);
    add_colour(tones.blue_yellow, valid, planes);
  }
  gradient = {g.fourfold_c, g.fourfold_s, g.length};
}

}  // namespace landfix::features
