// What covers the ground of an image by vector data, and the places of it that show one class clearly.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "builder/ingest/bounds.h"
#include "builder/ingest/vectors.h"
#include "builder/landmarks/kinds.h"
#include "builder/training/chips.h"

namespace landfix::landmarks {

struct PlaceOptions {
  uint64_t seed = 1;
  int per_class = 25;  ///< places of every class, at most
};

/// Masks (CV_8UC1, 0 or 1) over an image at features::kWordGsdM.
class Cover {
 public:
  explicit Cover(const features::GridImage& image);

  /// Polygons are filled, lines `size_m` wide, points circles of radius `size_m`. Parts beyond the image do not matter.
  void add(Kind kind, const ingest::VectorPart& part, double size_m);

  /// Fields are wherever nothing else is: for data that are complete.
  void open_elsewhere();

  /// Draws places. Building: within 4 m of one's centre. Tree: crowns cover 40 % of the 20 m and 30 % of the 40 m
  /// around. Water: 92 % of 40 m. Paved: roads and squares cover 40 % of 20 m. Field: open ground, nothing else on 92 %
  /// of 20 m and on 55 % of 40 m, half of the places within 45 m of a building where there are such: lawns and yards
  /// must not be taken for what stands beside them. All have data around them and Chip::place 0.
  std::vector<Chip> draw(const PlaceOptions& options) const;

 private:
  const features::GridImage& image_;
  cv::Mat building_, tree_, paved_, water_, field_;
  std::vector<cv::Point2d> centres_;  ///< of buildings, pixels
};

}  // namespace landfix::landmarks
