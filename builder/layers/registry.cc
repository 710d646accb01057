#include "builder/layers/registry.h"

namespace landfix::layers {

std::span<const RasterLayer* const> registry() {
  static const RasterLayer* const kLayers[] = {
      &gray_layer(),        &overview_layer(),  &edge_layer(),   &contour_layer(),
      &orientation_layer(), &agreement_layer(), &height_layer(),
  };
  return kLayers;
}

const RasterLayer* find(std::string_view name) {
  for (const RasterLayer* layer : registry())
    if (layer->info().name == name) return layer;
  return nullptr;
}

}  // namespace landfix::layers
