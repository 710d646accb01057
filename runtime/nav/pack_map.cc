#include "runtime/nav/pack_map.h"

#include <algorithm>

namespace landfix::nav {
namespace {

constexpr double kMaxPixels = 1 << 26;  ///< of one window: a wrong covariance must not ask for gigabytes

}  // namespace

PackMap::PackMap(const Pack& pack) : pack_(pack) {
  const Result<uint32_t> gray = pack.find_layer("gray");
  if (!gray) return;
  const Result<lf_layer_info> layer = pack.layer(*gray);
  if (!layer || layer->level_count == 0 || layer->pixel_type != LF_U8 || layer->channels != 1) return;
  const Result<lf_level_info> finest = pack.level(*gray, 0), coarsest = pack.level(*gray, layer->level_count - 1);
  if (!finest || !coarsest) return;
  gray_ = *gray;
  nodata_ = uint8_t(layer->nodata);
  gsd_range_m_ = {finest->gsd_m, coarsest->gsd_m};
}

std::pair<double, double> PackMap::gsd_range_m() const { return gsd_range_m_; }

nav::Status PackMap::read_gray(double west_m, double south_m, double east_m, double north_m, double gsd_m,
                               features::GridImage& window) const {
  if (gsd_range_m_.first <= 0) return nav::Status::kMapError;
  const Result<Region> region = pack_.box(gray_, west_m, south_m, east_m, north_m, gsd_m);
  if (!region) return region.status() == LF_OUTSIDE_MAP ? nav::Status::kOutsideMap : nav::Status::kMapError;
  if (double(region->width) * region->height > kMaxPixels) return nav::Status::kTooLarge;
  try {
    window.west_m = region->west_m;
    window.north_m = region->north_m;
    window.gsd_m = region->gsd_m;
    window.pixels.create(int(region->height), int(region->width), CV_8U);
    const std::span<uint8_t> out(window.pixels.data, window.pixels.total());
    if (pack_.read(*region, out, size_t(region->width)) != LF_OK) return nav::Status::kMapError;
    cv::compare(window.pixels, nodata_, window.valid, cv::CMP_NE);
    const int count = cv::countNonZero(window.valid);
    if (count == int(window.pixels.total())) window.valid.release();
    return count ? nav::Status::kOk : nav::Status::kOutsideMap;
  } catch (...) {
    return nav::Status::kInternal;
  }
}

std::optional<double> PackMap::ground_height_m(double east_m, double north_m) const {
  const Result<Height> height = pack_.height(east_m, north_m);
  return height ? std::optional(height->height_m) : std::nullopt;
}

}  // namespace landfix::nav
