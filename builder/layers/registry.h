// The raster layers that landfix can build: one row each in registry.cc, in the order of the pack.
#pragma once

#include <span>
#include <string_view>

#include "builder/layers/layer.h"

namespace landfix::layers {

std::span<const RasterLayer* const> registry();

/// nullptr for a name that is not in the registry.
const RasterLayer* find(std::string_view name);

// One file per layer.
const RasterLayer& gray_layer();
const RasterLayer& overview_layer();
const RasterLayer& edge_layer();
const RasterLayer& contour_layer();
const RasterLayer& orientation_layer();
const RasterLayer& agreement_layer();
const RasterLayer& height_layer();

}  // namespace landfix::layers
