// Correlation of doubled-angle orientation: the map in five levels, the camera in floats; to choose among similarities,
// both as ternary bit planes.
//
// Normalised by both energies, and no mean is taken off: zero means "no orientation". The camera's orientation is
// sharpened first: a matched filter for noise that is correlated over some pixels, as long edges are, would whiten it
// (Turin 1960), and half of the way there measured best.
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "runtime/features/orientation.h"
#include "runtime/features/orientation_code.h"
#include "runtime/features/vectorized.h"
#include "runtime/kernels/correlate.h"
#include "runtime/nav/correlator.h"
#include "runtime/nav/matcher.h"

namespace landfix::nav {
namespace {

using features::GridImage;

constexpr double kSharpening = 0.5, kSharpeningSigmaPx = 4;
constexpr int kMarginPx = 5;                ///< of the camera's image, for the gradients at its rim
constexpr float kTernaryThreshold = 0.15f;  ///< of the camera's sharpened orientation
constexpr double kLeastEnergy = 0.02;       ///< per pixel of the map, in squared levels: less is featureless
constexpr int kLargePatch = 128;            ///< pixels a side: energies under it may be a thousandth off
constexpr int kDirectPositions = 64;        ///< up to which sums are taken one by one
constexpr double kLeastPatchEnergy = 1e-4;  ///< per pixel of the patch

/// The image with a margin, in which and where it has no data it goes on as the mean of what is near: so that the
/// gradients at its rim count, and the rim itself is no edge.
cv::Mat continued(const GridImage& image) {
  const cv::Size size = image.pixels.size() + cv::Size(2 * kMarginPx, 2 * kMarginPx);
  const cv::Rect inside({kMarginPx, kMarginPx}, image.pixels.size());
  cv::Mat known = cv::Mat::zeros(size, CV_8U), out = cv::Mat::zeros(size, image.pixels.type()), sums, counts;
  if (image.valid.empty())
    known(inside).setTo(255);
  else
    image.valid.copyTo(known(inside));
  image.pixels.copyTo(out(inside), known(inside));
  const cv::Size around(2 * kMarginPx + 1, 2 * kMarginPx + 1);
  cv::boxFilter(out, sums, CV_32F, around, {-1, -1}, false, cv::BORDER_CONSTANT);
  cv::boxFilter(known, counts, CV_32F, around, {-1, -1}, false, cv::BORDER_CONSTANT);
  counts = cv::max(counts / 255, 1);
  std::vector<cv::Mat> channels;
  cv::split(sums, channels);
  for (cv::Mat& channel : channels) channel /= counts;
  cv::merge(channels, sums);
  sums.convertTo(sums, CV_8U);
  sums.copyTo(out, known == 0);
  return out;
}

/// Raises the length of every vector to the power of 3/4: a few strong edges, as a shore, must not outvote all others.
void compress(cv::Mat& ab) {
  float* v = ab.ptr<float>();
  for (size_t i = 0; i < ab.total(); ++i, v += 2) {
    const float squared = v[0] * v[0] + v[1] * v[1];
    if (squared <= 0) continue;
    const float factor = 1 / std::sqrt(std::sqrt(std::sqrt(squared)));
    v[0] *= factor;
    v[1] *= factor;
  }
}

/// Σ of products of two rows.
inline float dot(const float* a, const float* b, int count) {
  constexpr int kLanes = 16;  // of a fixed number, so that the sum is the same on every processor
  float lanes[kLanes] = {}, sum = 0;
  int i = 0;
  for (; i + kLanes <= count; i += kLanes)
    for (int lane = 0; lane < kLanes; ++lane) lanes[lane] += a[i + lane] * b[i + lane];
  for (; i < count; ++i) sum += a[i] * b[i];
  for (const float lane : lanes) sum += lane;
  return sum;
}

/// The same of a patch, for all its positions in a window: CV_32F of as many channels. For few positions.
LANDFIX_VECTORIZED cv::Mat products(const cv::Mat& patch, const cv::Mat& window) {
  cv::Mat_<double> sums = cv::Mat_<double>::zeros(window.size() - patch.size() + cv::Size(1, 1));
  const int channels = patch.channels(), count = patch.cols * channels;
  for (int row = 0; row < patch.rows; ++row)
    for (int y = 0; y < sums.rows; ++y)
      for (int x = 0; x < sums.cols; ++x)
        sums(y, x) += dot(patch.ptr<float>(row), window.ptr<float>(row + y) + x * channels, count);
  cv::Mat out;
  sums.convertTo(out, CV_32F);
  return out;
}

/// −1, 0 and 1 of two channels; how many are not 0.
LANDFIX_VECTORIZED int to_ternary(const float* in, int count, int8_t* out) {
  int energy = 0;
  for (int i = 0; i < count; ++i) {
    out[i] = int8_t((in[i] > kTernaryThreshold) - (in[i] < -kTernaryThreshold));
    energy += out[i] & 1;
  }
  return energy;
}

/// Ternary planes of a two-channel image in a row of buffers.
struct Planes {
  std::vector<uint64_t> words;
  std::array<kernels::PlaneView, 4> views;

