// Photographs with position and attitude in their tags, registered with a map.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "landfix/landfix.hpp"
#include "runtime/nav/camera.h"
#include "tiles/geodesy.h"
#include "tools/eval/trial.h"

namespace landfix::eval {

struct PhotoOptions {
  std::optional<nav::Camera> camera;  ///< absent: from the tags
  double prior_sigma_m = 60;          ///< of the position by the tags, per axis
  cv::Point2d prior_offset_m{0, 0};   ///< added to it, east and north: a wrong belief, to be corrected
  double heading_sigma_rad = 0.0873;  ///< of the heading by the tags (5°)
  double height_sigma = 0.05;         ///< of the height above ground, relative
  MatcherChoice matcher;
  nav::Gate gate = nav::Gate::kStandard;
  int threads = 0;  ///< 0: one per core
};

/// A point of the ground on the map's grid.
struct Place {
  double east_m = 0, north_m = 0;
};

/// What became of one photograph.
struct PhotoResult {
  std::string name;
  std::string reason;         ///< in words why there is no fix; empty for a fix
  std::string word;           ///< the same in one word: word_of(status), or "unusable"
  bool placed = false;        ///< the tags say where it was taken; else nothing below holds
  bool accepted = false;      ///< a fix that passed the gate
  bool turned = false;        ///< the picture was found upside down against its tags
  std::string camera_source;  ///< where the focal length comes from
  tiles::Geodetic tag_place;
  double convergence_rad = 0;  ///< true heading = grid heading + convergence
  Place tag;                   ///< of the camera by its tags
  nav::Attitude attitude;      ///< by the tags, heading from grid north
  double height_above_ground_m = 0;
  double gsd_m = 0;           ///< of the rectified photograph
  features::GridImage patch;  ///< the rectified photograph, relative to the point below the camera
  Place view;                 ///< where the image's centre meets the ground, relative to that point, by the tags
  double known_heights = 0;   ///< share of the patch that heights of the map rectified; the rest lies on a plane
  double on_map = 0;  ///< share of the footprint on the map: at the fix, else at the tags plus the common offset

  // Holds if a match was found, accepted or not.
  bool matched = false;
  nav::Method method = nav::Method::kGray;
  double probability = 0;
  nav::Evidence evidence;
  Place camera;  ///< found: the point below it
  std::array<double, 4> covariance_m2{};
  nav::Similarity similarity;  ///< what heading and height by the tags have wrong
  double rotation_sigma_rad = 0, scale_sigma = 0;
  double milliseconds = 0;

  Place offset() const { return {camera.east_m - tag.east_m, camera.north_m - tag.north_m}; }
  Place image_centre() const;  ///< found, on the ground
};

/// Where a point of the rectified photograph, relative to the camera's ground position, lies by the match.
Place place_of(const PhotoResult& photo, double east_m, double north_m);

/// Of all photographs together.
struct PhotoSummary {
  int photos = 0, placed = 0, accepted = 0;
  std::optional<Place> common_offset;  ///< mean of the accepted ones' offsets without outliers
  std::vector<double> residuals_m;     ///< distances from it, by photograph; NaN where there is no fix
  double median_residual_m = 0, largest_residual_m = 0;  ///< NaN without fixes
};
PhotoSummary summarize(const std::vector<PhotoResult>& photos);

/// Registers every photograph; the order is kept. One that was edited since it was taken is tried upside down, too:
/// image viewers turn pictures and leave the tags of the gimbal as they are. A photograph that cannot be decoded,
/// placed, or taken by the given camera is a result with a reason. `pack_path` is for messages. Throws Error(kIo) where
/// a file cannot be opened.
std::vector<PhotoResult> register_photos(const Pack& pack, const std::string& pack_path,
                                         const std::vector<std::string>& photos, const PhotoOptions& options);

/// Keys are documented in docs/evaluation.md.
nlohmann::ordered_json to_json(const std::vector<PhotoResult>& photos, const tiles::Zone& zone);

/// A line per photograph, and the summary.
std::string to_text(const std::vector<PhotoResult>& photos);

/// The map with outlines, tags and fixes; beside it, the same with the accepted photographs laid over it. CV_8UC3 in
/// OpenCV's order.
cv::Mat draw_photos(const std::vector<PhotoResult>& photos, const nav::MapSource& map);

}  // namespace landfix::eval
