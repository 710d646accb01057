// A pack's navigability as files for GIS programs and for the eye.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "landfix/landfix.hpp"
#include "tools/common/navigability_map.h"

namespace landfix::tools {

/// What is shown.
struct NavigabilityView {
  const Pack& pack;
  const NavigabilityMap& map;
  tiles::Finder finder = tiles::Finder::kAuto;  ///< whose chance the colours are of
  std::optional<int> day;  ///< of the flight, since 1970-01-01; absent: chances as the pack has them
};

/// A node that something is said of.
struct JudgedNode {
  int column = 0, row = 0;
  tiles::Navigability place;  ///< chances of a fix for the day of the flight

  double chance(tiles::Finder finder) const { return place.fix_probability[size_t(finder)]; }
};

/// By rows from the north, in each from the west. Throws Error(kNoData) where a day is given and the pack does not say
/// when its images were taken.
std::vector<JudgedNode> nodes_of(const NavigabilityView& view, const std::string& pack_path);

/// A cloud-optimised GeoTIFF on the grid, a pixel per node, of 32-bit floats; band 1 is the chance of a fix, the others
/// are named in the file. NaN: nothing is said. NAME.qml beside it holds the style. Atomically; throws Error(kIo).
void write_navigability_raster(const std::string& path, const NavigabilityView& view,
                               const std::vector<JudgedNode>& nodes);

/// A GeoPackage on the grid with the layer `navigability`: a square per node, reasons in words, and the style within.
/// Atomically; throws Error(kIo).
void write_navigability_squares(const std::string& path, const NavigabilityView& view,
                                const std::vector<JudgedNode>& nodes);

/// A PNG: the overview of the map in gray (or its gray layer, if that is finer) under the colours of the chance, with
/// legend and scale. Atomically; throws Error(kIo).
void write_navigability_picture(const std::string& path, const NavigabilityView& view,
                                const std::vector<JudgedNode>& nodes, const std::string& pack_path);

}  // namespace landfix::tools
