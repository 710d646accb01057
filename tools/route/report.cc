#include "tools/route/report.h"

#include <fmt/format.h>
#include <sodium.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "builder/error.h"
#include "tools/common/drawing.h"

namespace landfix::route {
namespace {

constexpr int kMapPx = 900, kRasterPx = 300;  ///< longer side as shown, and as computed
constexpr int kProfileWidthPx = 900, kProfileHeightPx = 240, kMarginPx = 50;
constexpr double kMapMarginShare = 0.12, kLeastMarginM = 300;
constexpr size_t kMostProfilePoints = 1500;
/// Okabe and Ito's, which the colour-blind can tell apart; they stand out from viridis by a dark rim.
constexpr std::array kColours = {"#ffffff", "#e69f00", "#cc79a7", "#56b4e9"};

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string base64(const std::vector<uchar>& bytes) {
  std::string text(sodium_base64_ENCODED_LEN(bytes.size(), sodium_base64_VARIANT_ORIGINAL), '\0');
  sodium_bin2base64(text.data(), text.size(), bytes.data(), bytes.size(), sodium_base64_VARIANT_ORIGINAL);
  text.resize(text.find('\0'));
  return text;
}

/// What the map shows, and where on the picture.
struct Frame {
  double west_m, south_m, east_m, north_m, px_per_m;
  explicit Frame(const std::vector<const RouteScore*>& routes) {
    west_m = south_m = INFINITY;
    east_m = north_m = -INFINITY;
    for (const RouteScore* route : routes) {
      for (const ScoredPoint& p : route->points) {
        west_m = std::min(west_m, p.station.east_m);
        east_m = std::max(east_m, p.station.east_m);
        south_m = std::min(south_m, p.station.north_m);
        north_m = std::max(north_m, p.station.north_m);
      }
    }
    const double margin_m = std::max(kLeastMarginM, kMapMarginShare * std::max(east_m - west_m, north_m - south_m));
    west_m -= margin_m;
    south_m -= margin_m;
    east_m += margin_m;
    north_m += margin_m;
    px_per_m = kMapPx / std::max(east_m - west_m, north_m - south_m);
  }
  double width_px() const { return (east_m - west_m) * px_per_m; }
  double height_px() const { return (north_m - south_m) * px_per_m; }
  double x(double e) const { return (e - west_m) * px_per_m; }
  double y(double n) const { return (north_m - n) * px_per_m; }
};

/// Chance of a fix from dark (none) to bright (certain); gray where the map knows nothing.
cv::Mat navigability_picture(const Frame& frame, const NavigabilityMap& map, const Vehicle& vehicle, double agl_m) {
  const double pixel_m = std::max(frame.east_m - frame.west_m, frame.north_m - frame.south_m) / kRasterPx;
  cv::Mat levels(std::max(1, int(std::lround((frame.north_m - frame.south_m) / pixel_m))),
                 std::max(1, int(std::lround((frame.east_m - frame.west_m) / pixel_m))), CV_8UC1);
  cv::Mat unknown(levels.size(), CV_8UC1, cv::Scalar(0)), picture;
  const double least_search_m = search_m(vehicle, 0, agl_m);
  for (int row = 0; row < levels.rows; ++row) {
    for (int column = 0; column < levels.cols; ++column) {
      const View view = view_at(map, vehicle, frame.west_m + (column + 0.5) * pixel_m,
                                frame.north_m - (row + 0.5) * pixel_m, agl_m, least_search_m);
      levels.at<uchar>(row, column) = cv::saturate_cast<uchar>(255 * view.fix_probability);
      if (view.reasons & (kOffMap | kNoImage)) unknown.at<uchar>(row, column) = 255;
    }
  }
  cv::applyColorMap(levels, picture, cv::COLORMAP_VIRIDIS);
  picture.setTo(cv::Scalar(190, 190, 190), unknown);
  return picture;
}

std::string png(const cv::Mat& picture) {
  std::vector<uchar> bytes;
  cv::imencode(".png", picture, bytes);
  return "data:image/png;base64," + base64(bytes);
}

/// Every so many points, the last in any case.
size_t every(const RouteScore& route) { return std::max<size_t>(1, route.points.size() / kMostProfilePoints); }

template <class X, class Y>
std::string polyline(const RouteScore& route, const X& x, const Y& y, const std::string& style) {
  std::string points;
  const size_t step = every(route);
  for (size_t i = 0; i < route.points.size(); ++i) {
    if (i % step != 0 && i + 1 != route.points.size()) continue;
    points += fmt::format("{:.1f},{:.1f} ", x(route.points[i]), y(route.points[i]));
  }
  return fmt::format("<polyline points=\"{}\" fill=\"none\" {}/>\n", points, style);
}

std::string scale_bar(const Frame& frame) {
  const double length_m = tools::round_length(0.25 * (frame.east_m - frame.west_m)), px = length_m * frame.px_per_m;
  const double y = frame.height_px() - 16;
  return fmt::format(
      "<path d=\"M16 {0:.1f}h{1:.1f}\" stroke=\"#000\" stroke-width=\"7\"/>"
      "<path d=\"M16 {0:.1f}h{1:.1f}\" stroke=\"#fff\" stroke-width=\"4\"/>"
      "<text x=\"20\" y=\"{2:.1f}\" class=\"on\">{3:g} m</text>\n",
      y, px, y - 8, length_m);
}

std::string map_svg(const ReportInput& input, const NavigabilityMap& map, const Vehicle& vehicle) {
  const Frame frame(input.routes);
  std::string svg =
      fmt::format("<svg width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} {1:.0f}\" role=\"img\">\n",
                  frame.width_px(), frame.height_px());
  svg += fmt::format(
      "<image width=\"{:.1f}\" height=\"{:.1f}\" preserveAspectRatio=\"none\" style=\"image-rendering:"
      "pixelated\" href=\"{}\"/>\n",
      frame.width_px(), frame.height_px(), png(navigability_picture(frame, map, vehicle, input.routes[0]->mean_agl_m)));
  const auto x = [&](const ScoredPoint& p) { return frame.x(p.station.east_m); };
  const auto y = [&](const ScoredPoint& p) { return frame.y(p.station.north_m); };
  for (size_t i = 0; i < input.routes.size(); ++i) {
    const RouteScore& route = *input.routes[i];
    svg += polyline(route, x, y, "stroke=\"#000\" stroke-width=\"6\" stroke-linejoin=\"round\"");
    svg +=
        polyline(route, x, y, fmt::format("stroke=\"{}\" stroke-width=\"3\" stroke-linejoin=\"round\"", kColours[i]));
    if (route.met) continue;
    RouteScore missing;
    for (const ScoredPoint& p : route.points)
      if (p.station.distance_m >= route.worst.start_m && p.station.distance_m <= route.worst.end_m)
        missing.points.push_back(p);
    svg += polyline(missing, x, y, "stroke=\"#d00000\" stroke-width=\"3\" stroke-dasharray=\"7 5\"");
  }
  const ScoredPoint& first = input.routes[0]->points.front();
  svg += fmt::format(
      "<circle cx=\"{0:.1f}\" cy=\"{1:.1f}\" r=\"7\" fill=\"#fff\" stroke=\"#000\" stroke-width=\"2\"/>"
      "<text x=\"{2:.1f}\" y=\"{1:.1f}\" class=\"on\">start</text>\n",
      x(first), y(first), x(first) + 11);
  return svg + scale_bar(frame) + "</svg>\n";
}

std::string axis_text(double x, double y, const std::string& text, const char* anchor) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y, anchor, text);
}

