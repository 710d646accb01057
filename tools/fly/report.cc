#include "tools/fly/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "builder/error.h"
#include "tools/common/drawing.h"
#include "tools/common/files.h"
#include "tools/fly/summary.h"

namespace landfix::fly {
namespace {

constexpr double kDegrees = 180 / M_PI;
constexpr double kMarginM = 60;
constexpr double kLeastAspect = 0.6;  ///< shorter over longer side of the picture
const cv::Scalar kTruthColour(80, 220, 80), kEstimateColour(60, 60, 255), kDeadReckoningColour(255, 190, 60),
    kEllipseColour(0, 220, 255), kInk(255, 255, 255);

/// Longitude and latitude in degrees.
std::pair<double, double> degrees_of(const tiles::Zone& zone, double east_m, double north_m) {
  const auto place = tiles::geodetic_from_grid(zone, east_m, north_m);
  if (!place) return {NAN, NAN};
  return {place->longitude_rad * kDegrees, place->latitude_rad * kDegrees};
}

std::string csv_line(const Record& r, const tiles::Zone& zone) {
  const auto [longitude, latitude] = degrees_of(zone, r.truth.east_m, r.truth.north_m);
  const auto [estimate_longitude, estimate_latitude] = degrees_of(zone, r.estimate.east_m, r.estimate.north_m);
  const auto& c = r.estimate.covariance_m2;
  const auto& a = r.truth.attitude;
  std::string line = fmt::format("{:.3f},{:.2f},{},", r.time_s, r.distance_m, r.gnss ? 1 : 0);
  line += fmt::format("{:.3f},{:.3f},{:.3f},{:.8f},{:.8f},", r.truth.east_m, r.truth.north_m, r.truth.height_m,
                      longitude, latitude);
  line += fmt::format("{:.3f},{:.3f},{:.3f},", a.roll * kDegrees, a.pitch * kDegrees,
                      (a.heading - 2 * M_PI * std::floor(a.heading / (2 * M_PI))) * kDegrees);
  line += fmt::format("{:.3f},{:.3f},{:.8f},{:.8f},{:.4f},{:.4f},{:.4f},", r.estimate.east_m, r.estimate.north_m,
                      estimate_longitude, estimate_latitude, c[0], 0.5 * (c[1] + c[2]), c[3]);
  line += fmt::format("{:.3f},{:.3f},{:.3f},{:.3f},{},", r.dead_reckoning_east_m, r.dead_reckoning_north_m, error_m(r),
                      dead_reckoning_error_m(r), inside_3_sigma(r) ? 1 : 0);
  if (r.gnss) return line + "gnss,,,,,,,,,,\n";
  const nav::Fix& f = r.fix;
  if (f.status != nav::Status::kOk) return line + fmt::format("failed:{},,,,,,,,,,\n", int(f.status));
  line += fmt::format("fix,{:.3f},{:.3f},{},{:.4f},{:.4f},{:.4f},", f.east_m, f.north_m, nav::name_of(f.method),
                      f.score, f.ambiguity, f.probability);
  return line + fmt::format("{:.3f},{:.3f},{:.3f},{:.4f}\n", f.rotation_rad * kDegrees, f.rotation_sigma_rad * kDegrees,
                            f.weight, f.gsd_m);
}

/// Grid coordinates to pixels of the picture.
struct Canvas {
  features::GridImage window;
  cv::Mat picture;
  double scale = 1;  ///< picture pixels per window pixel

