#include "builder/layer_set.h"

#include <fmt/format.h>

#include <algorithm>

#include "builder/error.h"

namespace landfix {

const std::vector<LayerSet>& layer_sets() {
  using tiles::Codec;
  static const std::vector<LayerSet> kSets = {
      {"all",
       "every layer, those for matching as they are read in flight",
       {},
       {},
       {.jpeg_quality = 90, .zstd_level = 3}},
      {"standard",
       "small: what the matchers need, compressed; `prepare` decodes it before the flight",
       {"gray", "overview", "contour", "orientation", "agreement", "height", "landmarks", "roads"},
       {{"gray", Codec::kJpeg},
        {"overview", Codec::kJpeg},
        {"contour", Codec::kZstd},
        {"orientation", tiles::Codec::kContext},
        {"agreement", Codec::kZstd},
        {"height", Codec::kZstd}},
       // NCC of 48 px at 1 m does not notice: mean peak 0.855 instead of 0.856, mean gap 0.369 instead of 0.370.
       {.jpeg_quality = 70, .zstd_level = 8}},
  };
  return kSets;
}

const LayerSet& layer_set(const std::string& name) {
  const auto found = std::ranges::find(layer_sets(), name, &LayerSet::name);
  if (found != layer_sets().end()) return *found;
  std::string names;
  for (const LayerSet& set : layer_sets()) names += (names.empty() ? "" : ", ") + set.name;
  throw Error(ExitCode::kUsage, fmt::format("--set {}: no such set; expected one of {}", name, names));
}

}  // namespace landfix