/// Radius and root mean square over the distance, with what was required; below it the chance of a fix.
std::string profile_svg(const RouteScore& route) {
  constexpr double kLeft = kMarginPx, kTop = 10, kWidth = kProfileWidthPx - kMarginPx - 10, kPlot = 170, kStrip = 14;
  const double most_m = std::max(1.15 * route.requirement.radius_m, 1.05 * route.largest_radius_m);
  const auto across = [&](double distance_m) { return kLeft + kWidth * distance_m / route.length_m; };
  const auto up = [&](double metres) { return kTop + kPlot * (1 - metres / most_m); };
  const auto x = [&](const ScoredPoint& p) { return across(p.station.distance_m); };
  std::string svg = fmt::format("<svg width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" role=\"img\">\n",
                                kProfileWidthPx, kProfileHeightPx);
  svg += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"#f7f7f7\"/>\n", kLeft, kTop, kWidth,
                     kPlot);
  const double tick_m = tools::round_length(most_m / 3), step_m = tools::round_length(route.length_m / 5);
  for (double v = 0; v <= most_m; v += tick_m) {
    svg += fmt::format("<path d=\"M{} {:.1f}h{}\" stroke=\"#ddd\"/>\n", kLeft, up(v), kWidth);
    svg += axis_text(kLeft - 6, up(v) + 4, fmt::format("{:g} m", v), "end");
  }
  for (double d = 0; d <= route.length_m; d += step_m)
    svg += axis_text(across(d), kTop + kPlot + kStrip + 26, fmt::format("{:g} km", d / 1000), "middle");
  svg += fmt::format("<path d=\"M{} {:.1f}h{}\" stroke=\"#d00000\" stroke-dasharray=\"6 4\"/>\n", kLeft,
                     up(route.requirement.radius_m), kWidth);
  svg += polyline(
      route, x, [&](const ScoredPoint& p) { return up(p.radius_m); }, "stroke=\"#0072b2\" stroke-width=\"2\"");
  svg += polyline(
      route, x, [&](const ScoredPoint& p) { return up(p.rms_m); }, "stroke=\"#777\" stroke-width=\"1.5\"");
  cv::Mat levels(1, int(kWidth), CV_8UC1), colours;
  for (int i = 0; i < levels.cols; ++i) {
    const double d = (i + 0.5) / levels.cols * route.length_m;
    const auto at = std::lower_bound(route.points.begin(), route.points.end() - 1, d,
                                     [](const ScoredPoint& p, double v) { return p.station.distance_m < v; });
    levels.at<uchar>(0, i) = cv::saturate_cast<uchar>(255 * at->fix_probability);
  }
  cv::applyColorMap(levels, colours, cv::COLORMAP_VIRIDIS);
  svg += fmt::format("<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" href=\"{}\"/>\n",
                     kLeft, kTop + kPlot + 4, kWidth, kStrip, png(colours));
  return svg + "</svg>\n";
}

