// Labelled places by vector data: of the worlds that `landfix synth` draws, and of maps over any image.
#pragma once

#include <string>
#include <vector>

#include "builder/landmarks/known.h"
#include "builder/training/cover.h"

namespace landfix::landmarks {

/// Places of a world in `folder` (ortho.tif; buildings, trees, roads, water .geojson), a place of training all in all.
/// Throws Error: kIo for a missing file, kBadInput for one that cannot be used or a world without any place.
LabelledImage read_world(const std::string& folder, const PlaceOptions& options);

/// Places of an image by vector layers (landmarks/known.h); fields where a layer says so. Squares of 200 m are places
/// of training, and what lies across their borders is left out: neighbours never are in both halves. Throws Error as
/// read_known, and kBadInput where no place shows one class clearly.
LabelledImage read_mapped(const std::string& image_path, const std::vector<VectorInput>& inputs,
                          const PlaceOptions& options);

}  // namespace landfix::landmarks
