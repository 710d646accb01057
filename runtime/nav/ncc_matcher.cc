// Normalized cross-correlation of gray values [Conte 2009 §5.7] or of gradient magnitudes [§7.3].
#include "runtime/features/edge.h"
#include "runtime/features/gray.h"
#include "runtime/features/shade.h"
#include "runtime/nav/matcher.h"
#include "runtime/nav/ncc.h"

namespace landfix::nav {
namespace {

using features::GridImage;

class NccMatcher final : public Matcher {
 public:
  NccMatcher(Method method, double min_coverage) : method_(method), ncc_(min_coverage) {}

  Status set_patch(const GridImage& image, int rim_px) override try {
    GridImage whole = image;
    whole.pixels = features::gray_from_rgb(image.pixels);
    if (method_ == Method::kEdge) {
      cv::Mat magnitude;
      features::edge(whole.pixels, whole.valid, magnitude);
      whole.pixels = magnitude;
      whole.valid = magnitude != 0;
    } else {
      features::lift_shade(whole);
    }
    patch_ = without_rim(whole, rim_px);
    return patch_.valid.empty() || cv::countNonZero(patch_.valid) > 0 ? Status::kOk : Status::kNoTexture;
  } catch (...) {
    return Status::kBadImage;
  }

  Status set_window(const GridImage& window) override try {
    window_ = window;
    if (method_ == Method::kGray) {
      window_.pixels = window.pixels.clone();
      features::lift_shade(window_);
    }
    return Status::kOk;
  } catch (...) {
    return Status::kBadImage;
  }

  Status match(const Similarity& similarity, GridImage& surface) override try {
    if (similarity.is_identity()) return ncc_.match(patch_, window_, surface);
    apply(similarity, patch_, turned_);
    return ncc_.match(turned_, window_, surface);
  } catch (...) {
    return Status::kInternal;
  }

  double independent_pixels() const override { return ncc_.independent_pixels(); }

 private:
  Method method_;
  Ncc ncc_;
  GridImage patch_, turned_, window_;
};

}  // namespace

std::unique_ptr<Matcher> make_ncc_matcher(Method method, double min_coverage) {
  return std::make_unique<NccMatcher>(method, min_coverage);
}

}  // namespace landfix::nav
