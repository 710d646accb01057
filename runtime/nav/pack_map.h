// A pack as the map that localization asks.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "landfix/landfix.hpp"
#include "runtime/nav/map_source.h"

namespace landfix::nav {

/// Days since 1970-01-01 of "2009-08-18", as packs write capture dates; nothing for anything else.
std::optional<int> day_of(const char* date);

/// The layers gray, edge, contour and orientation of a pack and its heights (the assumed plane where it has none). The
/// pack must outlive it. Compressed tiles must have been prepared. One object per thread: it keeps a buffer.
class PackMap : public MapSource {
 public:
  explicit PackMap(const Pack& pack);

  std::pair<double, double> gsd_range_m(MapLayer layer) const override;
  nav::Status read(MapLayer layer, double west_m, double south_m, double east_m, double north_m, double gsd_m,
                   features::GridImage& window) const override;
  std::optional<double> ground_height_m(double east_m, double north_m) const override;
  nav::Status read_heights(double west_m, double south_m, double east_m, double north_m, double gsd_m,
                           features::GridImage& heights) const override;
  std::optional<CaptureDays> capture_days(double west_m, double south_m, double east_m, double north_m) const override;

 private:
  struct Layer {
    bool present = false;
    uint32_t index = 0;
    uint8_t nodata = 0;
    std::pair<double, double> gsd_range_m{0, 0};
  };
  Layer find(const char* name, lf_pixel_type type, int channels) const;
  nav::Status read_bytes(const Layer& layer, const Region& region, features::GridImage& window) const;
  nav::Status read_orientation(const Region& region, features::GridImage& window) const;

  const Pack& pack_;
  std::array<Layer, 4> layers_;  ///< by MapLayer
  Layer heights_;
  mutable std::vector<uint64_t> words_;
};

}  // namespace landfix::nav