std::string legs_table(const RouteScore& route) {
  std::string html = fmt::format(
      "<table><tr><th>leg to</th><th>length</th><th>largest rms</th><th>largest at {:g} %</th>"
      "<th>fixes</th><th>meeting</th><th>why</th></tr>\n",
      100 * route.requirement.confidence);
  for (const LegScore& l : route.legs) {
    html += fmt::format(
        "<tr><td>{}</td><td>{:.0f} m</td><td>{:.1f} m</td><td>{:.1f} m</td><td>{:.0f} %</td><td>{:.1f} %</td>"
        "<td>{}</td></tr>\n",
        escaped(l.leg.name), l.leg.end_m - l.leg.start_m, l.rms_m, l.radius_m, 100 * l.fix_probability, 100 * l.meeting,
        escaped(l.reason));
  }
  return html + "</table>\n";
}

std::string summary_row(const RouteScore& r, const char* colour) {
  return fmt::format(
      "<tr><td><span class=\"swatch\" style=\"background:{}\"></span>{}</td><td>{:.2f} km</td><td>{:.1f} m</td>"
      "<td>{:.1f} m</td><td>{:.1f} %</td><td>{:.1f} %</td><td>{:.0f} m, {:.0f} s</td><td>{}</td>"
      "<td>{}</td></tr>\n",
      colour, escaped(r.name), r.length_m / 1000, r.rms_m, r.largest_radius_m, 100 * r.meeting, 100 * r.within,
      r.longest_gap.length_m(), r.longest_gap.duration_s(),
      r.in_corridor ? fmt::format("{:.1f} %", 100 * *r.in_corridor) : "–",
      r.met ? "met" : "not met: " + escaped(r.worst.reason));
}

