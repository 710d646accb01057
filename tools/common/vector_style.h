// How QGIS draws exported landmarks and roads.
#pragma once

#include <string>

namespace landfix::tools {

/// QGIS's style file (QML) for "landmarks" (by class), "roads" or "intersections".
std::string qgis_style(const std::string& layer);

/// A style file with this body.
std::string qgis_document(const std::string& body);

}  // namespace landfix::tools
