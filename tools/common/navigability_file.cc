#include "tools/common/navigability_file.h"

#include <fmt/format.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>

#include "builder/error.h"
#include "builder/ingest/gdal.h"
#include "builder/ingest/raster.h"
#include "tools/common/files.h"
#include "tools/common/geopackage.h"
#include "tools/common/manifest_json.h"
#include "tools/common/navigability_style.h"

namespace landfix::tools {
namespace {

using tiles::Finder;
using tiles::Navigability;

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

// What a node has besides the chances of a fix. NaN: nothing is said.
struct Quantity {
  const char* name;
  double (*of)(const Navigability&);
};
constexpr Quantity kQuantities[] = {
    {"false_probability", [](const Navigability& n) { return n.false_probability; }},
    {"major_m", [](const Navigability& n) { return n.major_m; }},
    {"minor_m", [](const Navigability& n) { return n.minor_m; }},
    {"direction_deg", [](const Navigability& n) { return n.direction_rad * kDegrees; }},
    {"rival_m", [](const Navigability& n) { return n.rival_m > 0 ? n.rival_m : kNothing; }},
    {"rival_bearing_deg",
     [](const Navigability& n) { return n.rival_m > 0 ? n.rival_bearing_rad * kDegrees : kNothing; }},
    {"rival_strength", [](const Navigability& n) { return n.rival_m > 0 ? n.rival_strength : kNothing; }},
    {"landmarks", [](const Navigability& n) { return double(n.landmarks); }},
    {"diversity", [](const Navigability& n) { return n.diversity; }},
    {"dates", [](const Navigability& n) { return double(n.dates); }},
    {"newest_day", [](const Navigability& n) { return n.newest_day ? double(*n.newest_day) : kNothing; }},
};

std::string chance_name(Finder finder) { return fmt::format("fix_{}", name_of(finder)); }

// The one that is asked for, then the others that were judged.
std::vector<Finder> finders_of(const NavigabilityView& view) {
  std::vector<Finder> out{view.finder};
  for (size_t k = 0; k < tiles::kFinders; ++k)
    if (Finder(k) != view.finder && view.map.judges(Finder(k))) out.push_back(Finder(k));
  return out;
}

// Fills a dataset in memory, one band after the other.
void fill(GDALDataset& file, const NavigabilityView& view, const std::vector<JudgedNode>& nodes,
          const std::string& path) {
  const int columns = view.map.columns(), rows = view.map.rows();
  int band = 0;
  const auto write = [&](const std::string& name, const auto& value_of) {
    std::vector<float> values(size_t(columns) * size_t(rows), float(kNothing));
    for (const JudgedNode& n : nodes) values[size_t(n.row) * size_t(columns) + size_t(n.column)] = float(value_of(n));
    GDALRasterBand& to = *file.GetRasterBand(++band);
    to.SetDescription(name.c_str());
    to.SetNoDataValue(kNothing);
    require_written(
        to.RasterIO(GF_Write, 0, 0, columns, rows, values.data(), columns, rows, GDT_Float32, 0, 0, nullptr) == CE_None,
        path);
  };
  for (const Finder finder : finders_of(view))
    write(chance_name(finder), [&](const JudgedNode& n) { return n.chance(finder); });
  for (const Quantity& q : kQuantities) write(q.name, [&](const JudgedNode& n) { return q.of(n.place); });
  write("reasons", [](const JudgedNode& n) { return double(n.place.reasons); });
}

OGRPolygon square_of(const NavigabilityMap& map, const JudgedNode& n) {
  const double half_m = map.spacing_m() / 2, east_m = map.east_of(n.column), north_m = map.north_of(n.row);
  OGRLinearRing ring;
  for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}, {-1, -1}})
    ring.addPoint(east_m + x * half_m, north_m + y * half_m);
  OGRPolygon polygon;
  polygon.addRing(&ring);
  return polygon;
}

}  // namespace

