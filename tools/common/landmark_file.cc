#include "tools/common/landmark_file.h"

#include <cmath>

#include "builder/error.h"
#include "builder/ingest/raster.h"
#include "tools/common/geopackage.h"
#include "tools/common/map_features.h"

namespace landfix::tools {
namespace {

using landmarks::Extracted;

OGRLayer& add_landmark_layer(GDALDataset& file, const char* name, const OGRSpatialReference& crs,
                             OGRwkbGeometryType type, const std::string& path) {
  OGRLayer& layer = add_layer(file, name, crs, type, path);
  add_field(layer, "class", OFTString, path);
  for (const char* field : {"length_m", "width_m", "orientation_deg", "confidence", "distinctiveness_m"})
    add_field(layer, field, OFTReal, path);
  return layer;
}

void add_feature(OGRLayer& layer, const OGRGeometry& geometry, const tiles::Landmark& m, const std::string& path) {
  const auto rounded = [](double v) { return std::round(v * 1000) / 1000; };
  OGRFeature feature(layer.GetLayerDefn());
  feature.SetField("class", kLandmarkStyles[size_t(m.cls)].name);
  feature.SetField("length_m", rounded(m.length_m));
  feature.SetField("width_m", rounded(m.width_m));
  if (!std::isnan(m.orientation_rad)) feature.SetField("orientation_deg", rounded(m.orientation_rad * 180 / M_PI));
  feature.SetField("confidence", rounded(m.confidence));
  feature.SetField("distinctiveness_m", rounded(m.distinctiveness_m));
  feature.SetGeometry(&geometry);
  require_written(layer.CreateFeature(&feature) == OGRERR_NONE, path);
}

OGRPolygon polygon_of(const std::vector<cv::Point2d>& points) {
  OGRLinearRing ring;
  for (const cv::Point2d& p : points) ring.addPoint(p.x, p.y);
  ring.closeRings();
  OGRPolygon polygon;
  polygon.addRing(&ring);
  return polygon;
}

}  // namespace

std::vector<cv::Point2d> rectangle_of(const tiles::Landmark& m) {
  const double heading = std::isnan(m.orientation_rad) ? 0 : m.orientation_rad;
  const cv::Point2d along(std::sin(heading) * m.length_m / 2, std::cos(heading) * m.length_m / 2),
      across(std::cos(heading) * m.width_m / 2, -std::sin(heading) * m.width_m / 2), centre(m.east_m, m.north_m);
  return {centre + along + across, centre + along - across, centre - along - across, centre - along + across};
}

void write_landmark_file(const std::string& path, const std::vector<Extracted>& landmarks, const tiles::Zone& zone) {
  const OGRSpatialReference crs = ingest::zone_crs(zone);
  write_geopackage(path, [&](GDALDataset& file) {
    OGRLayer& points = add_landmark_layer(file, "landmarks", crs, wkbPoint, path);
    for (const Extracted& e : landmarks)
      add_feature(points, OGRPoint(e.landmark.east_m, e.landmark.north_m), e.landmark, path);
    OGRLayer& outlines = add_landmark_layer(file, "outlines", crs, wkbPolygon, path);
    for (const Extracted& e : landmarks)
      add_feature(outlines, polygon_of(e.outline.empty() ? rectangle_of(e.landmark) : e.outline), e.landmark, path);
  });
}

}  // namespace landfix::tools
