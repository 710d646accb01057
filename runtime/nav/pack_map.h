// A pack as the map that localization asks.
#pragma once

#include "landfix/landfix.hpp"
#include "runtime/nav/map_source.h"

namespace landfix::nav {

/// The layer "gray" of a pack and its heights (the assumed plane where it has none). The pack must outlive it.
/// Compressed tiles must have been prepared. Without a gray layer every read fails with kMapError.
class PackMap : public MapSource {
 public:
  explicit PackMap(const Pack& pack);

  std::pair<double, double> gsd_range_m() const override;
  nav::Status read_gray(double west_m, double south_m, double east_m, double north_m, double gsd_m,
                        features::GridImage& window) const override;
  std::optional<double> ground_height_m(double east_m, double north_m) const override;

 private:
  const Pack& pack_;
  uint32_t gray_ = 0;
  uint8_t nodata_ = 0;
  std::pair<double, double> gsd_range_m_{0, 0};
};

}  // namespace landfix::nav
