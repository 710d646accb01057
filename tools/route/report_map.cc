#include "tools/route/report_map.h"

#include <sodium.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tools/common/drawing.h"
#include "tools/common/map_underlay.h"
#include "tools/common/navigability_style.h"

namespace landfix::route {
namespace {

constexpr int kMapPx = 900, kPicturePx = 1350, kRasterPx = 300;  ///< longer side: shown, in the file, as computed
constexpr double kMarginShare = 0.12, kLeastMarginM = 300;
constexpr double kMostGrowth = 0.25;  ///< of the longer side, to every side, for fences and rally points
constexpr int kJpegQuality = 85;

std::string base64(const std::vector<uchar>& bytes) {
  std::string text(sodium_base64_ENCODED_LEN(bytes.size(), sodium_base64_VARIANT_ORIGINAL), '\0');
  sodium_bin2base64(text.data(), text.size(), bytes.data(), bytes.size(), sodium_base64_VARIANT_ORIGINAL);
  text.resize(text.find('\0'));
  return text;
}

/// What the map shows, and where on the picture.
struct Frame {
  double west_m = INFINITY, south_m = INFINITY, east_m = -INFINITY, north_m = -INFINITY, px_per_m = 0;

  explicit Frame(const ReportInput& input) {
    for (const RouteScore* route : input.routes)
      for (const ScoredPoint& p : route->points) hold({p.station.east_m, p.station.north_m});
    const Frame routes = *this;
    const double side_m = longer_side_m(), most_m = kMostGrowth * side_m;
    for (const auto& fences : {input.scene.fences.exclusions(), input.scene.fences.inclusions()})
      for (const Polygon& fence : fences)
        for (const Eigen::Vector2d& corner : fence) hold(corner);
    for (const Eigen::Vector2d& place : input.scene.rally_points) hold(place);
    const double margin_m = std::max(kLeastMarginM, kMarginShare * side_m);
    west_m = std::max(west_m, routes.west_m - most_m) - margin_m;
    south_m = std::max(south_m, routes.south_m - most_m) - margin_m;
    east_m = std::min(east_m, routes.east_m + most_m) + margin_m;
    north_m = std::min(north_m, routes.north_m + most_m) + margin_m;
    px_per_m = kMapPx / longer_side_m();
  }

  void hold(const Eigen::Vector2d& place) {
    west_m = std::min(west_m, place.x());
    east_m = std::max(east_m, place.x());
    south_m = std::min(south_m, place.y());
    north_m = std::max(north_m, place.y());
  }
  double longer_side_m() const { return std::max(east_m - west_m, north_m - south_m); }
  double width_px() const { return (east_m - west_m) * px_per_m; }
  double height_px() const { return (north_m - south_m) * px_per_m; }
  double x(double e) const { return (e - west_m) * px_per_m; }
  double y(double n) const { return (north_m - n) * px_per_m; }

  cv::Size pixels(int longer_side) const {
    const double per_m = longer_side / longer_side_m();
    return {std::max(1, int(std::lround((east_m - west_m) * per_m))),
            std::max(1, int(std::lround((north_m - south_m) * per_m)))};
  }
};

/// Chance of a fix at the middle of each pixel, CV_32FC1, and where the map knows it, CV_8UC1.
struct Chances {
  cv::Mat values, known;
};

Chances chances_of(const Frame& frame, const NavigabilityMap& map, const Vehicle& vehicle, double agl_m) {
  const cv::Size size = frame.pixels(kRasterPx);
  Chances out{cv::Mat(size, CV_32FC1), cv::Mat(size, CV_8UC1, cv::Scalar(255))};
  const double pixel_m = frame.longer_side_m() / kRasterPx, least_search_m = search_m(vehicle, 0, agl_m);
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const View view = view_at(map, vehicle, frame.west_m + (column + 0.5) * pixel_m,
                                frame.north_m - (row + 0.5) * pixel_m, agl_m, least_search_m);
      out.values.at<float>(row, column) = float(view.fix_probability);
      if (view.reasons & (kOffMap | kNoImage)) out.known.at<uchar>(row, column) = 0;
    }
  }
  return out;
}

