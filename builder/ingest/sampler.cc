#include "builder/ingest/sampler.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>
#include <vector>

namespace landfix::ingest {
namespace {

constexpr double kWidenAbove = 1 / 0.95;
constexpr double kLeastWeight = 0.24;

// Bilinear weights of bytes are integers of 15 bits a side: errors of 2^-16 pixel, and no rounding that depends on the
// machine.
constexpr int kBits = 15;
constexpr int64_t kOne = 1 << kBits;
constexpr int64_t kAll = kOne * kOne;
constexpr int64_t kLeast = int64_t(kLeastWeight * double(kAll));

/// One place in the patch: the upper left of four pixels around it and the fractions to the lower right.
struct Place {
  int column, row;
  int64_t fx, fy;
};

/// False where not even one of the four pixels lies in the patch, or for NaN.
bool place_of(const Patch& p, double x, double y, Place& place) {
  const double u = x - double(p.column) + 0.5, v = y - double(p.row) + 0.5;  // one more than the index: positive
  if (!(u >= 0 && v >= 0 && u < p.pixels.cols + 1 && v < p.pixels.rows + 1)) return false;
  const int64_t qx = int64_t(u * double(kOne) + 0.5), qy = int64_t(v * double(kOne) + 0.5);
  place = {int(qx >> kBits) - 1, int(qy >> kBits) - 1, qx & (kOne - 1), qy & (kOne - 1)};
  return true;
}

bool inside(const Patch& p, const Place& at) {
  return at.column >= 0 && at.row >= 0 && at.column + 1 < p.pixels.cols && at.row + 1 < p.pixels.rows;
}

template <int kChannels>
void bilinear_inside(const Patch& p, const Place& at, uchar* out) {
  const uchar* upper = p.pixels.ptr<uchar>(at.row) + at.column * kChannels;
  const uchar* lower = upper + p.pixels.step[0];
  for (int c = 0; c < kChannels; ++c) {
    const int64_t a = upper[c] * (kOne - at.fx) + upper[c + kChannels] * at.fx;
    const int64_t b = lower[c] * (kOne - at.fx) + lower[c + kChannels] * at.fx;
    out[c] = uchar((a * (kOne - at.fy) + b * at.fy + kAll / 2) >> (2 * kBits));
  }
}

/// The same at borders and holes: gives the same bytes as bilinear_inside where all four pixels have data.
template <int kChannels>
bool bilinear_at_gaps(const Patch& p, const Place& at, uchar* out) {
  std::array<int64_t, kChannels> sum{};
  int64_t total = 0;
  for (int i = 0; i < 4; ++i) {
    const int column = at.column + (i & 1), row = at.row + (i >> 1);
    if (column < 0 || row < 0 || column >= p.pixels.cols || row >= p.pixels.rows) continue;
    if (!p.valid.empty() && !p.valid.at<uchar>(row, column)) continue;
    const int64_t weight = ((i & 1) ? at.fx : kOne - at.fx) * ((i >> 1) ? at.fy : kOne - at.fy);
    const uchar* pixel = p.pixels.ptr<uchar>(row) + column * kChannels;
    for (int c = 0; c < kChannels; ++c) sum[c] += weight * pixel[c];
    total += weight;
  }
  if (total < kLeast) return false;
  for (int c = 0; c < kChannels; ++c) out[c] = uchar((sum[c] + total / 2) / total);
  return true;
}

template <int kChannels>
struct Bilinear {
  bool operator()(const Patch& p, double x, double y, uchar* out) const {
    Place at;
    if (!place_of(p, x, y, at)) return false;
    if (!inside(p, at) || !p.valid.empty()) return bilinear_at_gaps<kChannels>(p, at, out);
    bilinear_inside<kChannels>(p, at, out);
    return true;
  }
};

/// Weights of a triangle about `centre` (raster coordinates, made relative to the patch) for indices from `first`.
struct Taps {
  int first = 0;
  std::vector<double> weights;
  double total = 0;

  void place(double centre, double radius) {
    first = int(std::floor(centre - 0.5 - radius)) + 1;
    const int last = int(std::ceil(centre - 0.5 + radius)) - 1;
    weights.resize(size_t(std::max(0, last - first + 1)));
    total = 0;
    const double inverse = 1 / radius;
    for (size_t i = 0; i < weights.size(); ++i) {
      weights[i] = 1 - std::abs(double(first + int(i)) + 0.5 - centre) * inverse;
      total += weights[i];
    }
  }
};

/// Triangle of any radius, in double precision.
template <typename T, int kChannels>
class Triangle {
 public:
  Triangle(double radius_x, double radius_y) : radius_x_(radius_x), radius_y_(radius_y) {}

