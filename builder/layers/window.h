// Where tiles lie in a window of the sources, and what its newest epochs show there.
#pragma once

#include <opencv2/core.hpp>

#include "builder/ingest/image_set.h"
#include "tiles/grid.h"

namespace landfix::layers {

/// What a tile covers, in pixels of a finer or equal level. Also for tiles of levels beyond the grid's.
tiles::PixelRect pixels_of(const tiles::TileIndex& tile, int level);

/// The common part of two rectangles of one level; width and height 0 where they do not overlap.
tiles::PixelRect intersection(const tiles::PixelRect& a, const tiles::PixelRect& b);

/// `inner` as a region of the image whose pixels are those of `outer`, which contains it.
cv::Rect region_of(const tiles::PixelRect& inner, const tiles::PixelRect& outer);

/// What the newest epoch with data shows at every pixel of `rect` (which may reach beyond the stack's own rectangle).
/// `channels` 1: gray, data within 1 to 255; 3: red, green, blue, data never black but at least (1, 1, 1). 0 where
/// there is no data. Epochs without some of red, green and blue: gray stands for all of them; else gray is the rounded
/// mean of the visible bands present, and the three channels are near infrared, red, green as in a false-colour print;
/// near infrared alone is taken as gray. Empty where no pixel has data.
cv::Mat newest(const ingest::Stack& stack, const tiles::PixelRect& rect, int channels);

}  // namespace landfix::layers
