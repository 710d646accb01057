#include "tools/eval/map_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace landfix::eval {
namespace {

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
const cv::Scalar kBackground(24, 24, 24);

void draw_mark(cv::Mat& picture, const LegendEntry& entry, cv::Point2d at) {
  const cv::Point2d half(9, 0);
  switch (entry.mark) {
    case LegendEntry::Mark::kDot:
      return draw_dot(picture, at, 4, entry.colour);
    case LegendEntry::Mark::kCross:
      return draw_cross(picture, at, 5, entry.colour);
    case LegendEntry::Mark::kLine:
      return draw_line(picture, at - half, at + half, entry.colour, 2);
    case LegendEntry::Mark::kDashed:
      return draw_dashed(picture, at - half, at + half, entry.colour, 2);
  }
}

}  // namespace

MapPicture::MapPicture(const nav::MapSource& map, const ingest::GridBounds& bounds, int size_px) : bounds_(bounds) {
  const double width_m = bounds.east_m - bounds.west_m, height_m = bounds.north_m - bounds.south_m;
  px_per_m_ = size_px / std::max(width_m, height_m);
  const cv::Size size(std::max(1, cvRound(width_m * px_per_m_)), std::max(1, cvRound(height_m * px_per_m_)));
  pixels_ = cv::Mat(size, CV_8UC3, kBackground);
  const std::pair<double, double> levels = map.gsd_range_m(nav::MapLayer::kGray);
  if (levels.first <= 0) return;
  const double gsd = tools::level_to_draw(levels, 1 / px_per_m_);
  features::GridImage window;
  if (map.read(nav::MapLayer::kGray, bounds.west_m, bounds.south_m, bounds.east_m, bounds.north_m, gsd, window) !=
      nav::Status::kOk)
    return;
  cv::Mat shown = tools::dimmed(window.pixels);
  if (!window.valid.empty()) shown.setTo(kBackground, window.valid == 0);
  const double scale = gsd * px_per_m_;
  const cv::Point2d corner = at(window.west_m, window.north_m);
  const cv::Matx23d place(scale, 0, corner.x + 0.5 * scale, 0, scale, corner.y + 0.5 * scale);
  cv::warpAffine(shown, pixels_, place, size, cv::INTER_LINEAR, cv::BORDER_CONSTANT, kBackground);
}

void draw_dashed(cv::Mat& picture, cv::Point2d a, cv::Point2d b, const cv::Scalar& colour, int thickness) {
  constexpr double kDashPx = 5;
  const int count = 2 * int(std::ceil(0.5 * cv::norm(b - a) / kDashPx)) + 1;
  for (int i = 0; i < count; i += 2)
    draw_line(picture, a + (b - a) * (double(i) / count), a + (b - a) * (double(i + 1) / count), colour, thickness);
}

void draw_dot(cv::Mat& picture, cv::Point2d at, double radius_px, const cv::Scalar& colour) {
  cv::circle(picture, tools::shifted(at), cvRound(radius_px * (1 << tools::kShift)), colour, cv::FILLED, cv::LINE_AA,
             tools::kShift);
}

void draw_cross(cv::Mat& picture, cv::Point2d at, double radius_px, const cv::Scalar& colour, int thickness) {
  const cv::Point2d falling(radius_px, radius_px), rising(radius_px, -radius_px);
  for (const auto& [shade, width] : {std::pair(kBackground, thickness + 2), std::pair(colour, thickness)}) {
    draw_line(picture, at - falling, at + falling, shade, width);
    draw_line(picture, at - rising, at + rising, shade, width);
  }
}

void draw_text(cv::Mat& picture, const std::string& text, cv::Point2d at, const cv::Scalar& colour, double scale) {
  tools::draw_text(picture, text, at, {colour, kBackground, scale, 3});
}

void draw_scale_bar(cv::Mat& picture, double px_per_m) {
  const double length_m = tools::round_length(0.25 * picture.cols / px_per_m);
  const cv::Point2d right(picture.cols - 14, picture.rows - 12), left = right - cv::Point2d(length_m * px_per_m, 0);
  draw_line(picture, left, right, kBackground, 5);
  draw_line(picture, left, right, kInk, 2);
  draw_text(picture, fmt::format("{:g} m", length_m), left + cv::Point2d(0, -7));
}

cv::Mat with_legend(const cv::Mat& picture, const std::vector<LegendEntry>& entries) {
  constexpr int kLine = 22, kMarkWidth = 30, kGap = 22;
  std::vector<cv::Point> places;
  cv::Point pen(12, kLine / 2 + 4);
  for (const LegendEntry& entry : entries) {
    int below;
    const int width = kMarkWidth + cv::getTextSize(entry.text, kFont, 0.45, 1, &below).width;
    if (pen.x > 12 && pen.x + width > picture.cols) pen = {12, pen.y + kLine};
    places.push_back(pen);
    pen.x += width + kGap;
  }
  cv::Mat out(picture.rows + pen.y + kLine / 2 + 4, picture.cols, CV_8UC3, kBackground);
  picture.copyTo(out.rowRange(0, picture.rows));
  for (size_t i = 0; i < entries.size(); ++i) {
    const cv::Point2d at(places[i].x, picture.rows + places[i].y);
    draw_mark(out, entries[i], at + cv::Point2d(10, 0));
    draw_text(out, entries[i].text, at + cv::Point2d(kMarkWidth, 5));
  }
  return out;
}

cv::Mat tiled(const std::vector<cv::Mat>& pictures, int columns) {
  constexpr int kGap = 8;
  const cv::Size size = pictures.front().size();
  const int count = int(pictures.size()), across = std::min(columns, count), rows = (count + across - 1) / across;
  cv::Mat out(rows * (size.height + kGap) - kGap, across * (size.width + kGap) - kGap, CV_8UC3, kBackground);
  for (int i = 0; i < count; ++i)
    pictures[size_t(i)].copyTo(
        out(cv::Rect({(i % across) * (size.width + kGap), (i / across) * (size.height + kGap)}, size)));
  return out;
}

}  // namespace landfix::eval
