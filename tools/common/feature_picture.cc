#include "tools/common/feature_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "tools/common/drawing.h"

namespace landfix::tools {
namespace {

constexpr int kLeastWidth_px = 900;  // so that outlines and the legend can be read

cv::Scalar colour_of(const std::array<uint8_t, 3>& c) { return {double(c[2]), double(c[1]), double(c[0]), 255}; }

const cv::Scalar kBlack(0, 0, 0, 255), kWhite(255, 255, 255, 255);

class Canvas {
 public:
  Canvas(const cv::Mat& picture, const Region& region) : region_(region) {
    scale_ = std::max(1, (kLeastWidth_px + picture.cols - 1) / picture.cols);
    cv::resize(picture, image_, {}, scale_, scale_, cv::INTER_NEAREST);
  }

  void draw(const Landmark& m) {
    const cv::Scalar colour = colour_of(kLandmarkStyles[m.landmark_class].colour);
    // A sure one is a broad line on a dark edge, a doubtful one is thin.
    const int thickness = m.confidence >= 0.5f ? 2 : 1;
    if (std::isnan(m.orientation_rad)) {
      outline_circle(at(m.east_m, m.north_m), double(m.length_m) / 2, colour, thickness);
      return;
    }
    const double s = std::sin(double(m.orientation_rad)), c = std::cos(double(m.orientation_rad)),
                 l = double(m.length_m) / 2, w = double(m.width_m) / 2;
    std::vector<cv::Point> corners;
    for (const auto& [along, across] : {std::pair(l, w), {l, -w}, {-l, -w}, {-l, w}})
      corners.push_back(at(m.east_m + along * s + across * c, m.north_m + along * c - across * s));
    outline({corners}, true, colour, thickness);
  }

  void draw(const Road& road, const std::vector<Point>& vertices) {
    std::vector<cv::Point> line;
    for (size_t i = 0; i < road.vertex_count; ++i) {
      const Point& p = vertices[road.first_vertex + i];
      line.push_back(at(p.east_m, p.north_m));
    }
    outline({line}, false, colour_of(kRoadColour), 2);
  }

  void draw(const Intersection& i) {
    const cv::Point middle = at(i.east_m, i.north_m);
    for (uint32_t k = 0; k < std::min(i.degree, uint32_t(LF_MAX_ARMS)); ++k) {
      const double reach = 16.0 * (1 << kShift), bearing = double(i.bearing_rad[k]);
      const cv::Point end(middle.x + int(std::lround(reach * std::sin(bearing))),
                          middle.y - int(std::lround(reach * std::cos(bearing))));
      outline({{middle, end}}, false, kWhite, 2);
    }
    cv::circle(image_, middle, 7 << kShift, kBlack, 4, cv::LINE_AA, kShift);
    cv::circle(image_, middle, 7 << kShift, kWhite, 2, cv::LINE_AA, kShift);
  }

  const cv::Mat& image() const { return image_; }

 private:
  cv::Point at(double east_m, double north_m) const {
    return shifted({(east_m - region_.west_m) / region_.gsd_m * scale_ - 0.5,
                    (region_.north_m - north_m) / region_.gsd_m * scale_ - 0.5});
  }
  // On a dark edge, so that every colour shows on every ground.
  void outline(const std::vector<std::vector<cv::Point>>& lines, bool closed, const cv::Scalar& colour, int thickness) {
    if (thickness > 1) cv::polylines(image_, lines, closed, kBlack, thickness + 2, cv::LINE_AA, kShift);
    cv::polylines(image_, lines, closed, colour, thickness, cv::LINE_AA, kShift);
  }
  void outline_circle(const cv::Point& middle, double radius_m, const cv::Scalar& colour, int thickness) {
    const int radius = std::max(2 << kShift, int(std::lround(radius_m / region_.gsd_m * scale_ * (1 << kShift))));
    if (thickness > 1) cv::circle(image_, middle, radius, kBlack, thickness + 2, cv::LINE_AA, kShift);
    cv::circle(image_, middle, radius, colour, thickness, cv::LINE_AA, kShift);
  }

  Region region_;
  int scale_ = 1;
  cv::Mat image_;
};

struct LegendEntry {
  std::string text;
  cv::Scalar colour;
  bool line;
};

std::vector<LegendEntry> entries_of(const DrawnFeatures& features) {
  std::vector<LegendEntry> out;
  if (features.landmarks)
    for (size_t c = 0; c < kLandmarkStyles.size(); ++c) {
      const auto count = std::ranges::count(*features.landmarks, c, &Landmark::landmark_class);
      out.push_back(
          {fmt::format("{} {}", kLandmarkStyles[c].name, count), colour_of(kLandmarkStyles[c].colour), false});
    }
  if (features.roads) {
    double length_m = 0;
    for (const Road& road : features.roads->roads) length_m += double(road.length_m);
    out.push_back({fmt::format("roads {:.1f} km", length_m / 1000), colour_of(kRoadColour), true});
    out.push_back({fmt::format("intersections {}", features.intersections.size()), kWhite, false});
  }
  return out;
}

// A strip of the picture's width; entries go on in a new row where one is full.
cv::Mat legend(int width, const std::vector<LegendEntry>& entries) {
  constexpr int kRow_px = 30, kMargin_px = 12, kSymbol_px = 18;
  std::vector<cv::Point> places;
  cv::Point place(kMargin_px, 0);
  for (const LegendEntry& e : entries) {
    const int wide = cv::getTextSize(e.text, cv::FONT_HERSHEY_SIMPLEX, 0.55, 1, nullptr).width + kSymbol_px + 32;
    if (place.x > kMargin_px && place.x + wide > width) place = {kMargin_px, place.y + kRow_px};
    places.push_back(place);
    place.x += wide;
  }
  cv::Mat out(place.y + kRow_px, width, CV_8UC4, cv::Scalar(40, 40, 40, 255));
  for (size_t i = 0; i < entries.size(); ++i) {
    const cv::Point middle = places[i] + cv::Point(kSymbol_px / 2, kRow_px / 2);
    if (entries[i].line)
      cv::line(out, middle - cv::Point(9, 0), middle + cv::Point(9, 0), entries[i].colour, 3, cv::LINE_AA);
    else
      cv::circle(out, middle, 6, entries[i].colour, 2, cv::LINE_AA);
    cv::putText(out, entries[i].text, middle + cv::Point(kSymbol_px / 2 + 6, 6), cv::FONT_HERSHEY_SIMPLEX, 0.55, kWhite,
                1, cv::LINE_AA);
  }
  return out;
}

}  // namespace

cv::Mat draw_features(const cv::Mat& picture, const Region& region, const DrawnFeatures& features) {
  Canvas canvas(picture, region);
  if (features.roads) {
    for (const Road& road : features.roads->roads) canvas.draw(road, features.roads->vertices);
    for (const Intersection& i : features.intersections) canvas.draw(i);
  }
  if (features.landmarks)
    for (const Landmark& m : *features.landmarks) canvas.draw(m);
  cv::Mat out;
  cv::vconcat(canvas.image(), legend(canvas.image().cols, entries_of(features)), out);
  return out;
}

}  // namespace landfix::tools
