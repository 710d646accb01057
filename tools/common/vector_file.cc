#include "tools/common/vector_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <ogr_spatialref.h>
#include <ogrsf_frmts.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <variant>

#include "builder/error.h"
#include "builder/ingest/gdal.h"
#include "tools/common/files.h"
#include "tools/common/geopackage.h"
#include "tools/common/manifest_json.h"
#include "tools/common/map_features.h"
#include "tools/common/vector_style.h"

namespace landfix::tools {
namespace {

namespace fs = std::filesystem;
constexpr double kDegrees = 180 / std::numbers::pi;

struct Field {
  const char* name;
  OGRFieldType type;
};
// Null, number or text.
using Value = std::variant<std::monostate, double, std::string>;

struct Feature {
  std::vector<Point> line;  // one point or more
  std::vector<Value> values;
};

// What is written, whatever the format.
struct Table {
  std::string name;
  OGRwkbGeometryType geometry;
  std::vector<Field> fields;
  std::vector<Feature> features;
};

std::string source_name(const Pack& pack, int32_t source) {
  return source < 0 ? std::string("images") : std::string(pack.source(uint32_t(source))->name);
}

Table landmark_table(const Pack& pack, const std::string& path) {
  Table t{"landmarks",
          wkbPoint,
          {{"class", OFTString},
           {"length_m", OFTReal},
           {"width_m", OFTReal},
           {"orientation_deg", OFTReal},
           {"confidence", OFTReal},
           {"distinctiveness_m", OFTReal},
           {"epochs_seen", OFTInteger},
           {"source", OFTString},
           {"east_m", OFTReal},
           {"north_m", OFTReal}},
          {}};
  for (const Landmark& m : find_landmarks(pack, everywhere(pack), path)) {
    const Value orientation = std::isnan(m.orientation_rad) ? Value() : Value(double(m.orientation_rad) * kDegrees);
    t.features.push_back({{{m.east_m, m.north_m}},
                          {std::string(kLandmarkStyles[m.landmark_class].name), double(m.length_m), double(m.width_m),
                           orientation, double(m.confidence), double(m.distinctiveness_m), double(m.epochs_seen),
                           source_name(pack, m.source), m.east_m, m.north_m}});
  }
  return t;
}

Table road_table(const Pack& pack, const std::string& path) {
  Table t{"roads",
          wkbLineString,
          {{"width_m", OFTReal},
           {"length_m", OFTReal},
           {"confidence", OFTReal},
           {"source", OFTString},
           {"begin", OFTString},
           {"end", OFTString}},
          {}};
  const RoadSet set = find_roads(pack, everywhere(pack), path);
  for (const Road& r : set.roads) {
    const auto first = set.vertices.begin() + ptrdiff_t(r.first_vertex);
    t.features.push_back({{first, first + ptrdiff_t(r.vertex_count)},
                          {double(r.width_m), double(r.length_m), double(r.confidence), source_name(pack, r.source),
                           std::string(name_of(lf_road_node(r.begin))), std::string(name_of(lf_road_node(r.end)))}});
  }
  return t;
}

Table intersection_table(const Pack& pack, const std::string& path) {
  Table t{"intersections",
          wkbPoint,
          {{"degree", OFTInteger},
           {"confidence", OFTReal},
           {"bearings_deg", OFTString},
           {"widths_m", OFTString},
           {"east_m", OFTReal},
           {"north_m", OFTReal}},
          {}};
  for (const Intersection& i : find_intersections(pack, everywhere(pack), path)) {
    std::vector<std::string> bearings, widths;
    for (uint32_t k = 0; k < std::min(i.degree, uint32_t(LF_MAX_ARMS)); ++k) {
      bearings.push_back(fmt::format("{:.1f}", double(i.bearing_rad[k]) * kDegrees));
      widths.push_back(fmt::format("{:.1f}", double(i.width_m[k])));
    }
    t.features.push_back({{{i.east_m, i.north_m}},
                          {double(i.degree), double(i.confidence), fmt::format("{}", fmt::join(bearings, " ")),
                           fmt::format("{}", fmt::join(widths, " ")), i.east_m, i.north_m}});
  }
  return t;
}

Table table_of(const Pack& pack, const std::string& layer, const std::string& path) {
  if (layer == "landmarks") return landmark_table(pack, path);
  if (layer == "roads") return road_table(pack, path);
  if (layer == "intersections") return intersection_table(pack, path);
  throw Error(ExitCode::kUsage, fmt::format("--layer {}: expected landmarks, roads or intersections", layer));
}

// Longitude and latitude in degrees.
Point in_degrees(const Pack& pack, const Point& p) {
  const auto g = pack.geodetic_from_grid(p.east_m, p.north_m);
  if (!g) throw Error(ExitCode::kBadPack, "a feature that lies nowhere on earth");
  return {g->longitude_rad * kDegrees, g->latitude_rad * kDegrees};
}

void set(OGRFeature& feature, int field, const Value& value) {
  if (const double* number = std::get_if<double>(&value))
    feature.SetField(field, std::round(*number * 1000) / 1000);
  else if (const std::string* text = std::get_if<std::string>(&value))
    feature.SetField(field, text->c_str());
  else
    feature.SetFieldNull(field);
}

// `place` maps a point to the coordinates of the file.
template <typename Place>
void write_features(const Table& table, OGRLayer& layer, const std::string& path, Place place) {
  for (const Field& field : table.fields) {
    OGRFieldDefn definition(field.name, field.type);
    require_written(layer.CreateField(&definition) == OGRERR_NONE, path);
  }
  for (const Feature& f : table.features) {
    OGRFeature feature(layer.GetLayerDefn());
    for (size_t i = 0; i < f.values.size(); ++i) set(feature, int(i), f.values[i]);
    OGRLineString line;
    for (const Point& p : f.line) {
      const Point at = place(p);
      line.addPoint(at.east_m, at.north_m);
    }
    const OGRPoint point(line.getX(0), line.getY(0));
    feature.SetGeometry(table.geometry == wkbPoint ? static_cast<const OGRGeometry*>(&point) : &line);
    require_written(layer.CreateFeature(&feature) == OGRERR_NONE, path);
  }
}

void export_geopackage(const std::string& path, const Pack& pack, const Table& table) {
  OGRSpatialReference crs;
  crs.importFromEPSG(tiles::epsg_code(zone_of(pack)));
  write_geopackage(path, [&](GDALDataset& file) {
    write_features(table, add_layer(file, table.name, crs, table.geometry, path), path,
                   [](const Point& p) { return p; });
    add_qgis_style(file, table.name, qgis_style(table.name), path);
  });
}

void export_geojson(const std::string& path, const Pack& pack, const Table& table) {
  OGRSpatialReference crs;
  crs.importFromEPSG(4326);
  crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  write_dataset(path, "GeoJSON", [&](GDALDataset& file) {
    const char* options[] = {"RFC7946=YES", "COORDINATE_PRECISION=8", "WRITE_NAME=NO", nullptr};
    OGRLayer* layer = file.CreateLayer(table.name.c_str(), &crs, table.geometry, const_cast<char**>(options));
    require_written(layer != nullptr, path);
    write_features(table, *layer, path, [&](const Point& p) { return in_degrees(pack, p); });
  });
  write_text(fs::path(path).replace_extension(".qml"), qgis_style(table.name));
}

}  // namespace

size_t write_vector_file(const std::string& path, const Pack& pack, const std::string& layer,
                         const std::string& pack_path) {
  const std::string extension = fs::path(path).extension().string();
  if (extension != ".gpkg" && extension != ".geojson")
    throw Error(ExitCode::kUsage, path + ": the name must end in .gpkg (on the grid) or .geojson (in degrees)");
  ingest::setup_gdal();
  const Table table = table_of(pack, layer, pack_path);
  if (extension == ".gpkg")
    export_geopackage(path, pack, table);
  else
    export_geojson(path, pack, table);
  return table.features.size();
}

}  // namespace landfix::tools
