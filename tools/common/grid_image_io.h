// Grid images as files that people and GIS programs open.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "runtime/features/grid_image.h"
#include "tiles/geodesy.h"

namespace landfix::tools {

/// Colours for people: gray and RGB as they are, heights (CV_32F) shaded from the north-west over a colour ramp; pixels
/// without data are transparent. Returns CV_8UC4 in OpenCV's order (blue, green, red, alpha).
cv::Mat picture_of(const features::GridImage& image);

/// Writes a PNG by picture_of, or a GeoTIFF with the values themselves, by the extension of `path` (.png, .tif, .tiff),
/// atomically. Throws Error(kUsage) for another extension and Error(kIo) where writing fails.
void write_grid_image(const std::string& path, const features::GridImage& image, const tiles::Zone& zone);

/// Colours of the values 0, 1, ... of an image of classes (red, green, blue).
using Palette = std::vector<std::array<uint8_t, 3>>;

/// Writes CV_8UC1 classes as a GeoTIFF that GIS programs show in these colours. Throws likewise.
void write_class_map(const std::string& path, const features::GridImage& classes, const Palette& palette,
                     const tiles::Zone& zone);

}  // namespace landfix::tools
