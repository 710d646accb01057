// Orientation of every epoch in a window: what the layers `orientation` and `agreement` are made of.
#pragma once

#include <vector>

#include "builder/ingest/image_set.h"
#include "runtime/features/orientation.h"

namespace landfix::layers {

struct DatedStack {
  std::vector<features::DatedOrientation> dates;  ///< of one size; only those with a valid pixel
  std::vector<uint16_t> epochs;                   ///< their indices in ImageSet::epochs(), ascending
};

/// Orientation of each epoch from all its bands, at the pixels of `rect`. The same as that of the whole epoch cut to
/// `rect`, where `stack` has kOrientationHaloPx more pixels around it.
DatedStack dated_orientation(const ingest::Stack& stack, const tiles::PixelRect& rect,
                             const features::OrientationOptions& options);

}  // namespace landfix::layers
