// Named choices of layers and of how they are stored.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tiles/codec.h"

namespace landfix {

struct LayerSet {
  std::string name;
  std::string description;
  std::vector<std::string> layers;             ///< those that the inputs serve are made; empty: all
  std::map<std::string, tiles::Codec> codecs;  ///< by layer, instead of its default
  tiles::EncodeOptions encoding;
};

/// "all" first: what is made where nothing is said.
const std::vector<LayerSet>& layer_sets();

/// Throws Error (kUsage) for a name that is none of them.
const LayerSet& layer_set(const std::string& name);

}  // namespace landfix