  void resize(cv::Size size) {
    const int row_words = kernels::words_for(size.width);
    const size_t plane_words = size_t(row_words) * size_t(size.height);
    words.resize(plane_words * views.size());
    for (size_t i = 0; i < views.size(); ++i)
      views[i] = {words.data() + i * plane_words, size.width, size.height, row_words};
  }
  uint64_t* at(size_t plane) { return const_cast<uint64_t*>(views[plane].words); }

  /// a+, a−, b+, b− of a CV_8SC2 image of −1, 0, 1.
  kernels::Status pack(const cv::Mat& ternary) {
    for (int c = 0; c < 2; ++c) {
      const size_t plane = 2 * size_t(c);
      const kernels::Status s = kernels::pack_ternary(ternary.ptr<int8_t>() + c, ternary.step[0], 2, ternary.cols,
                                                      ternary.rows, at(plane), at(plane + 1), views[plane].row_words);
      if (s != kernels::Status::kOk) return s;
    }
    return kernels::Status::kOk;
  }
};

class OrientationMatcher final : public Matcher {
 public:
  explicit OrientationMatcher(double min_coverage) : min_coverage_(min_coverage) {}

  Status set_patch(const GridImage& image, int rim_px) override try {
    if (image.pixels.depth() != CV_8U || image.pixels.channels() == 2) return Status::kBadImage;
    GridImage whole = image;
    features::orientation(continued(image), {}, {}, whole.pixels, whole.valid);
    whole.pixels = whole.pixels(cv::Rect({kMarginPx, kMarginPx}, image.pixels.size())).clone();
    whole.valid = image.valid.empty() ? cv::Mat(image.pixels.size(), CV_8U, cv::Scalar(255)) : image.valid.clone();
    whole.pixels.setTo(0, whole.valid == 0);  // what the continuation ends with must not be blurred into the patch
    compress(whole.pixels);
    cv::Mat low;
    cv::GaussianBlur(whole.pixels, low, {}, kSharpeningSigmaPx, kSharpeningSigmaPx, cv::BORDER_CONSTANT);
    whole.pixels -= kSharpening * low;
    whole.pixels.setTo(0, whole.valid == 0);
    patch_ = without_rim(whole, rim_px);
    patch_.pixels = patch_.pixels.clone();
    patch_.valid = patch_.valid.clone();
    spectra_size_ = planes_size_ = {};
    placed_.reset();
    const int count = cv::countNonZero(patch_.valid);
    return patch_.pixels.dot(patch_.pixels) > kLeastPatchEnergy * count ? Status::kOk : Status::kNoTexture;
  } catch (...) {
    return Status::kBadImage;
  }

  Status set_window(const GridImage& window) override try {
    if (window.pixels.type() != CV_8SC2) return Status::kBadImage;
    window_ = window;
    if (!window.valid.empty()) {  // whatever stands where there is no data must not vote
      window_.pixels = cv::Mat();
      window.pixels.copyTo(window_.pixels, window.valid);
    }
    spectra_size_ = planes_size_ = {};
    levels_ready_ = false;
    return Status::kOk;
  } catch (...) {
    return Status::kBadImage;
  }

