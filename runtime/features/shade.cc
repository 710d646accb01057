#include "runtime/features/shade.h"

#include <opencv2/imgproc.hpp>

namespace landfix::features {

void leave_out_shade(GridImage& image, const ShadeOptions& o) {
  CV_Assert(image.pixels.type() == CV_8UC1);
  if (image.gsd_m > o.coarsest_gsd_m) return;
  if (image.valid.empty()) image.valid = cv::Mat(image.pixels.size(), CV_8UC1, cv::Scalar(255));
  const int side = int(o.window_m / image.gsd_m) | 1;
  const cv::Size window(side, side);
  const auto sum = [&](const cv::Mat& of, cv::Mat& out) {
    cv::boxFilter(of, out, CV_32F, window, {-1, -1}, false, cv::BORDER_CONSTANT);
  };
  cv::Mat seen, values, counts;
  cv::bitwise_and(image.pixels, image.valid, seen);  // invalid pixels are 255 or 0 in the mask: they add nothing
  sum(seen, values);
  sum(image.valid, counts);  // 255 for each valid pixel
  cv::Mat gray, shade;
  image.pixels.convertTo(gray, CV_32F);
  // gray < ratio * mean, mean = values / (counts / 255), without dividing
  shade = gray.mul(counts) < values * (255 * o.ratio);
  image.valid.setTo(0, shade);
}

}  // namespace landfix::features