/// The classes of the chance in their colours over the map below, which lies bare where nothing is known.
cv::Mat navigability_picture(const Frame& frame, const ReportScene& scene, const Chances& chances) {
  const cv::Size size = frame.pixels(kPicturePx);
  cv::Mat values, known, colours(size, CV_8UC3);
  cv::resize(chances.values, values, size, 0, 0, cv::INTER_LINEAR);
  cv::resize(chances.known, known, size, 0, 0, cv::INTER_NEAREST);
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const cv::Scalar colour = tools::colour_of_class(tools::class_of(values.at<float>(row, column)));
      colours.at<cv::Vec3b>(row, column) = cv::Vec3b(uchar(colour[0]), uchar(colour[1]), uchar(colour[2]));
    }
  }
  const tools::MapFrame below{frame.west_m, frame.north_m, kPicturePx / frame.longer_side_m(), size};
  const cv::Mat ground = scene.pack ? tools::map_in_gray(*scene.pack, below, scene.pack_path) : cv::Mat();
  return tools::coloured_map(ground, colours, known);
}

std::string polygon_path(const Frame& frame, const Polygon& polygon) {
  std::string path;
  for (const Eigen::Vector2d& c : polygon)
    path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", frame.x(c.x()), frame.y(c.y()));
  return path + "Z";
}

/// Hatched where nothing may fly; a dotted line around where all must stay.
std::string fences_svg(const Frame& frame, const Fences& fences) {
  std::string svg =
      "<defs><pattern id=\"hatch\" width=\"9\" height=\"9\" patternUnits=\"userSpaceOnUse\" "
      "patternTransform=\"rotate(45)\"><path d=\"M0 0V9\" stroke=\"#000\" stroke-width=\"3\"/></pattern></defs>\n";
  for (const Polygon& p : fences.exclusions())
    svg += fmt::format("<path class=\"exclusion\" d=\"{}\" fill=\"url(#hatch)\" stroke=\"#000\" stroke-width=\"2\"/>\n",
                       polygon_path(frame, p));
  for (const Polygon& p : fences.inclusions()) {
    const std::string path = polygon_path(frame, p);
    svg += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"#000\" stroke-width=\"5\"/>\n", path);
    svg += fmt::format(
        "<path class=\"inclusion\" d=\"{}\" fill=\"none\" stroke=\"#fff\" stroke-width=\"3\" "
        "stroke-dasharray=\"2 5\"/>\n",
        path);
  }
  return svg;
}

/// A disc with a letter, as ground stations mark places.
std::string mark(double x, double y, const char* letter) {
  return fmt::format(
      "<circle cx=\"{0:.1f}\" cy=\"{1:.1f}\" r=\"9\" fill=\"#fff\" stroke=\"#000\" stroke-width=\"2\"/>"
      "<text x=\"{0:.1f}\" y=\"{2:.1f}\" text-anchor=\"middle\">{3}</text>\n",
      x, y, y + 4, letter);
}

std::string line_style(const char* colour, double width, const char* dashes = "none") {
  return fmt::format("stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\" stroke-dasharray=\"{}\"", colour,
                     width, dashes);
}

/// With a broad band under what misses the requirement worst.
std::string route_svg(const Frame& frame, const RouteScore& route, const RouteStyle& style) {
  const auto x = [&](const ScoredPoint& p) { return frame.x(p.station.east_m); };
  const auto y = [&](const ScoredPoint& p) { return frame.y(p.station.north_m); };
  std::string svg;
  if (!route.met) {
    RouteScore missing;
    for (const ScoredPoint& p : route.points)
      if (p.station.distance_m >= route.worst.start_m && p.station.distance_m <= route.worst.end_m)
        missing.points.push_back(p);
    svg += polyline(missing, x, y, line_style("#000", 16)) + polyline(missing, x, y, line_style("#ff0", 12));
  }
  return svg + polyline(route, x, y, line_style(style.rim, 6)) +
         polyline(route, x, y, line_style(style.line, 3, style.dashes));
}

