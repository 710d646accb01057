// Learns a model of objects from images in which they are known.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "builder/landmarks/object_model.h"
#include "builder/training/object_truth.h"

namespace landfix::landmarks {

struct ObjectTrainingOptions {
  uint64_t seed = 1;
  int variations = 3;  ///< of every scene, as other cameras and seasons may show it; the scene itself comes on top
  std::function<void(const std::string&)> on_progress;
};

/// First the covers of pixels, then which regions are whole objects, at last the probabilities. Scenes are divided into
/// two groups, every other one: what is learnt of regions, and their probabilities, comes of covers that were learnt
/// from the other group. The same bytes for the same scenes. Throws Error (kBadInput) where a cover is missing, or
/// whole objects of any class.
ObjectModel train_objects(std::span<const KnownScene> scenes, const ObjectTrainingOptions& options);

}  // namespace landfix::landmarks
