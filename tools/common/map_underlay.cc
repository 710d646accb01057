#include "tools/common/map_underlay.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "tools/common/drawing.h"
#include "tools/common/navigability_style.h"
#include "tools/common/open_pack.h"

namespace landfix::tools {
namespace {

constexpr double kDarkest = 0.5;  // share of a colour that is left where the map below is black

std::optional<uint32_t> layer_to_show(const Pack& pack, double pixel_m) {
  const Result<uint32_t> overview = pack.find_layer("overview"), gray = pack.find_layer("gray");
  if (overview && (!gray || pack.level(*overview, 0)->gsd_m <= 2 * pixel_m)) return *overview;
  return gray ? std::optional(*gray) : std::nullopt;
}

// What both the map and the frame hold, at about the pixels of the frame.
std::optional<features::GridImage> shown_part(const Pack& pack, uint32_t layer, const MapFrame& frame,
                                              const std::string& path) {
  const uint32_t levels = pack.layer(layer)->level_count;
  const double gsd_m =
      level_to_draw({pack.level(layer, 0)->gsd_m, pack.level(layer, levels - 1)->gsd_m}, 1 / frame.px_per_m);
  const lf_info map = pack.info();
  const double west_m = std::max(map.west_m, frame.west_m), north_m = std::min(map.north_m, frame.north_m),
               east_m = std::min(map.east_m, frame.west_m + frame.size.width / frame.px_per_m),
               south_m = std::max(map.south_m, frame.north_m - frame.size.height / frame.px_per_m);
  if (west_m >= east_m || south_m >= north_m) return std::nullopt;
  const Result<Region> region = pack.box(layer, west_m, south_m, east_m, north_m, gsd_m);
  if (!region) return std::nullopt;
  return read_region(pack, *region, path);
}

}  // namespace

cv::Mat map_in_gray(const Pack& pack, const MapFrame& frame, const std::string& pack_path) {
  const std::optional<uint32_t> layer = layer_to_show(pack, 1 / frame.px_per_m);
  if (!layer) return {};
  cv::Mat out(frame.size, CV_8UC1, cv::Scalar(kNothingShown));
  const std::optional<features::GridImage> image = shown_part(pack, *layer, frame, pack_path);
  if (!image) return out;
  cv::Mat shown = image->pixels;
  if (shown.channels() == 3) cv::cvtColor(shown, shown, cv::COLOR_RGB2GRAY);
  shown.setTo(kNothingShown, ~image->valid);
  const double scale = image->gsd_m * frame.px_per_m;
  const cv::Point2d corner = frame.at(image->west_m, image->north_m);
  const cv::Matx23d place(scale, 0, corner.x + 0.5 * scale, 0, scale, corner.y + 0.5 * scale);
  cv::warpAffine(shown, out, place, frame.size, cv::INTER_LINEAR, cv::BORDER_CONSTANT, kNothingShown);
  return out;
}

cv::Mat coloured_map(const cv::Mat& map, const cv::Mat& colours, const cv::Mat& where) {
  cv::Mat out(colours.size(), CV_8UC3, cv::Scalar::all(kNothingShown)), shaded = colours, light;
  if (!map.empty()) {
    cv::cvtColor(map, out, cv::COLOR_GRAY2BGR);
    out.convertTo(light, CV_8UC3, 1 - kDarkest, 255 * kDarkest);
    cv::multiply(colours, light, shaded, 1 / 255.0);
  }
  shaded.copyTo(out, where);
  return out;
}

cv::Scalar colour_of_class(size_t chance_class) {
  const auto& c = kChanceClasses[chance_class].colour;
  return {double(c[2]), double(c[1]), double(c[0])};
}

}  // namespace landfix::tools
