#include "runtime/features/shade.h"

#include <opencv2/imgproc.hpp>

namespace landfix::features {

void lift_shade(GridImage& image, const ShadeOptions& o) {
  CV_Assert(image.pixels.type() == CV_8UC1);
  if (image.gsd_m > o.coarsest_gsd_m) return;
  const int side = int(o.window_m / image.gsd_m) | 1;
  const auto mean_around = [&](const cv::Mat& of, cv::Mat& out) {
    cv::boxFilter(of, out, CV_32F, {side, side}, {-1, -1}, true, cv::BORDER_CONSTANT);
  };
  cv::Mat floor, share, values = image.pixels;
  cv::Mat valid = image.valid.empty() ? cv::Mat(values.size(), CV_8UC1, cv::Scalar(255)) : image.valid;
  if (!image.valid.empty()) {
    values = cv::Mat();
    cv::bitwise_and(image.pixels, valid, values);
  }
  mean_around(values, floor);
  mean_around(valid, share);  // 255 where all pixels around are valid
  cv::divide(floor, share, floor, 255 * o.ratio);
  floor.convertTo(floor, CV_8U);
  cv::max(image.pixels, floor, image.pixels);
}

}  // namespace landfix::features
