#include "runtime/nav/likelihood.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace landfix::nav {
namespace {

using features::GridImage;

constexpr double kPerfect = 1 - 1e-6;  ///< largest coefficient told from 1: eight bits cannot support more

Status check(const GridImage& surface) {
  if (surface.pixels.empty() || surface.pixels.type() != CV_32F) return Status::kBadImage;
  if (surface.valid.type() != CV_8U || surface.valid.size() != surface.pixels.size()) return Status::kBadImage;
  if (!(surface.gsd_m > 0)) return Status::kBadValue;
  return cv::checkRange(surface.pixels) ? Status::kOk : Status::kNotFinite;
}

Status check(const LikelihoodOptions& o) {
  for (double v : {o.independent_pixels, o.position_sigma_m, o.outlier_probability})
    if (!std::isfinite(v)) return Status::kNotFinite;
  const bool good =
      o.independent_pixels >= 0 && o.position_sigma_m >= 0 && o.outlier_probability > 0 && o.outlier_probability <= 1;
  return good ? Status::kOk : Status::kBadValue;
}

/// The concentrated likelihood, scaled so that its largest value is 1; 0 where not valid.
void concentrated(const GridImage& surface, double independent_pixels, cv::Mat& out) {
  const auto log_likelihood = [&](float c) {
    const double r = std::clamp(double(c), 0.0, kPerfect);
    return -0.5 * independent_pixels * std::log1p(-r * r);
  };
  double highest = -1;
  cv::minMaxLoc(surface.pixels, nullptr, &highest, nullptr, nullptr, surface.valid);
  const double top = log_likelihood(float(highest));
  out.create(surface.pixels.size(), CV_32F);
  for (int y = 0; y < out.rows; ++y) {
    const float* c = surface.pixels.ptr<float>(y);
    const uint8_t* valid = surface.valid.ptr<uint8_t>(y);
    float* l = out.ptr<float>(y);
    for (int x = 0; x < out.cols; ++x) l[x] = valid[x] ? float(std::exp(log_likelihood(c[x]) - top)) : 0.f;
  }
}

/// Gaussian mean over the valid neighbours, so that a flat image stays flat up to its edges. `image` is 0 where not
/// valid.
void blur(const cv::Mat& valid, double sigma_px, cv::Mat& image) {
  sigma_px = std::min(sigma_px, double(std::max(image.rows, image.cols)));
  if (sigma_px < 0.1) return;
  cv::Mat share;
  valid.convertTo(share, CV_32F, 1.0 / 255);
  const int size = 2 * int(std::ceil(4 * sigma_px)) + 1;
  for (cv::Mat* m : {&image, &share}) cv::GaussianBlur(*m, *m, {size, size}, sigma_px, sigma_px, cv::BORDER_CONSTANT);
  cv::divide(image, share, image);
  image.setTo(0, valid == 0);
}

/// Offset of the top of a parabola through three neighbours from the middle one, which is the highest.
double parabola_top(double left, double middle, double right) {
  const double curvature = left - 2 * middle + right;
  return curvature < 0 ? std::clamp(0.5 * (left - right) / curvature, -0.5, 0.5) : 0;
}

/// Highest local maximum farther than `radius` pixels from `top`; −1 if there is none.
double highest_rival(const GridImage& surface, cv::Point top, int radius) {
  cv::Mat around, rivals;
  cv::dilate(surface.pixels, around, cv::Mat());
  rivals = (surface.pixels >= around) & surface.valid;
  cv::circle(rivals, top, radius, 0, cv::FILLED);
  double rival = -1;
  if (cv::countNonZero(rivals)) cv::minMaxLoc(surface.pixels, nullptr, &rival, nullptr, nullptr, rivals);
  return rival;
}

}  // namespace

Status likelihood_from_ncc(const GridImage& surface, const LikelihoodOptions& options, Likelihood& likelihood) {
  if (const Status status = check(surface); status != Status::kOk) return status;
  if (const Status status = check(options); status != Status::kOk) return status;
  try {
    if (cv::countNonZero(surface.valid) == 0) return Status::kOutsideMap;
    GridImage& out = likelihood.values;
    out.west_m = surface.west_m;
    out.north_m = surface.north_m;
    out.gsd_m = surface.gsd_m;
    concentrated(surface, options.independent_pixels, out.pixels);
    blur(surface.valid, options.position_sigma_m / surface.gsd_m, out.pixels);
    const double gain = (1 - options.outlier_probability) / cv::mean(out.pixels, surface.valid)[0];
    out.pixels.convertTo(out.pixels, CV_32F, gain, options.outlier_probability);
    out.pixels.setTo(1, surface.valid == 0);
    surface.valid.copyTo(out.valid);
    likelihood.outside = options.outlier_probability;
    return Status::kOk;
  } catch (...) {
    return Status::kInternal;
  }
}

Status temper(double exponent, Likelihood& likelihood) {
  if (!(exponent >= 0 && exponent <= 1)) return Status::kBadValue;
  try {
    cv::pow(likelihood.values.pixels, exponent, likelihood.values.pixels);
    likelihood.outside = std::pow(likelihood.outside, exponent);
    return Status::kOk;
  } catch (...) {
    return Status::kInternal;
  }
}

std::array<double, 4> covariance_m2(const Likelihood& likelihood) {
  const cv::Mat& values = likelihood.values.pixels;
  double sum = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
  for (int y = 0; y < values.rows; ++y) {
    const float* p = values.ptr<float>(y);
    for (int x = 0; x < values.cols; ++x) {
      const double w = std::max(p[x] - likelihood.outside, 0.0);
      sum += w;
      sx += w * x;
      sy += w * y;
      sxx += w * x * x;
      sxy += w * x * y;
      syy += w * y * y;
    }
  }
  const double mx = sx / sum, my = sy / sum, g2 = likelihood.values.gsd_m * likelihood.values.gsd_m;
  const double en = -(sxy / sum - mx * my) * g2;  // rows run south
  return {(sxx / sum - mx * mx) * g2, en, en, (syy / sum - my * my) * g2};
}

Status find_peak(const GridImage& surface, int main_lobe_px, Peak& peak) {
  if (const Status status = check(surface); status != Status::kOk) return status;
  try {
    if (cv::countNonZero(surface.valid) == 0) return Status::kOutsideMap;
    const cv::Mat& c = surface.pixels;
    cv::Point top;
    cv::minMaxLoc(c, nullptr, &peak.value, nullptr, &top, surface.valid);
    const auto at = [&](int y, int x) { return double(c.at<float>(y, x)); };
    double column = top.x, row = top.y;
    if (top.x > 0 && top.x + 1 < c.cols) column += parabola_top(at(top.y, top.x - 1), peak.value, at(top.y, top.x + 1));
    if (top.y > 0 && top.y + 1 < c.rows) row += parabola_top(at(top.y - 1, top.x), peak.value, at(top.y + 1, top.x));
    peak.east_m = surface.west_m + (column + 0.5) * surface.gsd_m;
    peak.north_m = surface.north_m - (row + 0.5) * surface.gsd_m;
    peak.gap = peak.value - highest_rival(surface, top, main_lobe_px);
    return Status::kOk;
  } catch (...) {
    return Status::kInternal;
  }
}

}  // namespace landfix::nav
