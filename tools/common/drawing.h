// What pictures of results over a map share. Colours are in OpenCV's order (blue, green, red).
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <utility>

#include "runtime/features/grid_image.h"

namespace landfix::tools {

/// Of levels that double from the finest to the coarsest, the coarsest one not coarser than a pixel of the picture; 0
/// where there are none ({0, 0}).
double level_to_draw(const std::pair<double, double>& gsd_range_m, double pixel_m);

/// Gray as colours, dimmed: what is drawn on it stands out. `gray`: CV_8UC1. Returns CV_8UC3.
cv::Mat dimmed(const cv::Mat& gray);

/// Anti-aliased, with fractional ends.
void draw_line(cv::Mat& picture, cv::Point2d a, cv::Point2d b, const cv::Scalar& colour, int thickness = 1);

/// Bits of a pixel in the coordinates that OpenCV's drawing takes with this as its `shift`.
inline constexpr int kShift = 4;
cv::Point shifted(const cv::Point2d& pixel);

/// An image (picture_of) enlarged to draw on, which knows where places of the grid lie.
class EnlargedPicture {
 public:
  EnlargedPicture(const features::GridImage& image, int scale);
  cv::Mat& pixels() { return pixels_; }
  cv::Point at(double east_m, double north_m) const;  ///< shifted

 private:
  const features::GridImage& image_;
  int scale_;
  cv::Mat pixels_;
};

/// Letters with a rim, so that they can be read on any ground.
struct TextStyle {
  cv::Scalar colour{255, 255, 255}, rim{0, 0, 0};
  double scale = 0.55;
  int rim_width = 4;  ///< of the pen that draws the rim, pixels
};
/// `at` is the lower left corner.
void draw_text(cv::Mat& picture, const std::string& text, cv::Point2d at, const TextStyle& style = {});

/// The largest of 1, 2 and 5 times a power of ten that is no more than this: lengths of scale bars.
double round_length(double most);

/// Writes an image whole or not at all, in the format of the extension. Throws Error(kIo).
void write_picture(const std::string& path, const cv::Mat& picture);

}  // namespace landfix::tools
