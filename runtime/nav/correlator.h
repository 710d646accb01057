// Correlation of images by Fourier transform, for all matchers; buffers are kept between calls.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

namespace landfix::nav {

/// A matrix of this shape on a buffer that only ever grows.
cv::Mat shaped(cv::Mat& buffer, cv::Size size, int type);

/// Correlates patches with a window of one size. Circular transforms do: no position of interest wraps around.
class Correlator {
 public:
  /// Sets the sizes; spectra made for other sizes are void.
  void resize(cv::Size window, cv::Size patch);

  /// Positions of the patch inside the window.
  cv::Size positions() const { return positions_; }
  cv::Size dft_size() const { return dft_size_; }

  /// Spectrum (as cv::dft packs it) of a CV_32FC1 image no larger than the window, in the buffer `slot`.
  cv::Mat spectrum(const cv::Mat& image, size_t slot);

  /// Σ over the pairs (window, patch) of their correlation at all positions, CV_32FC1, in the buffer `slot`; rows from
  /// `positions().height` on are unspecified.
  cv::Mat correlate(const std::vector<std::pair<cv::Mat, cv::Mat>>& spectra, size_t slot);

 private:
  static constexpr size_t kSlots = 12;
  cv::Size dft_size_, positions_;
  std::array<cv::Mat, kSlots> buffers_;
  cv::Mat product_;
};

}  // namespace landfix::nav
