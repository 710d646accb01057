#include "tools/eval/texture.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace landfix::eval {
namespace {

constexpr int kBinWidth = 8;       // gray levels
constexpr float kEdge = 60;        // of Sobel's operator
constexpr double kSobelScale = 8;  // it answers so much to a slope of one gray level per pixel

double entropy_of(const cv::Mat& gray) {
  std::array<int, 256 / kBinWidth> counts{};
  for (int y = 0; y < gray.rows; ++y)
    for (int x = 0; x < gray.cols; ++x) ++counts[gray.at<uint8_t>(y, x) / kBinWidth];
  double entropy = 0;
  for (const int count : counts)
    if (count > 0) entropy -= count / double(gray.total()) * std::log2(count / double(gray.total()));
  return entropy;
}

}  // namespace

std::array<double, kTextures> textures_of(const cv::Mat& gray) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(gray, mean, deviation);
  cv::Mat dx, dy, length;
  cv::Sobel(gray, dx, CV_32F, 1, 0, 3, 1, 0, cv::BORDER_REPLICATE);
  cv::Sobel(gray, dy, CV_32F, 0, 1, 3, 1, 0, cv::BORDER_REPLICATE);
  cv::magnitude(dx, dy, length);
  const double count = double(gray.total()), scale = kSobelScale * kSobelScale * count;
  const double xx = dx.dot(dx) / scale, xy = dx.dot(dy) / scale, yy = dy.dot(dy) / scale;
  return {entropy_of(gray), deviation[0], cv::countNonZero(length > kEdge) / count,
          (xx + yy) / 2 - std::hypot((xx - yy) / 2, xy)};
}

}  // namespace landfix::eval
