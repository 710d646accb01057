// Chamfer matching: how far the camera's contours lie from those of the map (Barrow et al. 1977; distances truncated).
#include <algorithm>
#include <cmath>

#include "runtime/features/contour.h"
#include "runtime/features/gray.h"
#include "runtime/nav/correlator.h"
#include "runtime/nav/matcher.h"

namespace landfix::nav {
namespace {

using features::GridImage;

constexpr int kMinPoints = 32;              ///< fewer contour pixels say nothing
constexpr double kPixelsPerSample = 8;      ///< of a contour, that share one independent distance
constexpr double kLeastMeanDistance = 0.1;  ///< pixels; a window full of contours tells nothing apart

class ContourMatcher final : public Matcher {
 public:
  explicit ContourMatcher(double min_coverage) : min_coverage_(min_coverage) {}

  Status set_patch(const GridImage& image, int rim_px) override try {
    cv::Mat mask, known;
    features::contours(features::gray_from_rgb(image.pixels), image.valid, {}, mask, known);
    GridImage whole = image;
    whole.pixels = mask;
    frame_ = without_rim(whole, rim_px);
    cv::findNonZero(frame_.pixels, points_);
    size_ = {};
    return points_.size() < kMinPoints ? Status::kNoTexture : Status::kOk;
  } catch (...) {
    return Status::kBadImage;
  }

  Status set_window(const GridImage& window) override try {
    if (window.pixels.type() != CV_8UC1) return Status::kBadImage;
    window_ = window;
    size_ = {};  // spectra are made by the next match, which knows both sizes
    window.pixels.convertTo(distance_, CV_32F, 1, -1);
    known_ = cv::Mat();
    mean_distance_ = cv::mean(distance_, window.valid)[0];
    if (!window.valid.empty()) {
      distance_.setTo(0, window.valid == 0);
      window.valid.convertTo(known_, CV_32F, 1.0 / 255);
    }
    return Status::kOk;
  } catch (...) {
    return Status::kInternal;
  }

  Status match(const Similarity& similarity, GridImage& surface) override try {
    const cv::Size patch = frame_.pixels.size(), window = window_.pixels.size();
    if (patch.width > window.width || patch.height > window.height) return Status::kTemplateTooLarge;
    prepare_surface(frame_, window_, surface);
    surface.pixels.setTo(0);
    surface.valid.setTo(255);
    const double count = draw(similarity);
    if (count < kMinPoints || mean_distance_ < kLeastMeanDistance) return Status::kNoTexture;
    if (size_ != window) {
      correlator_.resize(window, patch);
      distance_spectrum_ = correlator_.spectrum(distance_, 0);
      if (!known_.empty()) known_spectrum_ = correlator_.spectrum(known_, 1);
      size_ = window;
    }
    const cv::Mat mask = correlator_.spectrum(mask_, 2);
    const cv::Mat sums = correlator_.correlate({{distance_spectrum_, mask}}, 3);
    const cv::Mat counts = known_.empty() ? cv::Mat() : correlator_.correlate({{known_spectrum_, mask}}, 4);
    return fill(sums, counts, count, surface);
  } catch (...) {
    return Status::kInternal;
  }

  double independent_pixels() const override { return count_ / kPixelsPerSample; }

 private:
  /// Draws the contour's pixels, turned and stretched, into mask_; how many there are.
  double draw(const Similarity& similarity) {
    mask_.create(frame_.pixels.size(), CV_32F);
    mask_.setTo(0);
    const double x0 = frame_.column_of(0), y0 = frame_.row_of(0);
    const double c = similarity.scale * std::cos(similarity.rotation_rad),
                 s = similarity.scale * std::sin(similarity.rotation_rad);
    count_ = 0;
    for (const cv::Point& p : points_) {
      const double dx = p.x - x0, dy = p.y - y0;
      const int x = int(std::lround(x0 + c * dx - s * dy)), y = int(std::lround(y0 + s * dx + c * dy));
      if (x < 0 || y < 0 || x >= mask_.cols || y >= mask_.rows) continue;
      count_ += mask_.at<float>(y, x) == 0;
      mask_.at<float>(y, x) = 1;
    }
    return count_;
  }

  /// 1 where every contour pixel lies on one of the map, 0 where they lie no nearer than anywhere.
  Status fill(const cv::Mat& sums, const cv::Mat& counts, double count, GridImage& surface) const {
    bool any = false;
    for (int y = 0; y < surface.pixels.rows; ++y) {
      const float* sum = sums.ptr<float>(y);
      const float* met = counts.empty() ? nullptr : counts.ptr<float>(y);
      float* out = surface.pixels.ptr<float>(y);
      uint8_t* valid = surface.valid.ptr<uint8_t>(y);
      for (int x = 0; x < surface.pixels.cols; ++x) {
        const double n = met ? met[x] : count;
        valid[x] = n >= std::max(1.0, min_coverage_ * count) ? 255 : 0;
        if (!valid[x]) continue;
        out[x] = float(std::clamp(1 - sum[x] / n / mean_distance_, -1.0, 1.0));
        any = true;
      }
    }
    return any ? Status::kOk : Status::kOutsideMap;
  }

  double min_coverage_;
  Correlator correlator_;
  GridImage frame_, window_;
  std::vector<cv::Point> points_;
  double count_ = 0, mean_distance_ = 0;
  cv::Size size_;
  cv::Mat distance_, known_, mask_, distance_spectrum_, known_spectrum_;
};

}  // namespace

std::unique_ptr<Matcher> make_contour_matcher(double min_coverage) {
  return std::make_unique<ContourMatcher>(min_coverage);
}

}  // namespace landfix::nav
