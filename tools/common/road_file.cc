#include "tools/common/road_file.h"

#include <cmath>
#include <initializer_list>

#include "builder/error.h"
#include "builder/ingest/raster.h"
#include "tools/common/geopackage.h"

namespace landfix::tools {
namespace {

OGRLayer& add_number_layer(GDALDataset& file, const char* name, const OGRSpatialReference& crs, OGRwkbGeometryType type,
                           std::initializer_list<const char*> fields, const std::string& path) {
  OGRLayer& layer = add_layer(file, name, crs, type, path);
  for (const char* field : fields) add_field(layer, field, OFTReal, path);
  return layer;
}

void add_feature(OGRLayer& layer, const OGRGeometry& geometry, std::initializer_list<double> values,
                 const std::string& path) {
  OGRFeature feature(layer.GetLayerDefn());
  int field = 0;
  for (const double value : values) feature.SetField(field++, std::round(value * 1000) / 1000);
  feature.SetGeometry(&geometry);
  require_written(layer.CreateFeature(&feature) == OGRERR_NONE, path);
}

void write_roads(GDALDataset& file, const tiles::RoadGraph& graph, OGRSpatialReference& crs, const std::string& path) {
  OGRLayer& layer = add_number_layer(file, "roads", crs, wkbLineString, {"width_m", "length_m", "confidence"}, path);
  for (const tiles::RoadEdge& e : graph.edges) {
    OGRLineString line;
    for (const tiles::RoadPoint& p : tiles::line_of(graph, e)) line.addPoint(p.east_m, p.north_m);
    add_feature(layer, line, {e.width_m, tiles::length_of(graph, e), e.confidence}, path);
  }
}

void write_intersections(GDALDataset& file, const tiles::RoadGraph& graph, OGRSpatialReference& crs,
                         const std::string& path) {
  OGRLayer& layer = add_number_layer(file, "intersections", crs, wkbPoint, {"degree", "confidence"}, path);
  std::vector<tiles::RoadIntersection> intersections;
  if (!tiles::intersections_of(graph, intersections)) throw Error(ExitCode::kInternal, "no memory for intersections");
  for (const tiles::RoadIntersection& i : intersections)
    add_feature(layer, OGRPoint(i.east_m, i.north_m), {double(i.arms.size()), i.confidence}, path);
}

}  // namespace

void write_road_file(const std::string& path, const tiles::RoadGraph& graph, const tiles::Zone& zone) {
  OGRSpatialReference crs = ingest::zone_crs(zone);
  write_geopackage(path, [&](GDALDataset& file) {
    write_roads(file, graph, crs, path);
    write_intersections(file, graph, crs, path);
  });
}

}  // namespace landfix::tools
