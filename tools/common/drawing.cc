#include "tools/common/drawing.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "builder/error.h"
#include "tools/common/files.h"
#include "tools/common/grid_image_io.h"

namespace landfix::tools {

double level_to_draw(const std::pair<double, double>& gsd_range_m, double pixel_m) {
  double gsd_m = gsd_range_m.first;
  while (gsd_m > 0 && 2 * gsd_m <= std::min(pixel_m, gsd_range_m.second)) gsd_m *= 2;
  return gsd_m;
}

cv::Mat dimmed(const cv::Mat& gray) {
  cv::Mat out;
  gray.convertTo(out, -1, 0.6, 10);
  cv::cvtColor(out, out, cv::COLOR_GRAY2BGR);
  return out;
}

cv::Point shifted(const cv::Point2d& pixel) {
  return {cvRound(pixel.x * (1 << kShift)), cvRound(pixel.y * (1 << kShift))};
}

EnlargedPicture::EnlargedPicture(const features::GridImage& image, int scale) : image_(image), scale_(scale) {
  cv::resize(picture_of(image), pixels_, {}, scale, scale, cv::INTER_LINEAR);
}

cv::Point EnlargedPicture::at(double east_m, double north_m) const {
  return shifted({(image_.column_of(east_m) + 0.5) * scale_ - 0.5, (image_.row_of(north_m) + 0.5) * scale_ - 0.5});
}

void draw_line(cv::Mat& picture, cv::Point2d a, cv::Point2d b, const cv::Scalar& colour, int thickness) {
  cv::line(picture, shifted(a), shifted(b), colour, thickness, cv::LINE_AA, kShift);
}

void draw_text(cv::Mat& picture, const std::string& text, cv::Point2d at, const TextStyle& style) {
  const cv::Point corner(cvRound(at.x), cvRound(at.y));
  for (const auto& [colour, width] : {std::pair(style.rim, style.rim_width), std::pair(style.colour, 1)})
    cv::putText(picture, text, corner, cv::FONT_HERSHEY_SIMPLEX, style.scale, colour, width, cv::LINE_AA);
}

double round_length(double most) {
  const double decade = std::pow(10, std::floor(std::log10(most)));
  return decade * (most >= 5 * decade ? 5 : most >= 2 * decade ? 2 : 1);
}

void write_picture(const std::string& path, const cv::Mat& picture) {
  write_atomically(path, [&](const std::string& temporary) {
    if (!cv::imwrite(temporary, picture))
      throw Error(ExitCode::kIo, path + ": cannot be written; check free space and permissions");
  });
}

}  // namespace landfix::tools
