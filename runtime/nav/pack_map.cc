#include "runtime/nav/pack_map.h"

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "runtime/features/orientation_code.h"

namespace landfix::nav {
namespace {

constexpr double kMaxPixels = 1 << 26;  ///< of one window: a wrong covariance must not ask for gigabytes

void leave_out_if_full(features::GridImage& window) {
  if (cv::countNonZero(window.valid) == int(window.valid.total())) window.valid.release();
}

/// Gives an image the georeference of the region that is to be read into it, or says why there is none.
nav::Status place(const Result<Region>& region, features::GridImage& image) {
  if (!region) return region.status() == LF_OUTSIDE_MAP ? nav::Status::kOutsideMap : nav::Status::kMapError;
  if (double(region->width) * region->height > kMaxPixels) return nav::Status::kTooLarge;
  image.west_m = region->west_m;
  image.north_m = region->north_m;
  image.gsd_m = region->gsd_m;
  return nav::Status::kOk;
}

}  // namespace

std::optional<int> day_of(const char* date) {
  int year = 0, month = 0, day = 0;
  char rest = 0;
  if (std::sscanf(date, "%4d-%2d-%2d%c", &year, &month, &day, &rest) != 3) return std::nullopt;
  const std::chrono::year_month_day ymd{std::chrono::year(year), std::chrono::month(unsigned(month)),
                                        std::chrono::day(unsigned(day))};
  if (!ymd.ok()) return std::nullopt;
  return int(std::chrono::sys_days(ymd).time_since_epoch().count());
}

PackMap::PackMap(const Pack& pack)
    : pack_(pack),
      layers_{find("gray", LF_U8, 1), find("edge", LF_U8, 1), find("contour", LF_U8, 1),
              find("orientation", LF_BIT, features::kOrientationPlanes)},
      heights_(find("height", LF_I16, 1)) {}

PackMap::Layer PackMap::find(const char* name, lf_pixel_type type, int channels) const {
  const Result<uint32_t> index = pack_.find_layer(name);
  if (!index) return {};
  const Result<lf_layer_info> info = pack_.layer(*index);
  if (!info || info->level_count == 0 || info->pixel_type != type || info->channels != channels) return {};
  const Result<lf_level_info> finest = pack_.level(*index, 0), coarsest = pack_.level(*index, info->level_count - 1);
  if (!finest || !coarsest) return {};
  return {true, *index, uint8_t(info->nodata), {finest->gsd_m, coarsest->gsd_m}};
}

std::pair<double, double> PackMap::gsd_range_m(MapLayer layer) const { return layers_[size_t(layer)].gsd_range_m; }

nav::Status PackMap::read_bytes(const Layer& layer, const Region& region, features::GridImage& window) const {
  window.pixels.create(int(region.height), int(region.width), CV_8U);
  const std::span<uint8_t> out(window.pixels.data, window.pixels.total());
  if (pack_.read(region, out, size_t(region.width)) != LF_OK) return nav::Status::kMapError;
  cv::compare(window.pixels, layer.nodata, window.valid, cv::CMP_NE);
  return nav::Status::kOk;
}

nav::Status PackMap::read_orientation(const Region& region, features::GridImage& window) const {
  const size_t row_words = (region.width + 63) / 64, plane_words = row_words * region.height;
  words_.resize(plane_words * features::kOrientationPlanes);
  if (pack_.read_bits(region, words_, row_words, plane_words) != LF_OK) return nav::Status::kMapError;
  features::unpack_orientation(words_.data(), row_words, plane_words, {int(region.width), int(region.height)},
                               window.pixels, window.valid);
  return nav::Status::kOk;
}

nav::Status PackMap::read(MapLayer which, double west_m, double south_m, double east_m, double north_m, double gsd_m,
                          features::GridImage& window) const {
  const Layer& layer = layers_[size_t(which)];
  if (!layer.present) return nav::Status::kNoLayer;
  const Result<Region> region = pack_.box(layer.index, west_m, south_m, east_m, north_m, gsd_m);
  if (const nav::Status s = place(region, window); s != nav::Status::kOk) return s;
  try {
    const nav::Status status =
        which == MapLayer::kOrientation ? read_orientation(*region, window) : read_bytes(layer, *region, window);
    if (status != nav::Status::kOk) return status;
    if (cv::countNonZero(window.valid) == 0) return nav::Status::kOutsideMap;
    leave_out_if_full(window);
    return nav::Status::kOk;
  } catch (...) {
    return nav::Status::kInternal;
  }
}

std::optional<double> PackMap::ground_height_m(double east_m, double north_m) const {
  const Result<Height> height = pack_.height(east_m, north_m);
  return height ? std::optional(height->height_m) : std::nullopt;
}

nav::Status PackMap::read_heights(double west_m, double south_m, double east_m, double north_m, double gsd_m,
                                  features::GridImage& heights) const {
  if (!heights_.present) return nav::Status::kNoLayer;
  const Result<Region> region = pack_.box(heights_.index, west_m, south_m, east_m, north_m, gsd_m);
  if (const nav::Status s = place(region, heights); s != nav::Status::kOk) return s;
  try {
    heights.pixels.create(int(region->height), int(region->width), CV_32FC1);
    heights.valid.release();
    const std::span<float> out(heights.pixels.ptr<float>(), heights.pixels.total());
    return pack_.read_heights(*region, out, heights.pixels.step[0]) == LF_OK ? nav::Status::kOk
                                                                             : nav::Status::kMapError;
  } catch (...) {
    return nav::Status::kInternal;
  }
}

std::optional<CaptureDays> PackMap::capture_days(double west_m, double south_m, double east_m, double north_m) const {
  // Of what registration uses first: the layers of a pack are made of the same images.
  for (const MapLayer which : {MapLayer::kOrientation, MapLayer::kGray, MapLayer::kEdge, MapLayer::kContour}) {
    const Layer& layer = layers_[size_t(which)];
    if (!layer.present) continue;
    const Result<Region> region = pack_.box(layer.index, west_m, south_m, east_m, north_m, layer.gsd_range_m.first);
    if (!region) continue;
    const Result<EpochRange> range = pack_.epochs(*region);
    if (!range || range->dated_tiles < range->tiles) continue;
    const Result<lf_epoch_info> newest = pack_.epoch(range->newest), oldest = pack_.epoch(range->oldest);
    if (!newest || !oldest) continue;
    const std::optional<int> first = day_of(oldest->date), last = day_of(newest->date);
    if (first && last) return CaptureDays{*first, *last};
  }
  return std::nullopt;
}

}  // namespace landfix::nav