std::string summary_table(const ReportInput& input) {
  const RouteScore& first = *input.routes[0];
  std::string html = fmt::format(
      "<table><tr><th>route</th><th>length</th><th>rms</th><th>largest at {0:g} %</th><th>meeting {1:g} m</th>"
      "<th>time below {1:g} m</th><th>longest gap</th><th>within {2:g} m of the route</th><th>requirement</th></tr>\n",
      100 * first.requirement.confidence, first.requirement.radius_m, first.corridor_m);
  for (size_t i = 0; i < input.routes.size(); ++i) html += summary_row(*input.routes[i], kColours[i]);
  return html + "</table>\n";
}

std::string legend() {
  cv::Mat ramp(1, 256, CV_8UC1), colours;
  for (int i = 0; i < 256; ++i) ramp.at<uchar>(0, i) = uchar(i);
  cv::applyColorMap(ramp, colours, cv::COLORMAP_VIRIDIS);
  return "<p class=\"legend\">chance of a fix per image: 0 <img alt=\"\" width=\"256\" height=\"14\" src=\"" +
         png(colours) + "\"> 1; gray: unknown; red dashes: worst stretch that misses the requirement</p>\n";
}

constexpr char kStyle[] =
    "body{font:15px/1.45 sans-serif;max-width:960px;margin:2em auto;padding:0 1em;color:#222}"
    "table{border-collapse:collapse;margin:1em 0;font-size:13px}td,th{padding:4px 9px;border-bottom:1px solid #ddd;"
    "text-align:left}svg text{font:12px sans-serif}svg .on{fill:#fff;stroke:#000;stroke-width:3px;paint-order:stroke}"
    ".swatch{display:inline-block;width:14px;height:8px;margin-right:6px;border:1px solid #000}.legend{font-size:13px}"
    ".legend img{vertical-align:middle}svg{max-width:100%;height:auto}";

}  // namespace

std::string html_report(const ReportInput& input, const NavigabilityMap& map, const Vehicle& vehicle) {
  if (input.routes.empty() || input.routes.size() > kColours.size())
    throw Error(ExitCode::kBadInput, "route: expected one to four scored routes to report");
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title><style>{1}</style></head>\n"
      "<body>\n<h1>{0}</h1>\n",
      escaped(input.title), kStyle);
  if (!input.explanation.empty()) html += "<p><strong>" + escaped(input.explanation) + "</strong></p>\n";
  html += summary_table(input) + map_svg(input, map, vehicle) + legend();
  for (const RouteScore* route : input.routes) {
    html += fmt::format(
        "<h2>{}</h2>\n<p>Position error that is not exceeded with {:g} % (blue) and root mean square (gray) "
        "along the route; dashed: {:g} m; below: chance of a fix.</p>\n",
        escaped(route->name), 100 * route->requirement.confidence, route->requirement.radius_m);
    html += profile_svg(*route) + legs_table(*route);
  }
  return html + "</body></html>\n";
}

std::string html_report(const RouteScore& score, const NavigabilityMap& map, const Vehicle& vehicle) {
  return html_report({"Route without GNSS: " + score.name, "", {&score}}, map, vehicle);
}

std::string html_report(const Suggestion& suggestion, const NavigabilityMap& map, const Vehicle& vehicle) {
  ReportInput input{"Routes without GNSS", suggestion.explanation, {}};
  for (const Alternative& a : suggestion.alternatives)
    if (a.refused.empty()) input.routes.push_back(&a.score);
  return html_report(input, map, vehicle);
}

}  // namespace landfix::route
