#include "builder/training/truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "builder/error.h"
#include "builder/ingest/window.h"

namespace landfix::landmarks {
namespace {

constexpr double kBlockM = 200, kChipM = 40;  // sides of the squares that are one place, and of what a chip shows
constexpr double kCrownRadiusM = 3;           // of trees that do not say theirs

double size_of(Kind kind, const ingest::Tags& tags) {
  if (kind == Kind::kRoad) return road_width_m(tags);
  return metres_of(tags, "radius_m").value_or(kCrownRadiusM);
}

/// Numbers the squares of ground; chips across a border are dropped.
void split_into_blocks(std::vector<Chip>& chips) {
  const auto block = [](double metres) { return int64_t(std::floor(metres / kBlockM)); };
  std::erase_if(chips, [&](const Chip& c) {
    return block(c.east_m - kChipM / 2) != block(c.east_m + kChipM / 2) ||
           block(c.north_m - kChipM / 2) != block(c.north_m + kChipM / 2);
  });
  std::map<std::pair<int64_t, int64_t>, int> places;
  for (Chip& c : chips)
    c.place = places.try_emplace({block(c.east_m), block(c.north_m)}, int(places.size())).first->second;
}

}  // namespace

LabelledImage read_world(const std::string& folder, const PlaceOptions& options) {
  LabelledImage out;
  out.name = folder;
  out.drawn = true;
  tiles::Zone zone;
  out.image = load_evened(folder + "/ortho.tif", &zone);
  Cover cover(out.image);
  for (const auto& [name, kind] : {std::pair("buildings", Kind::kBuilding), std::pair("trees", Kind::kTree),
                                   std::pair("roads", Kind::kRoad), std::pair("water", Kind::kWater)}) {
    const auto take = [&, kind = kind](const ingest::VectorFeature& feature) {
      const auto what = feature.tags.find("kind");
      if (what != feature.tags.end() && what->second == "track") return;
      for (const ingest::VectorPart& part : feature.parts) cover.add(kind, part, size_of(kind, feature.tags));
    };
    ingest::read_vectors(fmt::format("{}/{}.geojson", folder, name), "", zone, ingest::bounds_of(out.image), take);
  }
  cover.open_elsewhere();
  out.chips = cover.draw(options);
  if (out.chips.empty())
    throw Error(ExitCode::kBadInput,
                folder + ": no place of the world shows one class clearly; draw a larger one with `landfix synth`");
  return out;
}

LabelledImage read_mapped(const std::string& image_path, const std::vector<VectorInput>& inputs,
                          const PlaceOptions& options) {
  LabelledImage out;
  out.name = image_path;
  tiles::Zone zone;
  out.image = load_evened(image_path, &zone);
  Cover cover(out.image);
  for (const VectorInput& input : inputs) {
    ingest::read_vectors(input.path, input.layer, zone, ingest::bounds_of(out.image),
                         [&](const ingest::VectorFeature& f) {
                           for (const ingest::VectorPart& part : f.parts)
                             if (const auto kind = kind_of(input, f, part.shape))
                               cover.add(*kind, part, size_of(*kind, f.tags));
                         });
  }
  out.chips = cover.draw(options);
  split_into_blocks(out.chips);
  if (out.chips.empty())
    throw Error(ExitCode::kBadInput,
                fmt::format("{}: no place shows one class of the vector layers clearly; say what their features are "
                            "(--vectors FILE=KIND, of {})",
                            image_path, kKindNames));
  return out;
}

}  // namespace landfix::landmarks
