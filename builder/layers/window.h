// Where tiles lie in a window of the sources, and what its newest epochs show there.
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "builder/ingest/image_set.h"
#include "tiles/grid.h"

namespace landfix::layers {

/// What a tile covers, in pixels of a finer or equal level. Also for tiles of levels beyond the grid's.
tiles::PixelRect pixels_of(const tiles::TileIndex& tile, int level);

/// The common part of two rectangles of one level; width and height 0 where they do not overlap.
tiles::PixelRect intersection(const tiles::PixelRect& a, const tiles::PixelRect& b);

/// `inner` as a region of the image whose pixels are those of `outer`, which contains it.
cv::Rect region_of(const tiles::PixelRect& inner, const tiles::PixelRect& outer);

/// A rectangle with `px` more pixels on every side.
tiles::PixelRect grown(const tiles::PixelRect& rect, int px);

/// What one sees from above: at every pixel the newest epoch with data.
struct Newest {
  cv::Mat pixels;                ///< CV_8UC1 or CV_8UC3; empty where no pixel has data
  cv::Mat owner;                 ///< CV_16UC1: whose pixel it is, one more than the index in `epochs`; 0: no data
  std::vector<uint16_t> epochs;  ///< indices in ImageSet::epochs() of those that are seen, ascending
};

/// What the newest epoch with data shows at every pixel of `rect` (which may reach beyond the stack's own rectangle).
/// `channels` 1: gray, data within 1 to 255; 3: red, green, blue, data never black but at least (1, 1, 1). 0 where
/// there is no data. Epochs without some of red, green and blue: gray stands for all of them; else gray is the rounded
/// mean of the visible bands present, and the three channels are near infrared, red, green as in a false-colour print;
/// near infrared alone is taken as gray.
Newest newest(const ingest::Stack& stack, const tiles::PixelRect& rect, int channels);

/// What `newest` of the pixels `rect` shows at those of `part`, which may reach beyond it. Empty where nothing;
/// `epochs` and the numbers in `owner` stay those of `newest`.
Newest cut(const Newest& newest, const tiles::PixelRect& rect, const tiles::PixelRect& part);

/// The epochs that are seen in a region, as Newest::epochs.
std::vector<uint16_t> epochs_in(const Newest& newest, const cv::Rect& region);

/// Calls `visit` with the mask (255 or 0) of every epoch that is seen.
void for_each_epoch(const Newest& newest, const std::function<void(const cv::Mat& mask)>& visit);

}  // namespace landfix::layers
