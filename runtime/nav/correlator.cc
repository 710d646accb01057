#include "runtime/nav/correlator.h"

namespace landfix::nav {

cv::Mat shaped(cv::Mat& buffer, cv::Size size, int type) {
  const size_t bytes = size_t(size.area()) * CV_ELEM_SIZE(type);
  if (buffer.total() < bytes) buffer.create(1, int(bytes), CV_8U);
  return cv::Mat(size, type, buffer.data);
}

void Correlator::resize(cv::Size window, cv::Size patch) {
  positions_ = window - patch + cv::Size(1, 1);
  dft_size_ = {cv::getOptimalDFTSize(window.width), cv::getOptimalDFTSize(window.height)};
}

cv::Mat Correlator::spectrum(const cv::Mat& image, size_t slot) {
  cv::Mat padded = shaped(buffers_[slot], dft_size_, CV_32F);
  cv::copyMakeBorder(image, padded, 0, dft_size_.height - image.rows, 0, dft_size_.width - image.cols,
                     cv::BORDER_CONSTANT, 0);
  cv::dft(padded, padded, 0, image.rows);
  return padded;
}

cv::Mat Correlator::correlate(const std::vector<std::pair<cv::Mat, cv::Mat>>& spectra, size_t slot) {
  cv::Mat out = shaped(buffers_[slot], dft_size_, CV_32F);
  for (size_t i = 0; i < spectra.size(); ++i) {
    cv::Mat product = i == 0 ? out : shaped(product_, dft_size_, CV_32F);
    cv::mulSpectrums(spectra[i].first, spectra[i].second, product, 0, true);
    if (i > 0) out += product;
  }
  cv::dft(out, out, cv::DFT_INVERSE | cv::DFT_SCALE, positions_.height);
  return out;
}

}  // namespace landfix::nav