  cv::Point2d at(double east_m, double north_m) const {
    return {(window.column_of(east_m) + 0.5) * scale, (window.row_of(north_m) + 0.5) * scale};
  }
  double px_per_m() const { return scale / window.gsd_m; }
};

struct Extent {
  double west = INFINITY, east = -INFINITY, south = INFINITY, north = -INFINITY;
  void take(double e, double n) {
    west = std::min(west, e), east = std::max(east, e), south = std::min(south, n), north = std::max(north, n);
  }
};

/// What the picture shows: tracks and ellipses with a margin, wide enough for the legend.
Extent extent_of(const std::vector<Record>& records) {
  Extent extent;
  for (const Record& r : records) {
    extent.take(r.truth.east_m, r.truth.north_m);
    extent.take(r.dead_reckoning_east_m, r.dead_reckoning_north_m);
    const double reach_e = 3 * std::sqrt(r.estimate.covariance_m2[0]);
    const double reach_n = 3 * std::sqrt(r.estimate.covariance_m2[3]);
    extent.take(r.estimate.east_m - reach_e, r.estimate.north_m - reach_n);
    extent.take(r.estimate.east_m + reach_e, r.estimate.north_m + reach_n);
  }
  const double longer = std::max(extent.east - extent.west, extent.north - extent.south);
  const auto pad = [longer](double& low, double& high) {
    const double added = std::max({kMarginM, 0.05 * longer, 0.5 * (kLeastAspect * longer - (high - low))});
    low -= added, high += added;
  };
  pad(extent.west, extent.east);
  pad(extent.south, extent.north);
  return extent;
}

Canvas canvas_over(const Extent& e, const nav::MapSource& map, int size_px) {
  Canvas canvas;
  const double wanted_gsd = std::max(e.east - e.west, e.north - e.south) / size_px;
  const double gsd = tools::level_to_draw(map.gsd_range_m(nav::MapLayer::kGray), wanted_gsd);
  if (gsd == 0) {  // a map of other layers: tracks on plain ground
    canvas.window.west_m = e.west, canvas.window.north_m = e.north, canvas.window.gsd_m = wanted_gsd;
    const cv::Size size(cvRound((e.east - e.west) / wanted_gsd), cvRound((e.north - e.south) / wanted_gsd));
    canvas.picture = cv::Mat(size, CV_8UC3, cv::Scalar(24, 24, 24));
    return canvas;
  }
  const nav::Status status = map.read(nav::MapLayer::kGray, e.west, e.south, e.east, e.north, gsd, canvas.window);
  if (status != nav::Status::kOk) {
    throw Error(ExitCode::kNoData, std::string("picture of the tracks: ") + nav::to_text(status));
  }
  cv::Mat shown = canvas.window.pixels.clone();
  if (!canvas.window.valid.empty()) shown.setTo(128, canvas.window.valid == 0);
  canvas.scale = canvas.window.gsd_m / wanted_gsd;
  cv::resize(shown, shown, {}, canvas.scale, canvas.scale, canvas.scale < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  canvas.picture = tools::dimmed(shown);
  return canvas;
}

void draw_ellipse(Canvas& canvas, const nav::Estimate& estimate) {
  const auto& c = estimate.covariance_m2;
  const double mean = (c[0] + c[3]) / 2, difference = (c[0] - c[3]) / 2, root = std::hypot(difference, c[1]);
  const double long_px = 3 * std::sqrt(std::max(0.0, mean + root)) * canvas.px_per_m();
  const double short_px = 3 * std::sqrt(std::max(0.0, mean - root)) * canvas.px_per_m();
  const double angle_rad = 0.5 * std::atan2(c[1], difference);  // of the long axis, from east towards north
  const cv::RotatedRect box(cv::Point2f(canvas.at(estimate.east_m, estimate.north_m)),
                            cv::Size2f(float(2 * long_px), float(2 * short_px)), float(-angle_rad * kDegrees));
  cv::ellipse(canvas.picture, box, kEllipseColour, 1, cv::LINE_AA);
}

/// Where GNSS was heard last.
void mark_cut(Canvas& canvas, const std::vector<Record>& records) {
  const auto cut = std::find_if(records.begin(), records.end(), [](const Record& r) { return !r.gnss; });
  if (cut == records.begin() || cut == records.end()) return;
  const cv::Point at = canvas.at(std::prev(cut)->truth.east_m, std::prev(cut)->truth.north_m);
  cv::circle(canvas.picture, at, 7, kInk, 2, cv::LINE_AA);
  tools::draw_text(canvas.picture, "GNSS cut", at + cv::Point(14, 5));
}

void draw_legend(Canvas& canvas, const std::vector<Record>& records) {
  const Summary s = summarize({records});
  const std::pair<std::string, cv::Scalar> entries[] = {
      {"truth", kTruthColour},
      {fmt::format("estimate: RMS {:.2f} m, largest error {:.2f} m", s.rms_m, s.max_m), kEstimateColour},
      {fmt::format("3-sigma ellipse: holds the truth {:.1f} % of the time", 100 * s.inside_3_sigma), kEllipseColour},
      {fmt::format("dead reckoning: {:.1f} m off at the end", s.dead_reckoning_final_m), kDeadReckoningColour}};
  int y = 28;
  for (const auto& [text, colour] : entries) {
    cv::line(canvas.picture, {14, y - 5}, {44, y - 5}, colour, 3, cv::LINE_AA);
    tools::draw_text(canvas.picture, text, cv::Point(54, y));
    y += 24;
  }
}

void draw_scale_bar(Canvas& canvas) {
  const double length_m = tools::round_length(0.2 * canvas.picture.cols / canvas.px_per_m());
  const int y = canvas.picture.rows - 22, left = 16, right = left + cvRound(length_m * canvas.px_per_m());
  cv::line(canvas.picture, {left, y}, {right, y}, kInk, 3);
  for (const int x : {left, right}) cv::line(canvas.picture, {x, y - 6}, {x, y + 6}, kInk, 2);
  tools::draw_text(canvas.picture, fmt::format("{:g} m", length_m), cv::Point(right + 10, y + 6));
}

}  // namespace

void write_track_csv(const std::filesystem::path& file, const std::vector<Record>& records, const tiles::Zone& zone) {
  std::string text =
      "time_s,distance_m,gnss,truth_east_m,truth_north_m,truth_height_m,truth_longitude_deg,truth_latitude_deg,"
      "roll_deg,pitch_deg,heading_grid_deg,estimate_east_m,estimate_north_m,estimate_longitude_deg,"
      "estimate_latitude_deg,"
      "covariance_ee_m2,covariance_en_m2,covariance_nn_m2,dead_reckoning_east_m,dead_reckoning_north_m,error_m,"
      "dead_reckoning_error_m,inside_3_sigma,fix_status,fix_east_m,fix_north_m,"
      "matcher,score,ambiguity,probability,rotation_deg,rotation_sigma_deg,weight,map_gsd_m\n";
  for (const Record& record : records) text += csv_line(record, zone);
  tools::write_text(file.string(), text);
}

cv::Mat draw_tracks(const std::vector<Record>& records, const nav::MapSource& map, int size_px) {
  Canvas canvas = canvas_over(extent_of(records), map, size_px);
  const size_t every = std::max<size_t>(1, records.size() / 40);
  for (size_t i = 0; i < records.size(); i += every) {
    if (!records[i].gnss) draw_ellipse(canvas, records[i].estimate);
  }
  for (size_t i = 1; i < records.size(); ++i) {
    const Record &a = records[i - 1], &b = records[i];
    tools::draw_line(canvas.picture, canvas.at(a.truth.east_m, a.truth.north_m),
                     canvas.at(b.truth.east_m, b.truth.north_m), kTruthColour, 3);
    if (b.gnss) continue;
    tools::draw_line(canvas.picture, canvas.at(a.dead_reckoning_east_m, a.dead_reckoning_north_m),
                     canvas.at(b.dead_reckoning_east_m, b.dead_reckoning_north_m), kDeadReckoningColour, 2);
    tools::draw_line(canvas.picture, canvas.at(a.estimate.east_m, a.estimate.north_m),
                     canvas.at(b.estimate.east_m, b.estimate.north_m), kEstimateColour, 2);
  }
  mark_cut(canvas, records);
  draw_legend(canvas, records);
  draw_scale_bar(canvas);
  return canvas.picture;
}

}  // namespace landfix::fly
