// A map in memory for flights in tests.
#pragma once

#include <cmath>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <utility>

#include "builder/terrain/scene.h"
#include "runtime/nav/image_map.h"
#include "tools/fly/flight.h"

namespace landfix::fly {

/// An image and heights as the map that the localizer asks; `layers` of the image.
class MemoryMap : public nav::MapSource {
 public:
  MemoryMap(const features::GridImage& image, const features::GridImage& heights,
            std::span<const nav::MapLayer> layers = std::span(nav::kMapLayers, 1))
      : image_(image, 4, 0, layers), scene_(image, heights), heights_(heights) {}

  std::pair<double, double> gsd_range_m(nav::MapLayer layer) const override { return image_.gsd_range_m(layer); }
  nav::Status read(nav::MapLayer layer, double west_m, double south_m, double east_m, double north_m, double gsd_m,
                   features::GridImage& window) const override {
    return image_.read(layer, west_m, south_m, east_m, north_m, gsd_m, window);
  }
  std::optional<double> ground_height_m(double east_m, double north_m) const override {
    return scene_.height_below(east_m, north_m);
  }
  /// Without `tell_heights` the relief is a secret.
  nav::Status read_heights(double west_m, double south_m, double east_m, double north_m, double,
                           features::GridImage& heights) const override {
    if (!tell_heights) return nav::Status::kNoLayer;
    const features::GridImage& all = heights_;
    const cv::Point first(int(std::lround(all.column_of(west_m))), int(std::lround(all.row_of(north_m))));
    const cv::Point last(int(std::lround(all.column_of(east_m))), int(std::lround(all.row_of(south_m))));
    const cv::Rect seen = cv::Rect(first, last) & cv::Rect({0, 0}, all.pixels.size());
    if (seen.empty()) return nav::Status::kOutsideMap;
    heights = {
        all.pixels(seen).clone(), {}, all.west_m + seen.x * all.gsd_m, all.north_m - seen.y * all.gsd_m, all.gsd_m};
    return nav::Status::kOk;
  }

  bool tell_heights = true;

 private:
  nav::ImageMap image_;
  terrain::Scene scene_;
  features::GridImage heights_;
};

}  // namespace landfix::fly
