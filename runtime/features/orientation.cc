#include "runtime/features/orientation.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "runtime/features/gradient.h"
#include "runtime/features/vectorized.h"

namespace landfix::features {
namespace {

constexpr int kSmoothRadius = 2;
constexpr float kBinomialSum = 256;  // of the 5x5 weights

// Rows of the three sums: gx² - gy², 2 gx gy, gx² + gy².
struct Sums {
  explicit Sums(size_t width) : difference(width), cross(width), energy(width) {}
  std::vector<int32_t> difference, cross, energy;
};

struct SmoothSums {
  explicit SmoothSums(size_t width) : difference(width), cross(width), energy(width) {}
  std::vector<float> difference, cross, energy;
};

// Four bands of gradients of at most 4·255·8 stay below 2^31.
LANDFIX_VECTORIZED void add_row(const int16_t* gx, const int16_t* gy, const uint8_t* known, int width,
                                int32_t* difference, int32_t* cross, int32_t* energy) {
  for (int x = 0; x < width; ++x) {
    const int32_t mask = known[x] ? -1 : 0;
    const int32_t xx = gx[x] * gx[x], yy = gy[x] * gy[x], xy = gx[x] * gy[x];
    difference[x] += (xx - yy) & mask;
    cross[x] += (2 * xy) & mask;
    energy[x] += (xx + yy) & mask;
  }
}

// `in` has two more pixels at either end than `out`.
LANDFIX_VECTORIZED void smooth_row(const int32_t* in, int width, float* out) {
  for (int x = 0; x < width; ++x) {
    const float outer = float(in[x]) + float(in[x + 4]), inner = float(in[x + 1]) + float(in[x + 3]);
    out[x] = outer + 4 * inner + 6 * float(in[x + 2]);
  }
}

inline float binomial(const float* const rows[5], int x) {
  return (rows[0][x] + rows[4][x]) + 4 * (rows[1][x] + rows[3][x]) + 6 * rows[2][x];
}

LANDFIX_VECTORIZED void weigh_row(const float* const difference[5], const float* const cross[5],
                                  const float* const energy[5], const uint8_t* known, int width, float half_weight,
                                  float* ab) {
  constexpr float kUnit = 1 / (kBinomialSum * kGradientScale * kGradientScale);
  for (int x = 0; x < width; ++x) {
    const float m = std::sqrt(binomial(energy, x) * kUnit);
    const float weight = kUnit / ((m + 1) * (m + half_weight));
    ab[2 * x] = known[x] ? binomial(difference, x) * weight : 0.0f;
    ab[2 * x + 1] = known[x] ? binomial(cross, x) * weight : 0.0f;
  }
}

}  // namespace

void orientation(const cv::Mat& bands, const cv::Mat& valid, const OrientationOptions& options, cv::Mat& ab,
                 cv::Mat& ab_valid) {
  CV_Assert(bands.depth() == CV_8U && bands.channels() >= 1 && bands.channels() <= 4);
  const cv::Mat known = eroded(checked_mask(bands, valid), kGradientRadiusPx);
  const int width = bands.cols, height = bands.rows;
  std::vector<cv::Mat> planes, gx(size_t(bands.channels())), gy(size_t(bands.channels()));
  cv::split(bands, planes);
  for (size_t i = 0; i < planes.size(); ++i) gradient(planes[i], gx[i], gy[i]);

  const float half_weight = options.half_weight * std::sqrt(float(bands.channels()));
  cv::Mat out(bands.size(), CV_32FC2);
  Sums sums(size_t(width) + 2 * kSmoothRadius);                  // with zeros beyond both ends
  std::vector<SmoothSums> smooth(5, SmoothSums(size_t(width)));  // rows y - 4 to y at y mod 5
  for (int y = 0; y < height + kSmoothRadius; ++y) {
    for (auto* sum : {&sums.difference, &sums.cross, &sums.energy}) std::fill(sum->begin(), sum->end(), 0);
    if (y < height)
      for (size_t i = 0; i < planes.size(); ++i)
        add_row(gx[i].ptr<int16_t>(y), gy[i].ptr<int16_t>(y), known.ptr<uint8_t>(y), width,
                sums.difference.data() + kSmoothRadius, sums.cross.data() + kSmoothRadius,
                sums.energy.data() + kSmoothRadius);
    SmoothSums& row = smooth[size_t(y % 5)];
    smooth_row(sums.difference.data(), width, row.difference.data());
    smooth_row(sums.cross.data(), width, row.cross.data());
    smooth_row(sums.energy.data(), width, row.energy.data());
    const int middle = y - kSmoothRadius;
    if (middle < 0) continue;
    const float *difference[5], *cross[5], *energy[5];
    for (int i = 0; i < 5; ++i) {
      const SmoothSums& s = smooth[size_t((y + 1 + i) % 5)];
      difference[i] = s.difference.data(), cross[i] = s.cross.data(), energy[i] = s.energy.data();
    }
    weigh_row(difference, cross, energy, known.ptr<uint8_t>(middle), width, half_weight, out.ptr<float>(middle));
  }
  ab = out;
  ab_valid = known;
}

DatedOrientation fuse(std::span<const DatedOrientation> dates) {
  CV_Assert(!dates.empty());
  if (dates.size() == 1) return dates[0];
  DatedOrientation out{cv::Mat(dates[0].ab.size(), CV_32FC2), cv::Mat(dates[0].ab.size(), CV_8UC1)};
  for (const DatedOrientation& date : dates)
    CV_Assert(date.ab.type() == CV_32FC2 && date.ab.size() == out.ab.size() && date.valid.size() == out.ab.size());
  std::vector<float> inverse(dates.size() + 1, 0.0f);
  for (size_t n = 1; n < inverse.size(); ++n) inverse[n] = 1 / float(n);
  for (int y = 0; y < out.ab.rows; ++y) {
    cv::Vec2f* sum = out.ab.ptr<cv::Vec2f>(y);
    uint8_t* valid = out.valid.ptr<uint8_t>(y);
    for (int x = 0; x < out.ab.cols; ++x) {
      float a = 0, b = 0;
      size_t count = 0;
      for (const DatedOrientation& date : dates) {
        const cv::Vec2f v = date.ab.at<cv::Vec2f>(y, x);  // 0 where not valid
        a += v[0], b += v[1];
        count += date.valid.at<uint8_t>(y, x) != 0;
      }
      sum[x] = {a * inverse[count], b * inverse[count]};
      valid[x] = count ? 255 : 0;
    }
  }
  return out;
}

void agreement(std::span<const DatedOrientation> dates, int block, cv::Mat& agreement) {
  CV_Assert(!dates.empty() && block > 0 && dates[0].ab.cols % block == 0 && dates[0].ab.rows % block == 0);
  for (const DatedOrientation& date : dates)
    CV_Assert(date.ab.type() == CV_32FC2 && date.ab.size() == dates[0].ab.size() &&
              date.valid.size() == date.ab.size());
  cv::Mat out(dates[0].ab.rows / block, dates[0].ab.cols / block, CV_8UC2);
  for (int by = 0; by < out.rows; ++by)
    for (int bx = 0; bx < out.cols; ++bx) {
      float together = 0, alone = 0;
      int pixels = 0, most = 0;
      for (int i = 0; i < block * block; ++i) {
        const int y = by * block + i / block, x = bx * block + i % block;
        float a = 0, b = 0, length = 0;
        int count = 0;
        for (const DatedOrientation& date : dates) {
          if (!date.valid.at<uint8_t>(y, x)) continue;
          const cv::Vec2f v = date.ab.at<cv::Vec2f>(y, x);
          a += v[0], b += v[1];
          length += std::sqrt(v[0] * v[0] + v[1] * v[1]);
          ++count;
        }
        if (count < 2) continue;
        ++pixels;
        most = std::max(most, count);
        together += std::sqrt(a * a + b * b);
        alone += length;
      }
      const float share = alone > 0 ? std::min(together / alone, 1.0f) : 0.0f;
      const bool enough = 2 * pixels >= block * block;
      out.at<cv::Vec2b>(by, bx) =
          enough ? cv::Vec2b(uint8_t(1 + int(share * 254 + 0.5f)), uint8_t(std::min(most, 255))) : cv::Vec2b(0, 0);
    }
  agreement = out;
}

}  // namespace landfix::features
