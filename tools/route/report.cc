#include "tools/route/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "builder/error.h"
#include "tools/common/drawing.h"
#include "tools/common/map_underlay.h"
#include "tools/common/navigability_style.h"
#include "tools/route/report_map.h"

namespace landfix::route {
namespace {

constexpr int kProfileWidthPx = 900, kProfileHeightPx = 240, kMarginPx = 50;

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
  cv::Mat colours(1, int(kWidth), CV_8UC3);
  for (int i = 0; i < colours.cols; ++i) {
    const double d = (i + 0.5) / colours.cols * route.length_m;
    const auto at = std::lower_bound(route.points.begin(), route.points.end() - 1, d,
                                     [](const ScoredPoint& p, double v) { return p.station.distance_m < v; });
    colours.col(i).setTo(tools::colour_of_class(tools::class_of(at->fix_probability)));
  }
  svg += fmt::format("<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" href=\"{}\"/>\n",
                     kLeft, kTop + kPlot + 4, kWidth, kStrip, picture_data(colours, ".png"));
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

std::string summary_row(const RouteScore& r, const RouteStyle& style) {
  return fmt::format(
      "<tr><td><svg width=\"34\" height=\"8\" viewBox=\"0 0 34 8\"><path d=\"M0 4H34\" stroke=\"{}\" "
      "stroke-width=\"7\"/>"
      "<path d=\"M0 4H34\" stroke=\"{}\" stroke-width=\"4\" stroke-dasharray=\"{}\"/></svg> {}</td><td>{:.2f} "
      "km</td><td>{:.1f} m</td>"
      "<td>{:.1f} m</td><td>{:.1f} %</td><td>{:.1f} %</td><td>{:.0f} m, {:.0f} s</td><td>{}</td>"
      "<td>{}</td></tr>\n",
      style.rim, style.line, style.dashes, escaped(r.name), r.length_m / 1000, r.rms_m, r.largest_radius_m,
      100 * r.meeting, 100 * r.within, r.longest_gap.length_m(), r.longest_gap.duration_s(),
      r.in_corridor ? fmt::format("{:.1f} %", 100 * *r.in_corridor) : "–",
      r.met ? "met" : "not met: " + escaped(r.worst.reason));
}

std::string summary_table(const ReportInput& input) {
  const RouteScore& first = *input.routes[0];
  std::string html = fmt::format(
      "<table><tr><th>route</th><th>length</th><th>rms</th><th>largest at {0:g} %</th><th>meeting {1:g} m</th>"
      "<th>time below {1:g} m</th><th>longest gap</th><th>within {2:g} m of the route</th><th>requirement</th></tr>\n",
      100 * first.requirement.confidence, first.requirement.radius_m, first.corridor_m);
  for (size_t i = 0; i < input.routes.size(); ++i) html += summary_row(*input.routes[i], kRouteStyles[i]);
  return html + "</table>\n";
}

constexpr char kStyle[] =
    "body{font:15px/1.45 sans-serif;max-width:960px;margin:2em auto;padding:0 1em;color:#222}"
    "table{border-collapse:collapse;margin:1em 0;font-size:13px}td,th{padding:4px 9px;border-bottom:1px solid #ddd;"
    "text-align:left}svg text{font:12px sans-serif}svg .on{fill:#fff;stroke:#000;stroke-width:3px;paint-order:stroke}"
    ".swatch{display:inline-block;width:14px;height:8px;margin-right:6px;border:1px solid #000}.legend{font-size:13px}"
    ".legend svg{vertical-align:middle}svg{max-width:100%;height:auto}";

}  // namespace

std::string html_report(const ReportInput& input, const NavigabilityMap& map, const Vehicle& vehicle) {
  if (input.routes.empty() || input.routes.size() > kRouteStyles.size())
    throw Error(ExitCode::kBadInput, "route: expected one to four scored routes to report");
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title><style>{1}</style></head>\n"
      "<body>\n<h1>{0}</h1>\n",
      escaped(input.title), kStyle);
  if (!input.explanation.empty()) html += "<p><strong>" + escaped(input.explanation) + "</strong></p>\n";
  html += summary_table(input) + map_svg(input, map, vehicle) + map_legend(input);
  for (const RouteScore* route : input.routes) {
    html += fmt::format(
        "<h2>{}</h2>\n<p>Position error that is not exceeded with {:g} % (blue) and root mean square (gray) "
        "along the route; dashed: {:g} m; below: chance of a fix.</p>\n",
        escaped(route->name), 100 * route->requirement.confidence, route->requirement.radius_m);
    html += profile_svg(*route) + legs_table(*route);
  }
  return html + "</body></html>\n";
}

ReportScene scene_of(const Pack& pack, const std::string& pack_path, const Fences& fences,
                     const mission::Mission* mission, const tiles::Zone& zone) {
  ReportScene scene{&pack, pack_path, fences, {}};
  if (!mission) return scene;
  constexpr double kRadians = M_PI / 180;
  for (const mission::Place& p : mission->rally_points) {
    const auto place =
        tiles::grid_from_geodetic(zone, {p.position.latitude_deg * kRadians, p.position.longitude_deg * kRadians});
    if (place) scene.rally_points.emplace_back(place->east_m, place->north_m);
  }
  return scene;
}

std::string html_report(const RouteScore& score, const NavigabilityMap& map, const Vehicle& vehicle,
                        const ReportScene& scene) {
  return html_report({"Route without GNSS: " + score.name, "", {&score}, scene}, map, vehicle);
}

std::string html_report(const Suggestion& suggestion, const NavigabilityMap& map, const Vehicle& vehicle,
                        const ReportScene& scene) {
  ReportInput input{"Routes without GNSS", suggestion.explanation, {}, scene};
  for (const Alternative& a : suggestion.alternatives)
    if (a.refused.empty()) input.routes.push_back(&a.score);
  return html_report(input, map, vehicle);
}

}  // namespace landfix::route
