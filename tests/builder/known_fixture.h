// What the tests of known vector data share: a map of 1 km, features drawn on it as GeoJSON, and layers of any format.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <ogrsf_frmts.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "builder/ingest/vectors.h"
#include "builder/landmarks/known.h"
#include "tests/builder/ingest_fixture.h"

namespace landfix::landmarks {

inline constexpr double kWest = 500'000, kSouth = 5'200'000;
inline const ingest::GridBounds kMap{kWest, kSouth, kWest + 1000, kSouth + 1000};

using Points = std::vector<std::pair<double, double>>;  ///< metres east and north of the map's corner

inline std::string coordinates(const Points& points) {
  std::vector<std::string> out;
  for (const auto& [x, y] : points) out.push_back(fmt::format("[{},{}]", kWest + x, kSouth + y));
  return fmt::format("[{}]", fmt::join(out, ","));
}
inline std::string feature(const std::string& type, const std::string& where, const std::string& tags) {
  return fmt::format(R"({{"type":"Feature","properties":{{{}}},"geometry":{{"type":"{}","coordinates":{}}}}})", tags,
                     type, where);
}
inline std::string line(const Points& points, const std::string& tags = R"("highway":"residential")") {
  return feature("LineString", coordinates(points), tags);
}
inline std::string polygon(Points points, const std::string& tags) {
  points.push_back(points.front());
  return feature("Polygon", "[" + coordinates(points) + "]", tags);
}
inline Points box(double west, double south, double width, double height) {
  return {{west, south}, {west + width, south}, {west + width, south + height}, {west, south + height}};
}

class KnownTest : public ingest::Ingest {
 protected:
  std::string file(const std::vector<std::string>& features, const std::string& name = "osm", int epsg = 32632) const {
    return write_text(name + ".geojson",
                      fmt::format(R"({{"type":"FeatureCollection","name":"{}","crs":{{"type":"name","properties":)"
                                  R"({{"name":"urn:ogc:def:crs:EPSG::{}"}}}},"features":[{}]}})",
                                  name, epsg, fmt::join(features, ",")));
  }
  static Known read(const std::string& path, std::optional<Kind> kind = {}, const std::string& layer = {}) {
    return read_known({{path, layer, kind}}, ingest::kZone32, kMap);
  }
  /// A layer `name` of points, lines and polygons in WKT; without fields.
  std::string layer(const std::string& file, const char* driver, const char* crs, const std::vector<std::string>& wkts,
                    const std::string& name = "buildings") const {
    GDALDatasetUniquePtr out(
        GetGDALDriverManager()->GetDriverByName(driver)->Create(path(file).c_str(), 0, 0, 0, GDT_Unknown, nullptr));
    OGRSpatialReference reference;
    reference.SetFromUserInput(crs);
    reference.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    OGRLayer* features =
        out->CreateLayer(name.c_str(), *crs ? &reference : nullptr, wkts.empty() ? wkbPolygon : wkbUnknown, nullptr);
    for (const std::string& wkt : wkts) {
      OGRFeature one(features->GetLayerDefn());
      OGRGeometry* geometry = nullptr;
      EXPECT_EQ(OGRGeometryFactory::createFromWkt(wkt.c_str(), nullptr, &geometry), OGRERR_NONE) << wkt;
      one.SetGeometryDirectly(geometry);
      EXPECT_EQ(features->CreateFeature(&one), OGRERR_NONE) << wkt;
    }
    return path(file);
  }
  Known roads(const std::vector<std::string>& lines) const { return read(file(lines)); }
};

inline size_t intersections(const tiles::RoadGraph& graph) {
  std::vector<tiles::RoadIntersection> out;
  EXPECT_TRUE(tiles::intersections_of(graph, out));
  return out.size();
}

}  // namespace landfix::landmarks