/// Scale bar and north.
std::string margins_svg(const Frame& frame) {
  const double length_m = tools::round_length(0.25 * (frame.east_m - frame.west_m)), px = length_m * frame.px_per_m;
  const double y = frame.height_px() - 16, x = frame.width_px() - 24;
  return fmt::format(
             "<path d=\"M16 {0:.1f}h{1:.1f}\" stroke=\"#000\" stroke-width=\"7\"/>"
             "<path d=\"M16 {0:.1f}h{1:.1f}\" stroke=\"#fff\" stroke-width=\"4\"/>"
             "<text x=\"20\" y=\"{2:.1f}\" class=\"on\">{3}</text>\n",
             y, px, y - 8,
             length_m < 1000 ? fmt::format("{:g} m", length_m) : fmt::format("{:g} km", length_m / 1000)) +
         fmt::format(
             "<path d=\"M{0:.1f} 12l8 24l-8 -6l-8 6z\" fill=\"#fff\" stroke=\"#000\" stroke-width=\"1.5\"/>"
             "<text x=\"{0:.1f}\" y=\"50\" text-anchor=\"middle\" class=\"on\">N</text>\n",
             x);
}

std::string swatch(const std::string& content) {
  return "<svg width=\"34\" height=\"14\" viewBox=\"0 0 34 14\">" + content + "</svg> ";
}

}  // namespace

std::string picture_data(const cv::Mat& picture, const std::string& extension) {
  std::vector<uchar> bytes;
  const bool png = extension == ".png";
  cv::imencode(extension, picture, bytes,
               png ? std::vector<int>() : std::vector{int(cv::IMWRITE_JPEG_QUALITY), kJpegQuality});
  return std::string(png ? "data:image/png" : "data:image/jpeg") + ";base64," + base64(bytes);
}

std::string map_svg(const ReportInput& input, const NavigabilityMap& map, const Vehicle& vehicle) {
  const Frame frame(input);
  const Chances chances = chances_of(frame, map, vehicle, input.routes[0]->mean_agl_m);
  std::string svg = fmt::format(
      "<svg width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} {1:.0f}\" role=\"img\">\n"
      "<image width=\"{0:.0f}\" height=\"{1:.0f}\" preserveAspectRatio=\"none\" href=\"{2}\"/>\n",
      frame.width_px(), frame.height_px(), picture_data(navigability_picture(frame, input.scene, chances), ".jpg"));
  svg += fences_svg(frame, input.scene.fences);
  for (size_t i = 0; i < input.routes.size(); ++i) svg += route_svg(frame, *input.routes[i], kRouteStyles[i]);
  for (const Eigen::Vector2d& p : input.scene.rally_points) svg += mark(frame.x(p.x()), frame.y(p.y()), "R");
  const RouteScore& first = *input.routes[0];
  const Station &start = first.points.front().station, &end = first.points.back().station;
  svg +=
      mark(frame.x(end.east_m), frame.y(end.north_m), "E") + mark(frame.x(start.east_m), frame.y(start.north_m), "S");
  return svg + margins_svg(frame) + "</svg>\n";
}

std::string map_legend(const ReportInput& input) {
  std::string html = "<p class=\"legend\">Chance of a fix per image: ";
  for (const tools::ChanceClass& c : tools::kChanceClasses)
    html += fmt::format("<span class=\"swatch\" style=\"background:rgb({},{},{})\"></span>{} &nbsp;", c.colour[0],
                        c.colour[1], c.colour[2], c.text);
  html += "; no colour: not known.<br>\nS: start, E: end";
  if (!input.scene.rally_points.empty()) html += ", R: rally point";
  if (std::any_of(input.routes.begin(), input.routes.end(), [](const RouteScore* r) { return !r->met; }))
    html += "; " +
            swatch(
                "<path d=\"M0 7H34\" stroke=\"#000\" stroke-width=\"14\"/><path d=\"M0 7H34\" stroke=\"#ff0\" "
                "stroke-width=\"10\"/>") +
            "worst stretch that misses the requirement";
  if (!input.scene.fences.exclusions().empty())
    html += "; " + swatch("<rect width=\"34\" height=\"14\" fill=\"url(#hatch)\" stroke=\"#000\"/>") + "no-fly area";
  if (!input.scene.fences.inclusions().empty())
    html += "; " +
            swatch(
                "<path d=\"M0 7H34\" stroke=\"#000\" stroke-width=\"5\"/><path d=\"M0 7H34\" stroke=\"#fff\" "
                "stroke-width=\"3\" stroke-dasharray=\"2 5\"/>") +
            "border of the area to stay in";
  return html + "</p>\n";
}

}  // namespace landfix::route