  bool operator()(const Patch& p, double x, double y, T* out) {
    const double u = x - double(p.column), v = y - double(p.row);
    if (!(u > -radius_x_ && v > -radius_y_ && u < p.pixels.cols + radius_x_ && v < p.pixels.rows + radius_y_))
      return false;
    columns_.place(u, radius_x_);
    rows_.place(v, radius_y_);
    std::array<double, kChannels> sum{};
    double total = 0;
    for (size_t j = 0; j < rows_.weights.size(); ++j) {
      const int row = rows_.first + int(j);
      if (row >= 0 && row < p.pixels.rows) add_row(p, row, rows_.weights[j], sum, total);
    }
    if (!(total >= kLeastWeight * columns_.total * rows_.total) || total <= 0) return false;
    for (int c = 0; c < kChannels; ++c) {
      if constexpr (std::is_same_v<T, uchar>) {
        out[c] = uchar(sum[c] / total + 0.5);
      } else {
        out[c] = T(sum[c] / total);
      }
    }
    return true;
  }

 private:
  void add_row(const Patch& p, int row, double row_weight, std::array<double, kChannels>& sum, double& total) const {
    const int begin = std::max(0, -columns_.first);
    const int end = std::min(int(columns_.weights.size()), p.pixels.cols - columns_.first);
    const T* pixel = p.pixels.ptr<T>(row) + (columns_.first + begin) * kChannels;
    const uchar* valid = p.valid.empty() ? nullptr : p.valid.ptr<uchar>(row) + columns_.first;
    std::array<double, kChannels> row_sum{};  // apart, so that the row's weight is multiplied once
    double row_total = 0;
    for (int i = begin; i < end; ++i, pixel += kChannels) {
      if (valid && !valid[i]) continue;
      const double weight = columns_.weights[size_t(i)];
      for (int c = 0; c < kChannels; ++c) row_sum[c] += weight * pixel[c];
      row_total += weight;
    }
    for (int c = 0; c < kChannels; ++c) sum[c] += row_weight * row_sum[c];
    total += row_weight * row_total;
  }

  double radius_x_, radius_y_;
  Taps columns_, rows_;
};

template <typename T, int kChannels, typename Kernel>
int64_t apply(Kernel kernel, const Patch& patch, const cv::Mat& x, const cv::Mat& y, cv::Mat& out, cv::Mat& valid) {
  int64_t filled = 0;
  for (int r = 0; r < out.rows; ++r) {
    const double* row_x = x.ptr<double>(r);
    const double* row_y = y.ptr<double>(r);
    T* row_out = out.ptr<T>(r);
    uchar* row_valid = valid.ptr<uchar>(r);
    for (int c = 0; c < out.cols; ++c) {
      if (row_valid[c] || !kernel(patch, row_x[c], row_y[c], row_out + c * kChannels)) continue;
      row_valid[c] = 255;
      ++filled;
    }
  }
  return filled;
}

template <int kChannels>
int64_t resample_bytes(const Patch& patch, const cv::Mat& x, const cv::Mat& y, double radius_x, double radius_y,
                       cv::Mat& out, cv::Mat& valid) {
  if (radius_x == 1 && radius_y == 1) return apply<uchar, kChannels>(Bilinear<kChannels>(), patch, x, y, out, valid);
  return apply<uchar, kChannels>(Triangle<uchar, kChannels>(radius_x, radius_y), patch, x, y, out, valid);
}

}  // namespace

double kernel_radius(double reduction) { return reduction > kWidenAbove ? reduction : 1.0; }

int64_t resample(const Patch& patch, const cv::Mat& x, const cv::Mat& y, const Reduction& reduction, cv::Mat out,
                 cv::Mat valid) {
  CV_Assert(patch.pixels.type() == out.type() && valid.type() == CV_8UC1 && x.type() == CV_64FC1 &&
            y.type() == CV_64FC1);
  CV_Assert(out.size() == valid.size() && out.size() == x.size() && out.size() == y.size());
  const double radius_x = kernel_radius(reduction.x), radius_y = kernel_radius(reduction.y);
  switch (out.type()) {
    case CV_8UC1:
      return resample_bytes<1>(patch, x, y, radius_x, radius_y, out, valid);
    case CV_8UC2:
      return resample_bytes<2>(patch, x, y, radius_x, radius_y, out, valid);
    case CV_8UC3:
      return resample_bytes<3>(patch, x, y, radius_x, radius_y, out, valid);
    case CV_8UC4:
      return resample_bytes<4>(patch, x, y, radius_x, radius_y, out, valid);
    case CV_32FC1:
      return apply<float, 1>(Triangle<float, 1>(radius_x, radius_y), patch, x, y, out, valid);
    default:
      CV_Error(cv::Error::StsUnsupportedFormat, "resample: 1 to 4 channels of bytes or one of floats");
  }
}

}  // namespace landfix::ingest
