#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tools/common/drawing.h"
#include "tools/common/map_underlay.h"
#include "tools/common/navigability_file.h"
#include "tools/common/navigability_style.h"

namespace landfix::tools {
namespace {

constexpr int kLongerSide_px = 1200;
constexpr int kRow_px = 30, kMargin_px = 12;
const cv::Scalar kInk(255, 255, 255), kBackground = cv::Scalar::all(kNothingShown);

MapFrame frame_of(const Pack& pack) {
  const lf_info map = pack.info();
  const double width_m = map.east_m - map.west_m, height_m = map.north_m - map.south_m,
               px_per_m = kLongerSide_px / std::max(width_m, height_m);
  return {map.west_m,
          map.north_m,
          px_per_m,
          {std::max(1, int(std::lround(width_m * px_per_m))), std::max(1, int(std::lround(height_m * px_per_m)))}};
}

// A square per node over the map.
cv::Mat draw_nodes(const cv::Mat& map, const MapFrame& frame, const NavigabilityView& view,
                   const std::vector<JudgedNode>& nodes) {
  cv::Mat colours(frame.size, CV_8UC3, cv::Scalar::all(0)), seen(frame.size, CV_8UC1, cv::Scalar(0));
  const double half_m = view.map.spacing_m() / 2;
  for (const JudgedNode& n : nodes) {
    const double east_m = view.map.east_of(n.column), north_m = view.map.north_of(n.row);
    const cv::Point2d first = frame.at(east_m - half_m, north_m + half_m),
                      last = frame.at(east_m + half_m, north_m - half_m);
    // Pixels whose centres lie within: squares neither overlap nor leave gaps.
    const cv::Point from(int(std::ceil(first.x)), int(std::ceil(first.y))),
        to(int(std::ceil(last.x)), int(std::ceil(last.y)));
    const cv::Rect square = cv::Rect(from, to) & cv::Rect({0, 0}, frame.size);
    colours(square).setTo(colour_of_class(class_of(n.chance(view.finder))));
    seen(square).setTo(255);
  }
  return coloured_map(map, colours, seen);
}

void draw_scale_bar(cv::Mat& picture, double px_per_m) {
  const double length_m = round_length(0.25 * picture.cols / px_per_m);
  const cv::Point2d right(picture.cols - 14, picture.rows - 14), left = right - cv::Point2d(length_m * px_per_m, 0);
  draw_line(picture, left, right, {0, 0, 0}, 6);
  draw_line(picture, left, right, kInk, 3);
  draw_text(picture, length_m < 1000 ? fmt::format("{:g} m", length_m) : fmt::format("{:g} km", length_m / 1000),
            left + cv::Point2d(0, -9));
}

// A band with what the colours mean and how much of the map has each, as wide as the picture; entries go on in a new
// row where one is full.
cv::Mat legend(int width, const NavigabilityView& view, const std::vector<JudgedNode>& nodes) {
  std::array<size_t, kChanceClasses.size()> counts{};
  for (const JudgedNode& n : nodes) ++counts[class_of(n.chance(view.finder))];
  const tiles::Footprint& f = view.map.footprint();
  cv::Mat out(kRow_px, width, CV_8UC3, kBackground);
  const TextStyle style{kInk, kBackground, 0.55, 1};
  draw_text(out,
            fmt::format("chance of a fix by {}: view {:g} m, up to {:g} m off", name_of(view.finder), f.template_m,
                        f.search_m),
            {kMargin_px, kRow_px - 9}, style);
  cv::Mat row(kRow_px, width, CV_8UC3, kBackground);
  int x = kMargin_px;
  for (size_t i = 0; i < kChanceClasses.size(); ++i) {
    const double percent = 100.0 * double(counts[i]) / double(nodes.size());
    const std::string text = counts[i] > 0 && percent < 0.5
                                 ? fmt::format("{} (<1 %)", kChanceClasses[i].text)
                                 : fmt::format("{} ({:.0f} %)", kChanceClasses[i].text, percent);
    const int wide = 26 + cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, style.scale, 1, nullptr).width + 24;
    if (x > kMargin_px && x + wide > width) {
      cv::vconcat(out, row, out);
      row.setTo(kBackground);
      x = kMargin_px;
    }
    cv::rectangle(row, {x, 7, 18, 16}, colour_of_class(i), cv::FILLED);
    draw_text(row, text, {double(x + 26), kRow_px - 9}, style);
    x += wide;
  }
  cv::vconcat(out, row, out);
  return out;
}

}  // namespace

void write_navigability_picture(const std::string& path, const NavigabilityView& view,
                                const std::vector<JudgedNode>& nodes, const std::string& pack_path) {
  const MapFrame frame = frame_of(view.pack);
  cv::Mat picture = draw_nodes(map_in_gray(view.pack, frame, pack_path), frame, view, nodes);
  draw_scale_bar(picture, frame.px_per_m);
  cv::vconcat(picture, legend(picture.cols, view, nodes), picture);
  write_picture(path, picture);
}

}  // namespace landfix::tools
