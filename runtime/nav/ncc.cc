#include "runtime/nav/ncc.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "runtime/nav/correlator.h"

namespace landfix::nav {
namespace {

using features::GridImage;

constexpr double kFlatVariance = 1.0 / 12;  ///< of rounding to whole gray levels: less is no texture
constexpr int kGrayOffset = 128;            ///< taken off every gray value, so that squares stay below 2^14
constexpr int64_t kMaxCount32 = 1 << 18;    ///< pixels whose squares surely sum to less than 2^32

bool usable(const GridImage& image) {
  const bool mask_fits =
      image.valid.empty() || (image.valid.type() == CV_8UC1 && image.valid.size() == image.pixels.size());
  return !image.pixels.empty() && image.pixels.type() == CV_8UC1 && mask_fits;
}

bool valid_at(const cv::Mat& mask, int row, int column) {
  return row >= 0 && column >= 0 && row < mask.rows && column < mask.cols && mask.at<uint8_t>(row, column);
}

/// One pixel of a summed-area table with its sign.
struct Corner {
  int row, column;
};

/// Sums of a per-pixel value over the patch's mask, at all positions, exactly in integers: a summed-area table of the
/// window, read at the corners of the mask. Unsigned arithmetic may wrap within the table; a sum that fits `Sum` still
/// comes out right.
template <class Sum>
class MaskedSums {
 public:
  template <class Value>
  void build(cv::Size window, const Value& value) {
    columns_ = window.width + 1;
    table_.resize(size_t(window.height + 1) * columns_);
    std::fill_n(table_.begin(), columns_, Sum(0));
    for (int y = 0; y < window.height; ++y) {
      const Sum* above = table_.data() + size_t(y) * columns_;
      Sum* row = table_.data() + size_t(y + 1) * columns_;
      Sum run = row[0] = 0;
      for (int x = 0; x < window.width; ++x) {
        run += Sum(value(y, x));
        row[x + 1] = above[x + 1] + run;
      }
    }
  }

  /// The sums at the positions of row `y`.
  const Sum* row(int y, int positions, const std::vector<Corner>& plus, const std::vector<Corner>& minus) {
    sums_.assign(size_t(positions), 0);
    Sum* out = sums_.data();
    for (const Corner& c : plus) {
      const Sum* in = table_.data() + size_t(y + c.row) * columns_ + c.column;
      for (int x = 0; x < positions; ++x) out[x] += in[x];
    }
    for (const Corner& c : minus) {
      const Sum* in = table_.data() + size_t(y + c.row) * columns_ + c.column;
      for (int x = 0; x < positions; ++x) out[x] -= in[x];
    }
    return out;
  }

 private:
  size_t columns_ = 0;
  std::vector<Sum> table_, sums_;
};

/// The three sums that the window's mean and variance need.
template <class Sum>
struct WindowSums {
  MaskedSums<Sum> count, gray, squares;
};

/// What patch and window have in common at one position, gray values relative to a constant each.
struct Overlap {
  double count, inverse_count, window, window_squares, patch, patch_squares, product;
};

/// Conte 2009 eq. 5.15 from sums.
float coefficient(const Overlap& o) {
  const double patch_energy = o.patch_squares - o.patch * o.patch * o.inverse_count;
  const double window_energy = o.window_squares - o.window * o.window * o.inverse_count;
  if (!(std::min(patch_energy, window_energy) > kFlatVariance * o.count)) return 0;
  const double covariance = o.product - o.patch * o.window * o.inverse_count;
  return std::clamp(float(covariance) / std::sqrt(float(patch_energy * window_energy)), -1.0f, 1.0f);
}

}  // namespace

struct Ncc::Workspace {
  explicit Workspace(double coverage) : min_coverage(coverage) {}

  Status match(const GridImage& patch, const GridImage& window, GridImage& surface);
  void take_patch(const GridImage& patch);
  void find_corners(const cv::Mat& mask, cv::Size size);
  void take_window(const GridImage& window);
  void correlate_products(const GridImage& window);
  template <class Sum>
  bool fill(const GridImage& window, WindowSums<Sum>& sums, GridImage& surface);

