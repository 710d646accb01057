// How navigability is shown: classes of the chance of a fix in colours that the colour-blind can tell apart, the same
// in pictures and in QGIS.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace landfix::tools {

struct ChanceClass {
  double below;  ///< upper end; the lower one is that of the class before
  const char* text;
  std::array<uint8_t, 3> colour;  ///< red, green, blue
};

/// From poor to good: red to blue by ColorBrewer (RdYlBu), which is made for it.
inline constexpr std::array<ChanceClass, 5> kChanceClasses = {{{0.2, "below 0.2", {215, 25, 28}},
                                                               {0.5, "0.2 to 0.5", {253, 174, 97}},
                                                               {0.8, "0.5 to 0.8", {255, 255, 191}},
                                                               {0.95, "0.8 to 0.95", {171, 217, 233}},
                                                               {1, "0.95 and more", {44, 123, 182}}}};

/// Index into kChanceClasses.
size_t class_of(double chance);

/// QGIS's style files (QML), with a legend: of polygons by a field, and of the first band of a raster.
std::string qgis_chance_style(const std::string& field);
std::string qgis_chance_raster_style();

}  // namespace landfix::tools
