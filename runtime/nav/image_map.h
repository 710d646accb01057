// Images as a map in memory: every layer that a matcher asks for, computed as the builder and the camera do.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "runtime/nav/map_source.h"

namespace landfix::nav {

inline constexpr MapLayer kMapLayers[] = {MapLayer::kGray, MapLayer::kEdge, MapLayer::kContour, MapLayer::kOrientation};

/// A map of one place on ground of one height. Coarser levels are made of the images halved again and again, each pixel
/// the mean of 2×2 and valid where all four are; their pixels line up with the images' north-western corner. Safe to
/// read from many threads.
class ImageMap : public MapSource {
 public:
  /// `dates`: one image per capture date, the newest first, of one size and place; CV_8UC1 or CV_8UC3 and 4 (red,
  /// green, blue, …). Orientation is fused over the dates, all else comes from the newest. Only `layers` are made.
  /// Nothing throws: images that cannot be used make a map without layers.
  ImageMap(std::span<const features::GridImage> dates, int levels, double ground_height_m,
           std::span<const MapLayer> layers = kMapLayers);
  explicit ImageMap(const features::GridImage& image, int levels = 1, double ground_height_m = 0,
                    std::span<const MapLayer> layers = kMapLayers)
      : ImageMap(std::span(&image, 1), levels, ground_height_m, layers) {}

  std::pair<double, double> gsd_range_m(MapLayer layer) const override;
  Status read(MapLayer layer, double west_m, double south_m, double east_m, double north_m, double gsd_m,
              features::GridImage& window) const override;
  std::optional<double> ground_height_m(double, double) const override { return ground_height_m_; }

 private:
  std::array<std::vector<features::GridImage>, std::size(kMapLayers)> layers_;  ///< by MapLayer, finest level first
  double ground_height_m_;
};

}  // namespace landfix::nav
