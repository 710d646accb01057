#include "runtime/nav/heading.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace landfix::nav {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kAngles = 360;                 ///< of Hough space over half a turn
constexpr double kAngleRad = kPi / kAngles;  ///< from one to the next
constexpr int kVoteReach = 60;               ///< in angles: a contour pixel votes up to 30° off its gradient,
constexpr double kVoteSigma = 24;            ///< with a weight of this width
constexpr double kLongestWave = 0.25;        ///< of the diagonal: slower is the outline of the view, not its lines
constexpr double kShortestWavePx = 6;        ///< faster is the raggedness of contours
constexpr double kPeakSigma = 1;             ///< in angles: no peak of agreement is sharper
constexpr double kBackgroundSigma = 12;  ///< in angles: what is broader than this is common direction, not agreement
constexpr int kLobe = 12;                ///< in angles: what belongs to a peak
constexpr double kSigmaFactor = 2;       ///< the images differ by more than the noise beside the peak shows
constexpr double kLeastSigmaRad = 0.05 * kPi / 180;  ///< a tenth of an angle: what interpolation of the peak may cost

int wrapped(int angle) { return ((angle % kAngles) + kAngles) % kAngles; }

/// Hough space of the contours: [angle of the normal][ρ + length / 2], origin in the middle of the image.
cv::Mat_<float> hough_of(const cv::Mat& mask, const cv::Mat& direction, int length) {
  std::array<double, kAngles> cosine, sine;
  for (int a = 0; a < kAngles; ++a)
    cosine[size_t(a)] = std::cos(a * kAngleRad), sine[size_t(a)] = std::sin(a * kAngleRad);
  std::array<float, 2 * kVoteReach + 1> weight;
  for (int i = -kVoteReach; i <= kVoteReach; ++i)
    weight[size_t(i + kVoteReach)] = float(std::exp(-0.5 * i * i / (kVoteSigma * kVoteSigma)));
  cv::Mat_<float> hough = cv::Mat_<float>::zeros(kAngles, length);
  for (int row = 0; row < mask.rows; ++row) {
    const double y = row - 0.5 * (mask.rows - 1);
    for (int column = 0; column < mask.cols; ++column) {
      if (!mask.at<uint8_t>(row, column)) continue;
      const double x = column - 0.5 * (mask.cols - 1);
      const int nearest = int(std::lround(direction.at<float>(row, column) / kAngleRad));
      for (int i = -kVoteReach; i <= kVoteReach; ++i) {
        const int a = wrapped(nearest + i);
        const double rho = x * cosine[size_t(a)] + y * sine[size_t(a)] + 0.5 * length;
        const int bin = int(rho);
        const float w = weight[size_t(i + kVoteReach)], share = float(rho - bin);
        hough(a, bin) += w * (1 - share);
        hough(a, bin + 1) += w * share;
      }
    }
  }
  return hough;
}

/// Magnitude of Hough space's Fourier transform along ρ, [angle][frequency] between the two limiting waves. Every
/// frequency is brought to mean 0 and variance 1 over the angles, so that no part of the spectrum outvotes the others.
cv::Mat_<float> spectrum_of(const cv::Mat_<float>& hough, double diagonal_px) {
  cv::Mat transform, parts[2], magnitude;
  cv::dft(hough, transform, cv::DFT_ROWS | cv::DFT_COMPLEX_OUTPUT);
  const int low = int(std::ceil(hough.cols / (kLongestWave * diagonal_px)));
  const int high = std::max(int(hough.cols / kShortestWavePx), low + 1);
  cv::split(transform.colRange(low, high), parts);
  cv::magnitude(parts[0], parts[1], magnitude);
  for (int k = 0; k < magnitude.cols; ++k) {
    cv::Scalar mean, deviation;
    cv::meanStdDev(magnitude.col(k), mean, deviation);
    magnitude.col(k) -= mean[0];
    if (deviation[0] > 0) magnitude.col(k) *= 1 / deviation[0];
  }
  return magnitude;
}

/// How well two spectra agree when the first is turned by −reach to reach angles.
cv::Mat_<double> agreement(const cv::Mat_<float>& patch, const cv::Mat_<float>& map, int reach) {
  cv::Mat_<double> score(1, 2 * reach + 1);
  for (int turn = -reach; turn <= reach; ++turn) {
    double sum = 0;
    for (int a = 0; a < kAngles; ++a) sum += patch.row(a).dot(map.row(wrapped(a + turn)));
    score(turn + reach) = sum / (double(kAngles) * patch.cols);
  }
  return score;
}

