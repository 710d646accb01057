// A picture of the map to draw results on, in colours that the colour-blind can tell apart.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "builder/ingest/bounds.h"
#include "runtime/nav/map_source.h"
#include "tools/common/drawing.h"

namespace landfix::eval {

// Okabe and Ito (2008), in OpenCV's order (blue, green, red).
inline const cv::Scalar kBlue(233, 180, 86), kVermilion(0, 94, 213), kYellow(66, 228, 240), kGreen(115, 158, 0),
    kPurple(167, 121, 204), kPale(200, 200, 200), kInk(255, 255, 255);

/// The map's gray, dimmed, with grid coordinates to draw by; dark where the map has nothing.
class MapPicture {
 public:
  /// `bounds` fills a picture whose longer side has `size_px` pixels.
  MapPicture(const nav::MapSource& map, const ingest::GridBounds& bounds, int size_px);

  /// Pixel of a position; pixel (0, 0) is the centre of the north-western pixel.
  cv::Point2d at(double east_m, double north_m) const {
    return {(east_m - bounds_.west_m) * px_per_m_ - 0.5, (bounds_.north_m - north_m) * px_per_m_ - 0.5};
  }
  double px_per_m() const { return px_per_m_; }
  const ingest::GridBounds& bounds() const { return bounds_; }
  cv::Mat& pixels() { return pixels_; }  ///< CV_8UC3, blue, green, red

 private:
  ingest::GridBounds bounds_;
  double px_per_m_;
  cv::Mat pixels_;
};

using tools::draw_line;
/// The same in dashes.
void draw_dashed(cv::Mat& picture, cv::Point2d a, cv::Point2d b, const cv::Scalar& colour, int thickness = 1);
void draw_dot(cv::Mat& picture, cv::Point2d at, double radius_px, const cv::Scalar& colour);
/// A diagonal cross.
void draw_cross(cv::Mat& picture, cv::Point2d at, double radius_px, const cv::Scalar& colour, int thickness = 2);
/// Text with a dark rim; `at` is its lower left corner.
void draw_text(cv::Mat& picture, const std::string& text, cv::Point2d at, const cv::Scalar& colour = kInk,
               double scale = 0.45);

/// A band with a horizontal bar of a round length in the lower right corner.
void draw_scale_bar(cv::Mat& picture, double px_per_m);

/// One mark of a legend.
struct LegendEntry {
  enum class Mark { kDot, kCross, kLine, kDashed } mark;
  cv::Scalar colour;
  std::string text;
};
/// The picture with a legend below it, wrapped to its width.
cv::Mat with_legend(const cv::Mat& picture, const std::vector<LegendEntry>& entries);

/// Pictures of equal size beside and below each other.
cv::Mat tiled(const std::vector<cv::Mat>& pictures, int columns);

}  // namespace landfix::eval
