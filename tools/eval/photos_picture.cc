// Photographs over the map.
#include <fmt/format.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tools/eval/map_picture.h"
#include "tools/eval/photos.h"

namespace landfix::eval {
namespace {

constexpr int kPanelPx = 1000;

/// The result as drawn: where there is no fix, as the tags have it.
PhotoResult as_drawn(const PhotoResult& photo, const Place& common_offset) {
  PhotoResult r = photo;
  if (r.accepted) return r;
  r.camera = {r.tag.east_m + common_offset.east_m, r.tag.north_m + common_offset.north_m};
  r.similarity = {};
  return r;
}

/// Outline of the footprint in picture coordinates.
std::vector<cv::Point2d> outline(const PhotoResult& r, const MapPicture& map) {
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(r.patch.valid, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE);
  std::vector<cv::Point2d> out;
  if (contours.empty()) return out;
  const auto largest = std::max_element(contours.begin(), contours.end(), [](const auto& a, const auto& b) {
    return cv::contourArea(a) < cv::contourArea(b);
  });
  std::vector<cv::Point> corners;
  cv::approxPolyDP(*largest, corners, 2, true);
  for (const cv::Point& p : corners) {
    const Place place =
        place_of(r, r.patch.west_m + (p.x + 0.5) * r.patch.gsd_m, r.patch.north_m - (p.y + 0.5) * r.patch.gsd_m);
    out.push_back(map.at(place.east_m, place.north_m));
  }
  return out;
}

void draw_outline(const PhotoResult& r, MapPicture& map) {
  const std::vector<cv::Point2d> corners = outline(r, map);
  for (size_t i = 0; i < corners.size(); ++i) {
    const cv::Point2d a = corners[i], b = corners[(i + 1) % corners.size()];
    r.accepted ? draw_line(map.pixels(), a, b, kBlue) : draw_dashed(map.pixels(), a, b, kVermilion);
  }
}

void draw_position(const PhotoResult& r, MapPicture& map) {
  const cv::Point2d tag = map.at(r.tag.east_m, r.tag.north_m), found = map.at(r.camera.east_m, r.camera.north_m);
  draw_line(map.pixels(), tag, found, kYellow);
  draw_cross(map.pixels(), tag, 4, kYellow);
  if (r.accepted) draw_dot(map.pixels(), found, 4, kBlue);
  draw_text(map.pixels(), r.name.substr(0, r.name.rfind('.')), found + cv::Point2d(7, -5),
            r.accepted ? kInk : kVermilion, 0.4);
}

void lay_over(const PhotoResult& r, MapPicture& map) {
  const auto pixel = [&](double column, double row) {
    const Place place =
        place_of(r, r.patch.west_m + (column + 0.5) * r.patch.gsd_m, r.patch.north_m - (row + 0.5) * r.patch.gsd_m);
    return map.at(place.east_m, place.north_m);
  };
  const cv::Point2d origin = pixel(0, 0), x = pixel(1, 0) - origin, y = pixel(0, 1) - origin;
  const cv::Matx23d picture_from_patch(x.x, y.x, origin.x, x.y, y.y, origin.y);
  cv::Mat colours, laid, valid;
  cv::cvtColor(r.patch.pixels, colours, cv::COLOR_RGB2BGR);
  const cv::Size size = map.pixels().size();
  cv::warpAffine(colours, laid, picture_from_patch, size, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::warpAffine(r.patch.valid, valid, picture_from_patch, size, cv::INTER_NEAREST);
  laid.copyTo(map.pixels(), valid == 255);
}

ingest::GridBounds bounds_of(const std::vector<PhotoResult>& photos) {
  ingest::GridBounds b;
  for (const PhotoResult& r : photos) {
    const features::GridImage& p = r.patch;
    b.extend({r.camera.east_m + p.west_m, r.camera.north_m + p.north_m - p.pixels.rows * p.gsd_m,
              r.camera.east_m + p.west_m + p.pixels.cols * p.gsd_m, r.camera.north_m + p.north_m});
    b.extend({r.tag.east_m, r.tag.north_m, r.tag.east_m, r.tag.north_m});
  }
  const double margin = 0.04 * std::max(b.east_m - b.west_m, b.north_m - b.south_m);
  return {b.west_m - margin, b.south_m - margin, b.east_m + margin, b.north_m + margin};
}

}  // namespace

cv::Mat draw_photos(const std::vector<PhotoResult>& photos, const nav::MapSource& map) {
  const Place common = summarize(photos).common_offset.value_or(Place{});
  std::vector<PhotoResult> drawn;
  for (const PhotoResult& photo : photos)
    if (!photo.patch.pixels.empty()) drawn.push_back(as_drawn(photo, common));
  if (drawn.empty()) {
    cv::Mat empty(200, kPanelPx, CV_8UC3, cv::Scalar(24, 24, 24));
    draw_text(empty, "no photograph could be rectified: the table says why", {20, 100});
    return empty;
  }
  MapPicture outlines(map, bounds_of(drawn), kPanelPx);
  MapPicture laid = outlines;
  laid.pixels() = outlines.pixels().clone();
  for (const PhotoResult& r : drawn)
    if (r.accepted) lay_over(r, laid);
  for (const PhotoResult& r : drawn) {
    draw_outline(r, outlines);
    draw_outline(r, laid);
  }
  for (const PhotoResult& r : drawn) draw_position(r, outlines);
  for (MapPicture* panel : {&outlines, &laid}) draw_scale_bar(panel->pixels(), panel->px_per_m());
  return with_legend(tiled({outlines.pixels(), laid.pixels()}, 2),
                     {{LegendEntry::Mark::kCross, kYellow, "position by the tags"},
                      {LegendEntry::Mark::kDot, kBlue, "position of the fix"},
                      {LegendEntry::Mark::kLine, kBlue, "footprint of a fix"},
                      {LegendEntry::Mark::kDashed, kVermilion, "no fix: footprint by tags and common offset"}});
}

}  // namespace landfix::eval