  Status match(const Similarity& similarity, GridImage& surface) override try {
    if (const Status s = place(similarity, surface); s != Status::kOk) return s;
    turned_.valid.convertTo(mask_, CV_32F, 1.0 / 255);
    if (int(surface.pixels.total()) <= kDirectPositions) return match_directly(surface);
    const cv::Size patch = patch_.pixels.size();
    if (spectra_size_ != patch) transform_window(patch);
    std::vector<cv::Mat> channels;
    cv::split(turned_.pixels, channels);
    patch_spectrum_[0] = correlator_.spectrum(channels[0], 4);
    patch_spectrum_[1] = correlator_.spectrum(channels[1], 5);
    has_patch_spectrum_ = true;
    const cv::Mat product = correlator_.correlate(
        {{window_spectrum_[0], patch_spectrum_[0]}, {window_spectrum_[1], patch_spectrum_[1]}}, 7);
    const cv::Mat energy = energy_under_mask();
    cv::Mat met, patch_energy;
    if (!window_.valid.empty()) {
      const cv::Mat mask = correlator_.spectrum(mask_, 6);
      met = correlator_.correlate({{valid_spectrum_, mask}}, 9);
      const cv::Mat squares = channels[0].mul(channels[0]) + channels[1].mul(channels[1]);
      patch_energy = correlator_.correlate({{valid_spectrum_, correlator_.spectrum(squares, 6)}}, 10);
    }
    return fill(product, energy, met, patch_energy, surface);
  } catch (...) {
    return Status::kInternal;
  }

  Status match_fast(const Similarity& similarity, GridImage& surface) override try {
    if (std::max(patch_.pixels.cols, patch_.pixels.rows) > kernels::kMaxPatchSide) return match(similarity, surface);
    if (const Status s = place(similarity, surface); s != Status::kOk) return s;
    if (planes_size_ != window_.pixels.size()) pack_window();
    cv::Mat ternary(turned_.pixels.size(), CV_8SC2);
    const int energy = to_ternary(turned_.pixels.ptr<float>(), int(2 * ternary.total()), ternary.ptr<int8_t>());
    if (energy == 0) return Status::kNoTexture;
    patch_planes_.resize(ternary.size());
    if (patch_planes_.pack(ternary) != kernels::Status::kOk) return Status::kInternal;
    const kernels::Shifts shifts = kernels::all_shifts(window_planes_.views[0], patch_planes_.views[0]);
    sums_.resize(size_t(shifts.width()) * size_t(shifts.height()));
    if (kernels::correlate_ternary(window_planes_.views, patch_planes_.views, shifts, sums_, size_t(shifts.width()),
                                   workspace_) != kernels::Status::kOk)
      return Status::kInternal;
    return fill_fast(double(energy), surface);
  } catch (...) {
    return Status::kInternal;
  }

  /// By Parseval from the power spectra, as Ncc::independent_pixels (Bartlett 1946); two channels of one residual each.
  double independent_pixels() const override try {
    if (turned_.pixels.empty() || turned_energy_ <= 0) return 0;
    std::array<cv::Mat, 2> spectra = patch_spectrum_;
    Correlator correlator;  // owns what its spectra point to
    if (!has_patch_spectrum_) {
      std::vector<cv::Mat> channels;
      cv::split(turned_.pixels, channels);
      correlator.resize(window_.pixels.size(), patch_.pixels.size());
      for (size_t i = 0; i < spectra.size(); ++i) spectra[i] = correlator.spectrum(channels[i], i);
    }
    cv::Mat power, second;
    cv::mulSpectrums(spectra[0], spectra[0], power, 0, true);
    cv::mulSpectrums(spectra[1], spectra[1], second, 0, true);
    power += second;
    const double sum = 2 * cv::sum(power)[0], squares = 2 * power.dot(power);
    return 2 * turned_count_ * sum * sum / (squares * double(power.total()));
  } catch (...) {
    return 0;
  }

 private:
  Status place(const Similarity& similarity, GridImage& surface) {
    const cv::Size patch = patch_.pixels.size(), window = window_.pixels.size();
    if (patch.width > window.width || patch.height > window.height) return Status::kTemplateTooLarge;
    prepare_surface(patch_, window_, surface);
    surface.pixels.setTo(0);
    surface.valid.setTo(255);
    if (!placed_ || *placed_ != similarity) turn(similarity);
    return turned_energy_ > kLeastPatchEnergy * turned_count_ ? Status::kOk : Status::kNoTexture;
  }

