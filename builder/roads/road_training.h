// Learns what roads look like: gradient boosting of trees over profiles of candidates with known truth.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "builder/roads/road_model.h"
#include "builder/roads/road_scales.h"
#include "builder/training/boosting.h"

namespace landfix::landmarks {

struct Line {
  std::vector<cv::Point2d> points;  ///< in pixels; (0.5, 0.5) is the centre of the first
};

/// Rows of features with their class.
template <typename Row>
struct Examples {
  std::vector<Row> rows;
  std::vector<uint8_t> is_road;
};
using TrainingSet = Examples<features::RoadProfile>;   ///< of the first judge
using SecondTrainingSet = Examples<RoadScaleProfile>;  ///< of the second

/// The trees that tell roads from others. Throws Error (kBadInput) without rows of both.
features::BoostedTrees boost(const TrainingSet& set, const BoostingOptions& options);
features::BoostedTrees boost(const SecondTrainingSet& set, const BoostingOptions& options);

enum class Truth {
  kExact,  ///< lines lie on the middle of the road
  kDrawn   ///< drawn by eye, metres beside it
};

/// Adds the candidates of an image (CV_8UC1 or CV_8UC3 at `px_per_m` pixels per metre). Exact lines: roads lie within
/// 1.25 m and 20 degrees of one, others beyond 2.5 m or point elsewhere; those between are left out. Lines that were
/// drawn: of the candidates within 4 m along them the one of the strongest response, others beyond 7 m. Of others as
/// many as four per road, chosen by `seed`.
void add_examples(const cv::Mat& image, std::span<const Line> roads, Truth truth, double px_per_m, uint64_t seed,
                  TrainingSet& set);

/// The same for the second judge: candidates of both scales that the trees of the first one leave, as many of each at
/// most. Places at 2 m are roads within 1.5 m.
void add_examples(const cv::Mat& image, std::span<const Line> roads, Truth truth, double px_per_m, uint64_t seed,
                  const features::BoostedTrees& first, SecondTrainingSet& set);

/// A part of an image (CV_8UC3) of 620 pixels with its lines, as another camera or season may show it: blurred, paler,
/// with exchanged colours, other contrast and noise, all chosen by `seed`. Of six places the one with most road.
struct Example {
  cv::Mat image;
  std::vector<Line> roads;
};
Example varied(const cv::Mat& image, std::span<const Line> roads, uint64_t seed);

}  // namespace landfix::landmarks