/// Leaves what is as sharp as true agreement is: that both images prefer some directions shows as a broad hump.
cv::Mat_<double> sharpened(const cv::Mat_<double>& score) {
  cv::Mat fine, broad;
  cv::GaussianBlur(score, fine, {0, 1}, kPeakSigma, kPeakSigma, cv::BORDER_REPLICATE);
  cv::GaussianBlur(score, broad, {0, 1}, kBackgroundSigma, kBackgroundSigma, cv::BORDER_REPLICATE);
  return fine - broad;
}

/// Reads the highest peak within ±reach angles of the middle; quality 0 if there is none.
HeadingOffset read_peak(const cv::Mat_<double>& score, int reach) {
  const int middle = score.cols / 2;
  int best = -1;
  for (int i = middle - reach; i <= middle + reach; ++i)
    if (score(i) > score(i - 1) && score(i) >= score(i + 1) && (best < 0 || score(i) > score(best))) best = i;
  if (best < 0 || !(score(best) > 0)) return {};
  double sum = 0, squares = 0, slopes = 0, rival = 0;
  int count = 0;
  for (int i = middle - reach; i <= middle + reach; ++i) {
    if (std::abs(i - best) <= kLobe) continue;
    const double slope = 0.5 * (score(i + 1) - score(i - 1));
    sum += score(i);
    squares += score(i) * score(i);
    slopes += slope * slope;
    rival = std::max(rival, score(i));
    ++count;
  }
  const double curvature = 2 * score(best) - score(best - 1) - score(best + 1);
  const double variance = squares / count - (sum / count) * (sum / count);
  if (!(curvature > 0 && variance > 0)) return {};
  HeadingOffset r;
  r.offset_rad = (best - middle + 0.5 * (score(best + 1) - score(best - 1)) / curvature) * kAngleRad;
  // The noise that the score shows elsewhere, as a slope, moves a peak by slope over curvature.
  r.sigma_rad = std::hypot(kSigmaFactor * std::sqrt(slopes / count) / curvature * kAngleRad, kLeastSigmaRad);
  r.quality = (score(best) - sum / count) / std::sqrt(variance);
  r.gap = 1 - std::min(rival / score(best), 1.0);
  return r;
}

bool usable(const features::GridImage& image) {
  return !image.pixels.empty() && image.pixels.type() == CV_8UC1 &&
         (image.valid.empty() || (image.valid.type() == CV_8UC1 && image.valid.size() == image.pixels.size()));
}

Status align_checked(const features::GridImage& patch, const features::GridImage& map, HeadingOffset& result,
                     const HeadingOptions& options) {
  const double diagonal_px =
      std::max(std::hypot(patch.pixels.cols, patch.pixels.rows), std::hypot(map.pixels.cols, map.pixels.rows));
  const int length = cv::getOptimalDFTSize(int(diagonal_px) + 4);
  std::vector<cv::Mat_<float>> spectra;
  for (const features::GridImage* image : {&patch, &map}) {
    cv::Mat mask, known, direction;
    features::contours(image->pixels, image->valid, options.contours, mask, known, direction);
    if (cv::countNonZero(mask) < options.min_contour_px) return Status::kNoTexture;
    spectra.push_back(spectrum_of(hough_of(mask, direction, length), diagonal_px));
  }
  const int reach = int(std::lround(options.max_offset_rad / kAngleRad));
  const int margin = int(2 * kBackgroundSigma);  // so that the ends are sharpened as the middle is
  result = read_peak(sharpened(agreement(spectra[0], spectra[1], reach + margin)), reach);
  return result.quality >= options.min_quality ? Status::kOk : Status::kNoTexture;
}

}  // namespace

Status align_heading(const features::GridImage& patch, const features::GridImage& map, HeadingOffset& result,
                     const HeadingOptions& options) {
  result = {};
  if (!usable(patch) || !usable(map)) return Status::kBadImage;
  if (!(patch.gsd_m > 0) || patch.gsd_m != map.gsd_m || !(options.max_offset_rad <= 0.5 * kPi) ||
      !(options.max_offset_rad >= 3 * kLobe * kAngleRad) || !std::isfinite(options.min_quality))
    return Status::kBadValue;
  try {
    return align_checked(patch, map, result, options);
  } catch (...) {
    return Status::kInternal;
  }
}

}  // namespace landfix::nav
