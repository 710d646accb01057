#include "tools/common/navigability_style.h"

#include <fmt/format.h>

#include "tools/common/vector_style.h"

namespace landfix::tools {
namespace {

constexpr double kOpacity = 0.6;  // what lies below can still be seen

}  // namespace

size_t class_of(double chance) {
  size_t i = 0;
  while (i + 1 < kChanceClasses.size() && chance >= kChanceClasses[i].below) ++i;
  return i;
}

std::string qgis_chance_style(const std::string& field) {
  std::string ranges, symbols;
  double lower = 0;
  for (size_t i = 0; i < kChanceClasses.size(); ++i) {
    const ChanceClass& c = kChanceClasses[i];
    ranges += fmt::format("   <range lower=\"{}\" upper=\"{}\" symbol=\"{}\" label=\"{}\" render=\"true\"/>\n", lower,
                          c.below, i, c.text);
    symbols += fmt::format(
        R"(   <symbol type="fill" name="{}" alpha="{}" clip_to_extent="1" force_rhr="0">
    <layer class="SimpleFill" enabled="1" locked="0" pass="0">
     <prop k="color" v="{},{},{},255"/>
     <prop k="style" v="solid"/>
     <prop k="outline_style" v="no"/>
    </layer>
   </symbol>
)",
        i, kOpacity, c.colour[0], c.colour[1], c.colour[2]);
    lower = c.below;
  }
  return qgis_document(fmt::format(
      R"( <renderer-v2 type="graduatedSymbol" attr="{}" graduatedMethod="GraduatedColor" symbollevels="0" forceraster="0" enableorderby="0">
  <ranges>
{}  </ranges>
  <symbols>
{}  </symbols>
 </renderer-v2>
)",
      field, ranges, symbols));
}

std::string qgis_chance_raster_style() {
  std::string items;
  for (size_t i = 0; i < kChanceClasses.size(); ++i) {
    const ChanceClass& c = kChanceClasses[i];
    // Values up to `value` are of the class; the last one takes the rest.
    const std::string value = i + 1 < kChanceClasses.size() ? fmt::format("{}", c.below) : "inf";
    items += fmt::format("     <item value=\"{}\" label=\"{}\" color=\"#{:02x}{:02x}{:02x}\" alpha=\"255\"/>\n", value,
                         c.text, c.colour[0], c.colour[1], c.colour[2]);
  }
  return qgis_document(fmt::format(
      R"( <pipe>
  <rasterrenderer type="singlebandpseudocolor" band="1" opacity="{}" alphaBand="-1" classificationMin="0" classificationMax="1">
   <rastershader>
    <colorrampshader colorRampType="DISCRETE" classificationMode="1" clip="0" minimumValue="0" maximumValue="1">
{}    </colorrampshader>
   </rastershader>
  </rasterrenderer>
 </pipe>
)",
      kOpacity, items));
}

}  // namespace landfix::tools
