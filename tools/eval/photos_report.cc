// Photographs and their fixes as JSON and as a table.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "tools/eval/photos.h"

namespace landfix::eval {
namespace {

using nlohmann::ordered_json;
constexpr double kDegrees = 180 / std::numbers::pi;

ordered_json json_of(const Place& place, const tiles::Zone& zone) {
  ordered_json j = {{"east_m", place.east_m}, {"north_m", place.north_m}};
  if (const auto geodetic = tiles::geodetic_from_grid(zone, place.east_m, place.north_m)) {
    j["longitude_deg"] = geodetic->longitude_rad * kDegrees;
    j["latitude_deg"] = geodetic->latitude_rad * kDegrees;
  }
  return j;
}

ordered_json json_of(const Place& offset) {
  return {{"east", offset.east_m}, {"north", offset.north_m}, {"length", std::hypot(offset.east_m, offset.north_m)}};
}

/// 0 to 360 degrees.
double degrees_of(double heading_rad) {
  const double turns = heading_rad / (2 * std::numbers::pi);
  return 360 * (turns - std::floor(turns));
}

void add_match(const PhotoResult& r, const tiles::Zone& zone, double residual_m, ordered_json& j) {
  // A picture that was turned after it was taken does not turn the camera.
  const double heading = r.attitude.heading + r.similarity.rotation_rad;
  j["probability"] = r.probability;
  j["matcher"] = nav::name_of(r.method);
  j["camera"] = json_of(r.camera, zone);
  j["image_centre"] = json_of(r.image_centre(), zone);
  j["covariance_m2"] = r.covariance_m2;
  j["offset_from_tag_m"] = json_of(r.offset());
  j["residual_m"] = residual_m;  // NaN is written as null
  j["heading_true_deg"] = degrees_of(heading + r.convergence_rad);
  j["heading_grid_deg"] = degrees_of(heading);
  j["turned_deg"] = r.turned ? 180 : 0;
  j["rotation_deg"] = r.similarity.rotation_rad * kDegrees;
  j["rotation_sigma_deg"] = r.rotation_sigma_rad * kDegrees;
  j["scale"] = r.similarity.scale;
  j["scale_sigma"] = r.scale_sigma;
  j["height_above_ground_found_m"] = r.height_above_ground_m * r.similarity.scale;
  j["value"] = r.evidence.value;
  j["gap"] = r.evidence.gap;
  j["milliseconds"] = r.milliseconds;
}

}  // namespace

ordered_json to_json(const std::vector<PhotoResult>& photos, const tiles::Zone& zone) {
  const PhotoSummary s = summarize(photos);
  ordered_json list = ordered_json::array();
  for (size_t i = 0; i < photos.size(); ++i) {
    const PhotoResult& r = photos[i];
    ordered_json j = {{"name", r.name}, {"fix", r.accepted}, {"status", r.word}};
    j["reason"] = r.reason.empty() ? ordered_json() : ordered_json(r.reason);
    if (r.placed) {
      j["tag"] = json_of(r.tag, zone);
      j["height_above_ground_m"] = r.height_above_ground_m;
      j["focal_length_from"] = r.camera_source;
      j["gsd_m"] = r.gsd_m;
      j["heights_known_share"] = r.known_heights;
      j["share_on_map"] = r.on_map;
    }
    if (r.matched) add_match(r, zone, s.residuals_m[i], j);
    list.push_back(j);
  }
  ordered_json summary = {{"photos", s.photos}, {"placed", s.placed}, {"fixes", s.accepted}};
  summary["common_offset_m"] = s.common_offset ? json_of(*s.common_offset) : ordered_json();
  summary["median_residual_m"] = s.median_residual_m;
  summary["largest_residual_m"] = s.largest_residual_m;
  return {{"photos", list}, {"summary", summary}};
}

std::string to_text(const std::vector<PhotoResult>& photos) {
  const PhotoSummary s = summarize(photos);
  std::string text =
      fmt::format("{:<20}  {:>7}  {:>6}  {:>7}  {:>7}  {:>8}  {:>8}  {:>6}  {:<11}  {}\n", "photograph", "on map",
                  "prob.", "east m", "north m", "residual", "rotation", "scale", "matcher", "");
  for (size_t i = 0; i < photos.size(); ++i) {
    const PhotoResult& r = photos[i];
    text += fmt::format("{:<20}  ", r.name);
    text += r.patch.pixels.empty() ? fmt::format("{:>7}  ", "-") : fmt::format("{:>5.0f} %  ", 100 * r.on_map);
    if (!r.matched) {
      text += fmt::format("no fix: {}\n", r.reason);
      continue;
    }
    text +=
        fmt::format("{:>6.3f}  {:>7.2f}  {:>7.2f}  {:>8}  {:>7.2f}°  {:>6.3f}  {:<11}  {}\n", r.probability,
                    r.offset().east_m, r.offset().north_m, r.accepted ? fmt::format("{:.2f} m", s.residuals_m[i]) : "-",
                    r.similarity.rotation_rad * kDegrees, r.similarity.scale, nav::name_of(r.method),
                    r.accepted ? r.turned ? "upside down" : "" : "no fix: improbable");
  }
  text += fmt::format("{} of {} photographs have a fix", s.accepted, s.photos);
  if (s.common_offset)
    text += fmt::format(
        "; {:.2f} m east, {:.2f} m north of their tags in common, {:.2f} m from that in the median, "
        "{:.2f} m at most",
        s.common_offset->east_m, s.common_offset->north_m, s.median_residual_m, s.largest_residual_m);
  return text + "\n";
}

}  // namespace landfix::eval
