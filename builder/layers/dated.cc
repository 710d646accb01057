#include "builder/layers/dated.h"

#include "builder/layers/window.h"

namespace landfix::layers {

DatedStack dated_orientation(const ingest::Stack& stack, const tiles::PixelRect& rect,
                             const features::OrientationOptions& options) {
  DatedStack out;
  const tiles::PixelRect part = intersection(grown(rect, features::kOrientationHaloPx), stack.rect);
  const tiles::PixelRect common = intersection(rect, stack.rect);
  if (common.width == 0) return out;
  const cv::Rect from = region_of(common, part), to = region_of(common, rect);
  for (const ingest::Epoch& epoch : stack.epochs) {
    cv::Mat ab, valid;
    features::orientation(epoch.bands(region_of(part, stack.rect)), epoch.valid(region_of(part, stack.rect)), options,
                          ab, valid);
    if (cv::countNonZero(valid(from)) == 0) continue;
    features::DatedOrientation date{cv::Mat::zeros(int(rect.height), int(rect.width), CV_32FC2),
                                    cv::Mat::zeros(int(rect.height), int(rect.width), CV_8UC1)};
    ab(from).copyTo(date.ab(to));
    valid(from).copyTo(date.valid(to));
    out.dates.push_back(std::move(date));
    out.epochs.push_back(uint16_t(epoch.index));
  }
  return out;
}

}  // namespace landfix::layers
