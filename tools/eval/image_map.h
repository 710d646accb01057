// One image as a map in memory: every layer that a matcher asks for, computed as the builder and the camera do.
#pragma once

#include <array>
#include <vector>

#include "runtime/nav/map_source.h"

namespace landfix::eval {

/// Gray, edge, contour and orientation of one image. Coarser levels are made of the image halved again and again, each
/// pixel the mean of 2×2; their pixels line up with the image's north-western corner. Safe to read from many threads.
class ImageMap : public nav::MapSource {
 public:
  /// `image`: CV_8UC1 or CV_8UC3 (red, green, blue). Throws cv::Exception for other types.
  explicit ImageMap(const features::GridImage& image, int levels = 1, double ground_height_m = 0);

  std::pair<double, double> gsd_range_m(nav::MapLayer layer) const override;
  nav::Status read(nav::MapLayer layer, double west_m, double south_m, double east_m, double north_m, double gsd_m,
                   features::GridImage& window) const override;
  std::optional<double> ground_height_m(double, double) const override { return ground_height_m_; }

 private:
  using Level = std::array<features::GridImage, 4>;  ///< by MapLayer
  std::vector<Level> levels_;                        ///< finest first
  double ground_height_m_;
};

}  // namespace landfix::eval
