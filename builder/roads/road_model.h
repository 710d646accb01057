// What tells roads from all else that is long and even: trees over profiles, for colour and for gray images.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "runtime/features/boosted_trees.h"

namespace landfix::landmarks {

struct RoadModel {
  /// Two judges: the first sees the profile of a place at one scale, the second, asked about what the first leaves, all
  /// that RoadScales describes.
  struct Judges {
    features::BoostedTrees first, second;
  };
  Judges colour, gray;

  std::vector<uint8_t> serialise() const;  ///< the judges for colour, then those for gray
};

/// The inverse of serialise(). Throws Error (kBadInput) naming `name` where the bytes are not such a model.
RoadModel parse_road_model(std::span<const uint8_t> bytes, const std::string& name);

/// Reads a file of them. Throws Error: kIo where it cannot be read, else as above.
RoadModel read_road_model(const std::string& path);

/// The model that comes with landfix (share/roads.model; tools/landmarks/train_roads.sh made it).
const RoadModel& default_road_model();

}  // namespace landfix::landmarks