  void turn(const Similarity& similarity) {
    apply(similarity, patch_, turned_);
    turned_.pixels.setTo(0, turned_.valid == 0);
    if (similarity.rotation_rad != 0) turn_vectors(2 * similarity.rotation_rad);
    turned_count_ = cv::countNonZero(turned_.valid);
    turned_energy_ = turned_.pixels.dot(turned_.pixels);
    placed_ = similarity;
    has_patch_spectrum_ = false;
  }

  /// Doubled angles turn by twice the rotation.
  void turn_vectors(double angle_rad) {
    const float c = float(std::cos(angle_rad)), s = float(std::sin(angle_rad));
    float* v = turned_.pixels.ptr<float>();
    for (size_t i = 0; i < turned_.pixels.total(); ++i, v += 2) {
      const float a = v[0], b = v[1];
      v[0] = c * a - s * b;
      v[1] = s * a + c * b;
    }
  }

  /// Few positions are quicker one by one than by Fourier transform.
  Status match_directly(GridImage& surface) {
    if (!levels_ready_) {
      window_.pixels.convertTo(window_levels_, CV_32F);
      std::vector<cv::Mat> channels;
      cv::split(window_levels_, channels);
      window_energy_ = channels[0].mul(channels[0]) + channels[1].mul(channels[1]);
      if (!window_.valid.empty()) window_.valid.convertTo(window_known_, CV_32F, 1.0 / 255);
      levels_ready_ = true;
    }
    cv::Mat met, patch_energy;
    if (!window_.valid.empty()) {
      std::vector<cv::Mat> channels;
      cv::split(turned_.pixels, channels);
      met = products(mask_, window_known_);
      patch_energy = products(channels[0].mul(channels[0]) + channels[1].mul(channels[1]), window_known_);
    }
    return fill(products(turned_.pixels, window_levels_), products(mask_, window_energy_), met, patch_energy, surface);
  }

  void transform_window(cv::Size patch) {
    correlator_.resize(window_.pixels.size(), patch);
    std::vector<cv::Mat> channels;
    cv::Mat levels;
    window_.pixels.convertTo(levels, CV_32F);
    cv::split(levels, channels);
    window_spectrum_[0] = correlator_.spectrum(channels[0], 0);
    window_spectrum_[1] = correlator_.spectrum(channels[1], 1);
    energy_step_ = std::min(patch.width, patch.height) >= kLargePatch ? 2 : 1;
    energy_correlator_.resize(halved_size(window_.pixels.size()), halved_size(patch));
    energy_spectrum_ =
        energy_correlator_.spectrum(block_means(channels[0].mul(channels[0]) + channels[1].mul(channels[1])), 0);
    if (!window_.valid.empty()) {
      window_.valid.convertTo(levels, CV_32F, 1.0 / 255);
      valid_spectrum_ = correlator_.spectrum(levels, 3);
    }
    spectra_size_ = patch;
  }

  cv::Size halved_size(cv::Size size) const {
    return {(size.width + energy_step_ - 1) / energy_step_, (size.height + energy_step_ - 1) / energy_step_};
  }
  cv::Mat block_means(const cv::Mat& image) const {
    if (energy_step_ == 1) return image;
    cv::Mat even, out;
    cv::copyMakeBorder(image, even, 0, image.rows % 2, 0, image.cols % 2, cv::BORDER_CONSTANT, 0);
    cv::resize(even, out, even.size() / 2, 0, 0, cv::INTER_AREA);
    return out;
  }

  /// The map's energy under the patch's mask, at all positions. Under a large patch it changes so slowly that means of
  /// 2×2 pixels and every other position tell it, at a quarter of the price.
  cv::Mat energy_under_mask() {
    const cv::Mat mask = energy_correlator_.spectrum(block_means(mask_), 1);
    cv::Mat energy = energy_correlator_.correlate({{energy_spectrum_, mask}}, 2);
    if (energy_step_ == 1) return energy;
    const cv::Mat coarse = 4 * energy(cv::Rect({0, 0}, energy_correlator_.positions()));
    const cv::Matx23d coarse_from_fine(0.5, 0, 0, 0, 0.5, 0);
    cv::warpAffine(coarse, energy, coarse_from_fine, correlator_.positions(), cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                   cv::BORDER_REPLICATE);
    return energy;
  }

