// What tells objects on the ground apart: trees over the numbers of a pixel, then over those of a region.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "builder/training/platt.h"
#include "runtime/features/boosted_trees.h"
#include "tiles/landmark.h"

namespace landfix::landmarks {

/// What a pixel shows. Ground is whatever is none of the others: fields, grass, bare soil.
enum class Cover : uint8_t { kGround = 0, kBuilding = 1, kTree = 2, kWater = 3, kPaved = 4 };
inline constexpr size_t kCovers = 5;
inline constexpr uint8_t kNoCover = 255;  ///< of a pixel without data, in images of covers

/// The cover that landmarks of a class consist of.
Cover cover_of(tiles::LandmarkClass cls);

struct ObjectModel {
  /// For images with colour, or for those without.
  struct Part {
    features::BoostedTrees covers;                                      ///< of a pixel, one output per cover
    std::array<features::BoostedTrees, tiles::kLandmarkClasses> whole;  ///< that a region is one whole landmark
    std::array<Sigmoid, tiles::kLandmarkClasses> probability;           ///< from their score; a <= 0
  };
  Part colour, gray;

  /// "LFOB", u32 version 1, then colour and gray: the covers' trees, those of every class, f32 a and b of every class.
  std::vector<uint8_t> serialise() const;
};

/// The inverse of serialise(). Throws Error (kBadInput) naming `name` where the bytes are not such a model.
ObjectModel parse_object_model(std::span<const uint8_t> bytes, const std::string& name);

/// Reads a file of them. Throws Error: kIo where it cannot be read, else as above.
ObjectModel read_object_model(const std::string& path);

/// The model that comes with landfix (share/objects.model; tools/landmarks/train_objects.sh made it).
const ObjectModel& default_object_model();

}  // namespace landfix::landmarks
