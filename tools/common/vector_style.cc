#include "tools/common/vector_style.h"

#include <fmt/format.h>

#include "tools/common/map_features.h"

namespace landfix::tools {
namespace {

std::string colour_text(const std::array<uint8_t, 3>& c) { return fmt::format("{},{},{},255", c[0], c[1], c[2]); }

std::string marker(const std::string& name, const std::string& shape, const std::array<uint8_t, 3>& colour,
                   double size_mm) {
  return fmt::format(
      R"(   <symbol type="marker" name="{}" alpha="1" clip_to_extent="1" force_rhr="0">
    <layer class="SimpleMarker" enabled="1" locked="0" pass="0">
     <prop k="name" v="{}"/>
     <prop k="color" v="{}"/>
     <prop k="outline_color" v="0,0,0,255"/>
     <prop k="outline_width" v="0.2"/>
     <prop k="outline_width_unit" v="MM"/>
     <prop k="size" v="{}"/>
     <prop k="size_unit" v="MM"/>
    </layer>
   </symbol>
)",
      name, shape, colour_text(colour), size_mm);
}

std::string line(const std::string& name, const std::array<uint8_t, 3>& colour, double width_mm) {
  return fmt::format(
      R"(   <symbol type="line" name="{}" alpha="1" clip_to_extent="1" force_rhr="0">
    <layer class="SimpleLine" enabled="1" locked="0" pass="0">
     <prop k="line_color" v="{}"/>
     <prop k="line_width" v="{}"/>
     <prop k="line_width_unit" v="MM"/>
     <prop k="line_style" v="solid"/>
     <prop k="capstyle" v="round"/>
     <prop k="joinstyle" v="round"/>
    </layer>
   </symbol>
)",
      name, colour_text(colour), width_mm);
}

std::string single(const std::string& symbol) {
  return fmt::format(
      R"( <renderer-v2 type="singleSymbol" symbollevels="0" forceraster="0" enableorderby="0">
  <symbols>
{}  </symbols>
 </renderer-v2>
)",
      symbol);
}

// Buildings and paved places are squares, as what they stand for has corners.
std::string by_class() {
  std::string categories, symbols;
  for (size_t i = 0; i < kLandmarkStyles.size(); ++i) {
    const LandmarkStyle& style = kLandmarkStyles[i];
    categories +=
        fmt::format("   <category value=\"{0}\" label=\"{0}\" symbol=\"{1}\" render=\"true\"/>\n", style.name, i);
    const bool square = i == LF_BUILDING || i == LF_PAVED;
    symbols += marker(std::to_string(i), square ? "square" : "circle", style.colour, 2);
  }
  return fmt::format(
      R"( <renderer-v2 type="categorizedSymbol" attr="class" symbollevels="0" forceraster="0" enableorderby="0">
  <categories>
{}  </categories>
  <symbols>
{}  </symbols>
 </renderer-v2>
)",
      categories, symbols);
}

}  // namespace

std::string qgis_style(const std::string& layer) {
  const std::string renderer = layer == "landmarks"       ? by_class()
                               : layer == "intersections" ? single(marker("0", "diamond", {255, 255, 255}, 2.4))
                                                          : single(line("0", kRoadColour, 0.6));
  return qgis_document(renderer);
}

std::string qgis_document(const std::string& body) {
  return "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n"
         "<qgis version=\"3.22.0\" styleCategories=\"Symbology\">\n" +
         body + "</qgis>\n";
}

}  // namespace landfix::tools
