// A score as JSON and as text.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/route/score.h"

namespace landfix::route {
namespace {

using Json = nlohmann::ordered_json;

double rounded(double value) { return std::round(value * 1000) / 1000; }

Json stretch_json(const Stretch& s) {
  return {{"start_m", rounded(s.start_m)},   {"end_m", rounded(s.end_m)}, {"length_m", rounded(s.length_m())},
          {"start_s", rounded(s.start_s)},   {"end_s", rounded(s.end_s)}, {"duration_s", rounded(s.duration_s())},
          {"radius_m", rounded(s.radius_m)}, {"reason", s.reason}};
}

Json leg_json(const LegScore& l) {
  return {{"name", l.leg.name},
          {"item", l.leg.item},
          {"start_m", rounded(l.leg.start_m)},
          {"end_m", rounded(l.leg.end_m)},
          {"largest_rms_m", rounded(l.rms_m)},
          {"largest_radius_m", rounded(l.radius_m)},
          {"mean_fix_probability", rounded(l.fix_probability)},
          {"share_meeting", rounded(l.meeting)},
          {"reason", l.reason}};
}

Json point_json(const ScoredPoint& p, const tiles::Zone& zone) {
  const auto place = tiles::geodetic_from_grid(zone, p.station.east_m, p.station.north_m);
  const auto degrees = [](double rad) { return std::round(rad * 180 / M_PI * 1e8) / 1e8; };
  Json json = {{"distance_m", rounded(p.station.distance_m)},
               {"time_s", rounded(p.station.time_s)},
               {"latitude_deg", place ? Json(degrees(place->latitude_rad)) : Json()},
               {"longitude_deg", place ? Json(degrees(place->longitude_rad)) : Json()},
               {"agl_m", rounded(p.station.agl_m)},
               {"fix_probability", rounded(p.fix_probability)},
               {"false_probability", rounded(p.false_probability)},
               {"rms_m", rounded(p.rms_m)},
               {"radius_m", rounded(p.radius_m)},
               {"within", rounded(p.within)}};
  json["covariance_m2"] = {rounded(p.covariance_m2(0, 0)), rounded(p.covariance_m2(0, 1)),
                           rounded(p.covariance_m2(1, 1))};
  json["reasons"] = words(p.reasons, p.repeat);
  return json;
}

std::string stretch_text(const Stretch& s) {
  return fmt::format("{:.0f} to {:.0f} m ({:.0f} m, {:.0f} s){}{}", s.start_m, s.end_m, s.length_m(), s.duration_s(),
                     s.reason.empty() ? "" : ": ", s.reason);
}

}  // namespace

Json to_json(const RouteScore& s, const tiles::Zone& zone, size_t most_points) {
  Json json = {{"name", s.name},
               {"required_radius_m", s.requirement.radius_m},
               {"required_confidence", s.requirement.confidence},
               {"met", s.met},
               {"length_m", rounded(s.length_m)},
               {"duration_s", rounded(s.duration_s)},
               {"mean_agl_m", rounded(s.mean_agl_m)},
               {"footprint_m", rounded(s.footprint_m)},
               {"rms_m", rounded(s.rms_m)},
               {"largest_rms_m", rounded(s.largest_rms_m)},
               {"largest_radius_m", rounded(s.largest_radius_m)},
               {"share_meeting", rounded(s.meeting)},
               {"expected_share_within", rounded(s.within)},
               {"share_on_map", rounded(s.on_map)},
               {"worst_stretch", stretch_json(s.worst)},
               {"longest_gap", stretch_json(s.longest_gap)}};
  if (s.in_corridor) {
    json["corridor_half_width_m"] = s.corridor_m;
    json["chance_in_corridor"] = rounded(*s.in_corridor);
    json["chance_in_corridor_standard_error"] = rounded(s.corridor_error);
  }
  json["legs"] = Json::array();
  for (const LegScore& leg : s.legs) json["legs"].push_back(leg_json(leg));
  json["points"] = Json::array();
  const size_t every = std::max<size_t>(1, (s.points.size() + most_points - 1) / std::max<size_t>(most_points, 1));
  for (size_t i = every - 1; i < s.points.size(); i += every) json["points"].push_back(point_json(s.points[i], zone));
  return json;
}

std::string to_text(const RouteScore& s) {
  const double percent = 100 * s.requirement.confidence;
  std::string text = fmt::format("{}: {:.2f} km, {:.0f} s, {:.0f} m above ground, view {:.0f} m\n\n", s.name,
                                 s.length_m / 1000, s.duration_s, s.mean_agl_m, s.footprint_m);
  text += fmt::format("{:<22} {:>9} {:>7} {:>7} {:>6} {:>9}  {}\n", "leg to", "length m", "rms m",
                      fmt::format("{:.0f}% m", percent), "fixes", "meeting", "why");
  for (const LegScore& l : s.legs) {
    text += fmt::format("{:<22} {:>9.0f} {:>7.1f} {:>7.1f} {:>5.0f}% {:>8.1f}%  {}\n", l.leg.name,
                        l.leg.end_m - l.leg.start_m, l.rms_m, l.radius_m, 100 * l.fix_probability, 100 * l.meeting,
                        l.reason);
  }
  text += fmt::format(
      "\nrequired {:g} m at {:g} %: {} ({:.1f} % of the route; {:.1f} % of the time below {:g} m expected)\n",
      s.requirement.radius_m, percent, s.met ? "met" : "not met", 100 * s.meeting, 100 * s.within,
      s.requirement.radius_m);
  text +=
      fmt::format("largest error: {:.1f} m rms, {:.1f} m at {:g} %\n", s.largest_rms_m, s.largest_radius_m, percent);
  text += "worst stretch: " + stretch_text(s.worst) + "\n";
  text += s.longest_gap.length_m() > 0 ? "longest gap without an expected fix: " + stretch_text(s.longest_gap) + "\n"
                                       : "no gap without an expected fix\n";
  if (s.on_map < 1)
    text += fmt::format("{:.1f} % of the route lie where the map knows nothing\n", 100 * (1 - s.on_map));
  if (!s.in_corridor) return text;
  text += fmt::format("chance to stay within {:g} m of the route: {:.1f} % ± {:.1f} %\n", s.corridor_m,
                      100 * *s.in_corridor, 100 * s.corridor_error);
  return text;
}

}  // namespace landfix::route