  double min_coverage;
  cv::Size positions;
  Correlator correlator;
  std::vector<Corner> plus, minus;  ///< where the second difference of the patch's mask is positive, negative
  double patch_count = 0, patch_energy = 0, window_offset = 0;
  cv::Mat patch_zero_mean, window_zero_mean;  ///< CV_32F, 0 where not valid
  cv::Mat patch_spectrum;                     ///< as cv::dft packs it
  cv::Mat product, patch_sum, patch_squares;  ///< CV_32F over all positions; the latter two for masked windows only
  cv::Mat patch_buffer, window_buffer, mask_buffer, squares_buffer;
  WindowSums<uint32_t> sums32;
  WindowSums<uint64_t> sums64;
};

/// The patch with its mean taken off, which keeps the spectrum free of a large constant.
void Ncc::Workspace::take_patch(const GridImage& patch) {
  const cv::Mat& mask = patch.valid;
  patch_count = mask.empty() ? double(patch.pixels.total()) : cv::countNonZero(mask);
  patch_zero_mean = shaped(patch_buffer, patch.pixels.size(), CV_32F);
  patch.pixels.convertTo(patch_zero_mean, CV_32F, 1, -cv::mean(patch.pixels, mask)[0]);
  if (!mask.empty()) patch_zero_mean.setTo(0, mask == 0);
  patch_energy = patch_zero_mean.dot(patch_zero_mean);
  find_corners(mask, patch.pixels.size());
}

void Ncc::Workspace::find_corners(const cv::Mat& mask, cv::Size size) {
  if (mask.empty()) {
    plus = {{0, 0}, {size.height, size.width}};
    minus = {{0, size.width}, {size.height, 0}};
    return;
  }
  plus.clear();
  minus.clear();
  for (int y = 0; y <= size.height; ++y) {
    for (int x = 0; x <= size.width; ++x) {
      const int corner =
          valid_at(mask, y, x) - valid_at(mask, y, x - 1) - valid_at(mask, y - 1, x) + valid_at(mask, y - 1, x - 1);
      std::vector<Corner>& list = corner > 0 ? plus : minus;
      list.insert(list.end(), size_t(std::abs(corner)), {y, x});
    }
  }
}

void Ncc::Workspace::take_window(const GridImage& window) {
  window_offset = cv::mean(window.pixels, window.valid)[0];
  window_zero_mean = shaped(window_buffer, window.pixels.size(), CV_32F);
  window.pixels.convertTo(window_zero_mean, CV_32F, 1, -window_offset);
  if (!window.valid.empty()) window_zero_mean.setTo(0, window.valid == 0);
}

/// The correlations with gray values of the patch, by FFT.
void Ncc::Workspace::correlate_products(const GridImage& window) {
  patch_spectrum = correlator.spectrum(patch_zero_mean, 0);
  product = correlator.correlate({{correlator.spectrum(window_zero_mean, 1), patch_spectrum}}, 2);
  if (window.valid.empty()) return;
  cv::Mat mask = shaped(mask_buffer, window.valid.size(), CV_32F),
          squares = shaped(squares_buffer, patch_zero_mean.size(), CV_32F);
  cv::Mat(window.valid != 0).convertTo(mask, CV_32F, 1.0 / 255);
  cv::multiply(patch_zero_mean, patch_zero_mean, squares);
  const cv::Mat mask_spectrum = correlator.spectrum(mask, 3);
  patch_sum = correlator.correlate({{mask_spectrum, patch_spectrum}}, 4);
  patch_squares = correlator.correlate({{mask_spectrum, correlator.spectrum(squares, 1)}}, 5);
}

/// Returns whether any position is valid.
template <class Sum>
bool Ncc::Workspace::fill(const GridImage& window, WindowSums<Sum>& sums, GridImage& surface) {
  const bool masked = !window.valid.empty();
  const auto gray = [&](int y, int x) {
    return masked && !window.valid.ptr<uint8_t>(y)[x] ? 0 : int(window.pixels.ptr<uint8_t>(y)[x]) - kGrayOffset;
  };
  sums.gray.build(window.pixels.size(), gray);
  sums.squares.build(window.pixels.size(), [&](int y, int x) { return gray(y, x) * gray(y, x); });
  if (masked)
    sums.count.build(window.pixels.size(), [&](int y, int x) { return window.valid.ptr<uint8_t>(y)[x] != 0; });

  using Signed = std::make_signed_t<Sum>;
  const double shift = kGrayOffset - window_offset;  // the FFT took off the mean, the integers took off kGrayOffset
  const double min_count = std::max(1.0, min_coverage * patch_count);
  bool any = false;
  for (int y = 0; y < positions.height; ++y) {
    const Sum* grays = sums.gray.row(y, positions.width, plus, minus);
    const Sum* squares = sums.squares.row(y, positions.width, plus, minus);
    const Sum* counts = masked ? sums.count.row(y, positions.width, plus, minus) : nullptr;
    const float* products = product.ptr<float>(y);
    float* out = surface.pixels.ptr<float>(y);
    uint8_t* valid = surface.valid.ptr<uint8_t>(y);
    for (int x = 0; x < positions.width; ++x) {
      Overlap o{patch_count, 1 / patch_count, 0, 0, 0, patch_energy, products[x]};
      if (masked) o.count = double(counts[x]);
      valid[x] = o.count >= min_count ? 255 : 0;
      out[x] = 0;
      if (!valid[x]) continue;
      const double g = double(Signed(grays[x]));
      o.window = g + shift * o.count;
      o.window_squares = double(squares[x]) + shift * (2 * g + shift * o.count);
      if (masked) {
        o.inverse_count = 1 / o.count;
        o.patch = patch_sum.at<float>(y, x);
        o.patch_squares = patch_squares.at<float>(y, x);
      }
      out[x] = coefficient(o);
      any = true;
    }
  }
  return any;
}

Status Ncc::Workspace::match(const GridImage& patch, const GridImage& window, GridImage& surface) {
  correlator.resize(window.pixels.size(), patch.pixels.size());
  positions = correlator.positions();
  surface.pixels.create(positions, CV_32F);
  surface.valid.create(positions, CV_8U);
  surface.gsd_m = window.gsd_m;
  surface.west_m = window.west_m - patch.west_m - 0.5 * window.gsd_m;
  surface.north_m = window.north_m - patch.north_m + 0.5 * window.gsd_m;
  take_patch(patch);
  if (!(patch_energy > kFlatVariance * patch_count)) {
    surface.pixels.setTo(0);
    surface.valid.setTo(255);
    return Status::kNoTexture;
  }
  take_window(window);
  correlate_products(window);
  const bool any = patch_count <= kMaxCount32 ? fill(window, sums32, surface) : fill(window, sums64, surface);
  return any ? Status::kOk : Status::kOutsideMap;
}

Ncc::Ncc(double min_coverage) : workspace_(std::make_unique<Workspace>(min_coverage)) {}
Ncc::~Ncc() = default;
Ncc::Ncc(Ncc&&) noexcept = default;
Ncc& Ncc::operator=(Ncc&&) noexcept = default;

/// By Parseval from the power spectrum. Its packed form holds one of each conjugate pair (imaginary parts are 0), and
/// the up to four frequencies without a partner are the mean, which is 0, and the finest ones, which hold next to
/// nothing.
double Ncc::independent_pixels() const {
  const Workspace& w = *workspace_;
  if (w.patch_spectrum.empty() || !(w.patch_energy > 0)) return 0;
  try {
    cv::Mat power;
    cv::mulSpectrums(w.patch_spectrum, w.patch_spectrum, power, 0, true);
    const double sum = 2 * cv::sum(power)[0], squares = 2 * power.dot(power);
    return 2 * w.patch_count * sum * sum / (squares * double(power.total()));
  } catch (...) {
    return 0;
  }
}

Status Ncc::match(const GridImage& patch, const GridImage& window, GridImage& surface) {
  if (!usable(patch) || !usable(window)) return Status::kBadImage;
  if (patch.pixels.rows > window.pixels.rows || patch.pixels.cols > window.pixels.cols)
    return Status::kTemplateTooLarge;
  try {
    return workspace_->match(patch, window, surface);
  } catch (...) {
    return Status::kInternal;
  }
}

}  // namespace landfix::nav