  void pack_window() {
    const cv::Size size = window_.pixels.size();
    window_planes_.resize(size);
    cv::Mat signs(size, CV_8SC2), energy(size, CV_32F);
    for (int y = 0; y < size.height; ++y) {
      const int8_t* in = window_.pixels.ptr<int8_t>(y);
      int8_t* s = signs.ptr<int8_t>(y);
      for (int x = 0; x < 2 * size.width; ++x) s[x] = int8_t((in[x] > 0) - (in[x] < 0));
      float* e = energy.ptr<float>(y);
      for (int x = 0; x < size.width; ++x) e[x] = float((in[2 * x] != 0) + (in[2 * x + 1] != 0));
    }
    window_planes_.pack(signs);
    cv::Mat sums;
    cv::integral(energy, sums, CV_64F);
    const cv::Size patch = patch_.pixels.size();
    inverse_norms_.create(size.height - patch.height + 1, size.width - patch.width + 1, CV_32F);
    const double least = kLeastEnergy * double(patch.area());
    for (int y = 0; y < inverse_norms_.rows; ++y) {
      const double *top = sums.ptr<double>(y), *bottom = sums.ptr<double>(y + patch.height);
      float* out = inverse_norms_.ptr<float>(y);
      for (int x = 0; x < inverse_norms_.cols; ++x)
        out[x] =
            float(1 / std::sqrt(std::max(bottom[x + patch.width] - bottom[x] - top[x + patch.width] + top[x], least)));
    }
    planes_size_ = size;
  }

  Status fill(const cv::Mat& product, const cv::Mat& energy, const cv::Mat& met, const cv::Mat& patch_energy,
              GridImage& surface) const {
    bool any = false;
    const double least = kLeastEnergy * turned_count_;
    for (int y = 0; y < surface.pixels.rows; ++y) {
      float* out = surface.pixels.ptr<float>(y);
      uint8_t* valid = surface.valid.ptr<uint8_t>(y);
      const float *products = product.ptr<float>(y), *energies = energy.ptr<float>(y);
      for (int x = 0; x < surface.pixels.cols; ++x) {
        const double count = met.empty() ? turned_count_ : met.at<float>(y, x);
        valid[x] = count >= std::max(1.0, min_coverage_ * turned_count_) ? 255 : 0;
        if (!valid[x]) continue;
        any = true;
        const double own = patch_energy.empty() ? turned_energy_ : patch_energy.at<float>(y, x);
        const double norm = std::max(double(energies[x]), least) * std::max(own, kLeastPatchEnergy * count);
        out[x] = std::clamp(float(products[x] / std::sqrt(norm)), -1.f, 1.f);
      }
    }
    return any ? Status::kOk : Status::kOutsideMap;
  }

  /// Energies of the map over the patch's whole canvas, as a measure of those under its mask.
  Status fill_fast(double patch_energy, GridImage& surface) const {
    const double share = turned_count_ / double(patch_.pixels.size().area());
    const float factor = float(1 / std::sqrt(share * patch_energy));
    for (int y = 0; y < surface.pixels.rows; ++y) {
      const float* norm = inverse_norms_.ptr<float>(y);
      const int32_t* sum = sums_.data() + size_t(y) * size_t(surface.pixels.cols);
      float* out = surface.pixels.ptr<float>(y);
      for (int x = 0; x < surface.pixels.cols; ++x) out[x] = float(sum[x]) * norm[x] * factor;
    }
    return Status::kOk;
  }

  double min_coverage_;
  GridImage patch_, turned_, window_;
  std::optional<Similarity> placed_;  ///< that turned_ shows
  double turned_count_ = 0, turned_energy_ = 0;
  cv::Size spectra_size_, planes_size_;
  Correlator correlator_, energy_correlator_;
  int energy_step_ = 1;  ///< pixels of the window to one of energy_spectrum_
  std::array<cv::Mat, 2> patch_spectrum_;
  bool has_patch_spectrum_ = false;  ///< of turned_
  cv::Mat window_spectrum_[2], energy_spectrum_, valid_spectrum_, mask_, inverse_norms_;
  cv::Mat window_levels_, window_energy_, window_known_;  ///< for few positions
  bool levels_ready_ = false;
  Planes window_planes_, patch_planes_;
  kernels::Workspace workspace_;
  std::vector<int32_t> sums_;
};

}  // namespace

std::unique_ptr<Matcher> make_orientation_matcher(double min_coverage) {
  return std::make_unique<OrientationMatcher>(min_coverage);
}

}  // namespace landfix::nav
