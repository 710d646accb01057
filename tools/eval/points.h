// How well landmarks and intersections that were found agree with points that are known, and with what another image
// of the place shows.
#pragma once

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "builder/ingest/bounds.h"
#include "tiles/geodesy.h"

namespace landfix::eval {

struct KnownPoint {
  cv::Point2d at;      ///< grid east and north
  bool sure = true;    ///< what is not counts neither way
  double reach_m = 0;  ///< half its length, where it is known: a landmark as near to an unsure one counts neither way
  std::string name;    ///< its `id`, else its number in the file
};

/// Points (or the middle of the smallest rectangle around polygons) of a vector file whose `kind` is this word, or
/// that have none where `any` is set. `sure` and `length_m` where the file has them. Throws as ingest::read_vectors.
std::vector<KnownPoint> read_known_points(const std::string& path, const std::string& kind, bool any,
                                          const tiles::Zone& zone, const ingest::GridBounds& bounds);

/// The rectangle around all polygons of a file, on the zone's grid.
ingest::GridBounds read_extent(const std::string& path, const tiles::Zone& zone, const ingest::GridBounds& bounds);

struct FoundPoint {
  cv::Point2d at;
  double confidence = 1;
};

/// What became of the found and the known.
struct PointMatch {
  /// Of every found one: whether it is right; nullopt where it counts neither way.
  std::vector<std::optional<bool>> right;
  std::vector<double> distance_m;  ///< of every known one to the found one that it is matched with, else NaN
  size_t sure = 0, sure_found = 0;

  size_t found() const;  ///< that count
  size_t found_right() const;
  double recall() const { return sure > 0 ? double(sure_found) / double(sure) : 0; }
  double precision() const { return found() > 0 ? double(found_right()) / double(found()) : 0; }
};

/// One to one, the nearest pairs first, within `reach_m`. Found ones outside of `extent` are right or count neither
/// way; so do those matched with an unsure point, and those unmatched near one.
PointMatch match_points(std::span<const FoundPoint> found, std::span<const KnownPoint> known,
                        const ingest::GridBounds& extent, double reach_m);

/// How often landmarks of a confidence are right: ten equal steps.
struct Reliability {
  struct Step {
    size_t count = 0, right = 0;
    double confidence = 0;  ///< mean
  };
  std::vector<Step> steps;
};
Reliability reliability_of(std::span<const FoundPoint> found, const PointMatch& match);

/// Recall and precision by distance, then by confidence at `reach_m`, then reliability.
struct PointReport {
  struct Row {
    double reach_m = 0, confidence = 0;
    size_t sure = 0, sure_found = 0, found = 0, right = 0;
  };
  std::vector<Row> by_distance, by_confidence;
  Reliability reliability;
};
PointReport report_points(std::span<const FoundPoint> found, std::span<const KnownPoint> known,
                          const ingest::GridBounds& extent, double reach_m, double confidence);

std::string to_text(const PointReport& report);
nlohmann::ordered_json to_json(const PointReport& report);

/// Of `a` those that `b` shows within `reach_m`, one to one.
size_t found_again(std::span<const FoundPoint> a, std::span<const FoundPoint> b, double reach_m);

}  // namespace landfix::eval
