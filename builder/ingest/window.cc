#include "builder/ingest/window.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "builder/error.h"
#include "builder/ingest/elevation.h"
#include "builder/ingest/image_set.h"
#include "builder/ingest/pixel_window.h"
#include "builder/ingest/raster.h"

namespace landfix::ingest {
namespace {

constexpr int64_t kMostPixels = int64_t(1) << 29;
constexpr int kBlock = 1024;  ///< pixels a side that are read at once

/// An image of zeros without data for `window`.
features::GridImage blank(const PixelWindow& window, int type, const std::string& path) {
  if (window.width > kMostPixels / window.height) {
    throw Error(ExitCode::kBadInput,
                fmt::format("{}: {} x {} pixels are too many for one image: choose a coarser GSD or a smaller area",
                            path, window.width, window.height));
  }
  const cv::Size size(int(window.width), int(window.height));
  return {cv::Mat::zeros(size, type), cv::Mat::zeros(size, CV_8UC1), double(window.column) * window.gsd_m,
          -double(window.row) * window.gsd_m, window.gsd_m};
}

/// Calls `read` with the blocks of a window and their place in it, in parallel.
template <typename Read>
void for_each_block(const PixelWindow& window, const Read& read) {
  const int columns = int((window.width + kBlock - 1) / kBlock), rows = int((window.height + kBlock - 1) / kBlock);
  const cv::Rect all(0, 0, int(window.width), int(window.height));
  tbb::parallel_for(0, columns * rows, [&](int i) {
    const cv::Rect place = cv::Rect((i % columns) * kBlock, (i / columns) * kBlock, kBlock, kBlock) & all;
    read(PixelWindow{window.gsd_m, window.column + place.x, window.row + place.y, place.width, place.height}, place);
  });
}

}  // namespace

features::GridImage load_image(const SourceOptions& file, const tiles::Zone& zone, std::optional<GridBounds> bounds,
                               double gsd_m) {
  const ImageSet images(std::span(&file, 1), zone);
  const Source& source = images.sources()[0];
  // Roles are in ascending order: red, green, blue are neighbours, possibly after gray.
  const auto red = std::find(source.bands.begin(), source.bands.end(), BandRole::kRed);
  const auto has = [&](BandRole role) {
    return std::find(source.bands.begin(), source.bands.end(), role) != source.bands.end();
  };
  const bool colour = red != source.bands.end() && has(BandRole::kGreen) && has(BandRole::kBlue);
  const int first = colour ? int(red - source.bands.begin()) : 0;
  const PixelWindow window = window_covering(bounds.value_or(source.bounds), gsd_m > 0 ? gsd_m : source.gsd_m);
  features::GridImage image = blank(window, colour ? CV_8UC3 : CV_8UC1, file.path);
  for_each_block(window, [&](const PixelWindow& block, const cv::Rect& place) {
    for (const Epoch& epoch : images.read(block)) {
      const std::vector<int> from_to =
          colour ? std::vector<int>{first, 0, first + 1, 1, first + 2, 2} : std::vector<int>{0, 0};
      cv::Mat target = image.pixels(place);
      cv::mixChannels(&epoch.bands, 1, &target, 1, from_to.data(), from_to.size() / 2);
      epoch.valid.copyTo(image.valid(place));
    }
  });
  return image;
}

features::GridImage load_elevation(const SourceOptions& file, const tiles::Zone& zone, std::optional<GridBounds> bounds,
                                   double gsd_m) {
  const ElevationModel model(file, zone);
  const PixelWindow window = window_covering(bounds.value_or(model.source().bounds), gsd_m > 0 ? gsd_m : model.gsd_m());
  features::GridImage image = blank(window, CV_32FC1, file.path);
  for_each_block(window, [&](const PixelWindow& block, const cv::Rect& place) {
    const features::GridImage part = model.read(block);
    part.pixels.copyTo(image.pixels(place));
    part.valid.copyTo(image.valid(place));
  });
  return image;
}

tiles::Zone standard_zone_of(const std::string& path) {
  const Raster raster(path, std::make_shared<HandlePool>());
  const auto zone = tiles::standard_zone(raster.centre());
  if (!zone) throw Error(ExitCode::kBadInput, fmt::format("{}: its centre lies in no zone", path));
  return *zone;
}

GridBounds bounds_of(const features::GridImage& image) {
  return {image.west_m, image.north_m - image.pixels.rows * image.gsd_m, image.west_m + image.pixels.cols * image.gsd_m,
          image.north_m};
}

}  // namespace landfix::ingest
