// Coarser tiles of u8 layers: means of the pixels that have data, in integers.
#pragma once

#include <array>

#include "builder/layers/layer.h"

namespace landfix::layers {

/// Every `side`x`side` pixels of a CV_8UC(1-3) image become their mean, rounded half up, over those with data
/// (not 0 in all channels). There is data where at least half of them have some; it is never 0 in all channels.
cv::Mat box_mean(const cv::Mat& image, int side);

/// The parent of four tiles by box_mean of 2x2 pixels; empty where no pixel has data.
TileData mean_of_children(const std::array<TileData, 4>& children);

/// The region of child `quadrant` (north-west, north-east, south-west, south-east) in a mosaic of the four.
cv::Rect quadrant_region(int quadrant);

}  // namespace landfix::layers
