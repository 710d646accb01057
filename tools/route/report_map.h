// The map of a report, and what it shares with the rest of it: pictures within the file, lines of SVG, colours.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <string>

#include "tools/route/report.h"

namespace landfix::route {

/// How a route is drawn. Lightness and dashes tell them apart, whatever colours the reader sees.
struct RouteStyle {
  const char* line;
  const char* rim;
  const char* dashes;  ///< as stroke-dasharray
};
inline constexpr std::array<RouteStyle, 4> kRouteStyles = {{{"#ffffff", "#000000", "none"},
                                                            {"#000000", "#ffffff", "none"},
                                                            {"#7b3294", "#ffffff", "10 5"},
                                                            {"#000000", "#e69f00", "3 4"}}};

/// The picture as a "data:" address; `extension`: ".png" or ".jpg".
std::string picture_data(const cv::Mat& picture, const std::string& extension);

/// Of at most some 1500 points of a route, the last in any case; `x` and `y` take a ScoredPoint.
template <class X, class Y>
std::string polyline(const RouteScore& route, const X& x, const Y& y, const std::string& style) {
  constexpr size_t kMostPoints = 1500;
  const size_t step = std::max<size_t>(1, route.points.size() / kMostPoints);
  std::string points;
  for (size_t i = 0; i < route.points.size(); ++i) {
    if (i % step != 0 && i + 1 != route.points.size()) continue;
    points += fmt::format("{:.1f},{:.1f} ", x(route.points[i]), y(route.points[i]));
  }
  return fmt::format("<polyline points=\"{}\" fill=\"none\" {}/>\n", points, style);
}

/// Navigability over the overview of the map, fences, rally points, routes, scale bar and north, as SVG.
std::string map_svg(const ReportInput& input, const NavigabilityMap& map, const Vehicle& vehicle);

/// What is drawn in it means, as HTML.
std::string map_legend(const ReportInput& input);

}  // namespace landfix::route