std::vector<JudgedNode> nodes_of(const NavigabilityView& view, const std::string& pack_path) {
  std::vector<JudgedNode> out;
  bool dated = !view.day;
  for (int row = 0; row < view.map.rows(); ++row)
    for (int column = 0; column < view.map.columns(); ++column) {
      const std::optional<Navigability> place = view.map.node(column, row);
      if (!place || std::isnan(place->fix_probability[size_t(view.finder)])) continue;
      out.push_back({column, row, view.day ? tiles::on_day(*place, *view.day) : *place});
      dated |= place->newest_day.has_value();
    }
  if (!dated && !out.empty())
    throw Error(ExitCode::kNoData,
                fmt::format("{}: the pack does not say when its images were taken; leave out --date, or build it with "
                            "--date",
                            pack_path));
  return out;
}

void write_navigability_raster(const std::string& path, const NavigabilityView& view,
                               const std::vector<JudgedNode>& nodes) {
  ingest::setup_gdal();
  const ingest::GdalMessages messages;
  OGRSpatialReference crs = ingest::zone_crs(zone_of(view.pack));
  const double gsd_m = view.map.spacing_m();
  double transform[6] = {view.map.west_m(), gsd_m, 0, view.map.north_m(), 0, -gsd_m};
  const int bands = int(finders_of(view).size() + std::size(kQuantities) + 1);
  GDALDriverManager& drivers = *GetGDALDriverManager();
  const GDALDatasetUniquePtr memory(
      drivers.GetDriverByName("MEM")->Create("", view.map.columns(), view.map.rows(), bands, GDT_Float32, nullptr));
  require_written(memory != nullptr, path);
  memory->SetGeoTransform(transform);
  memory->SetSpatialRef(&crs);
  fill(*memory, view, nodes, path);
  write_atomically(path, [&](const std::string& temporary) {
    const char* options[] = {"COMPRESS=DEFLATE", "OVERVIEW_RESAMPLING=NEAREST", nullptr};
    const GDALDatasetUniquePtr file(drivers.GetDriverByName("COG")->CreateCopy(
        temporary.c_str(), memory.get(), false, const_cast<char**>(options), nullptr, nullptr));
    require_written(file != nullptr && !messages.failed(), path);
  });
  write_text(std::filesystem::path(path).replace_extension(".qml"), qgis_chance_raster_style());
}

void write_navigability_squares(const std::string& path, const NavigabilityView& view,
                                const std::vector<JudgedNode>& nodes) {
  const OGRSpatialReference crs = ingest::zone_crs(zone_of(view.pack));
  const std::vector<Finder> finders = finders_of(view);
  write_geopackage(path, [&](GDALDataset& file) {
    OGRLayer& layer = add_layer(file, "navigability", crs, wkbPolygon, path);
    for (const Finder finder : finders) add_field(layer, chance_name(finder).c_str(), OFTReal, path);
    for (const Quantity& q : kQuantities) add_field(layer, q.name, OFTReal, path);
    add_field(layer, "reasons", OFTString, path);
    add_field(layer, "east_m", OFTReal, path);
    add_field(layer, "north_m", OFTReal, path);
    for (const JudgedNode& n : nodes) {
      OGRFeature feature(layer.GetLayerDefn());
      const auto set = [&](const char* name, double value) {
        if (std::isnan(value))
          feature.SetFieldNull(feature.GetFieldIndex(name));
        else
          feature.SetField(name, std::round(value * 1e4) / 1e4);
      };
      for (const Finder finder : finders) set(chance_name(finder).c_str(), n.chance(finder));
      for (const Quantity& q : kQuantities) set(q.name, q.of(n.place));
      feature.SetField("reasons", reasons_text(n.place).c_str());
      set("east_m", view.map.east_of(n.column));
      set("north_m", view.map.north_of(n.row));
      const OGRPolygon square = square_of(view.map, n);
      feature.SetGeometry(&square);
      require_written(layer.CreateFeature(&feature) == OGRERR_NONE, path);
    }
    add_qgis_style(file, "navigability", qgis_chance_style(chance_name(view.finder)), path);
  });
}

}  // namespace landfix::tools
