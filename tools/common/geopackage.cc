#include "tools/common/geopackage.h"

#include <cpl_string.h>
#include <cpl_vsi.h>
#include <gdal_priv.h>

#include <filesystem>
#include <string_view>
#include <utility>

#include "builder/error.h"
#include "builder/ingest/gdal.h"
#include "tools/common/files.h"

namespace landfix::tools {
namespace {

struct MemoryFile {
  std::string name;
  ~MemoryFile() { VSIUnlink(name.c_str()); }
};

}  // namespace

void require_written(bool holds, const std::string& path) {
  if (!holds) throw Error(ExitCode::kIo, path + ": cannot be written: " + CPLGetLastErrorMsg());
}

OGRLayer& add_layer(GDALDataset& file, const std::string& name, const OGRSpatialReference& crs, OGRwkbGeometryType type,
                    const std::string& path) {
  OGRSpatialReference own = crs;
  OGRLayer* layer = file.CreateLayer(name.c_str(), &own, type, nullptr);
  require_written(layer != nullptr, path);
  return *layer;
}

void add_field(OGRLayer& layer, const char* name, OGRFieldType type, const std::string& path) {
  OGRFieldDefn definition(name, type);
  require_written(layer.CreateField(&definition) == OGRERR_NONE, path);
}

void add_qgis_style(GDALDataset& file, const std::string& layer, const std::string& qml, const std::string& path) {
  const char* options[] = {"FID=id", nullptr};
  OGRLayer* styles = file.CreateLayer("layer_styles", nullptr, wkbNone, const_cast<char**>(options));
  require_written(styles != nullptr, path);
  const std::pair<const char*, std::string> columns[] = {{"f_table_catalog", ""},
                                                         {"f_table_schema", ""},
                                                         {"f_table_name", layer},
                                                         {"f_geometry_column", "geom"},
                                                         {"styleName", layer},
                                                         {"styleQML", qml},
                                                         {"styleSLD", ""},
                                                         {"useAsDefault", "1"},
                                                         {"description", "landfix"},
                                                         {"owner", ""},
                                                         {"ui", ""},
                                                         {"update_time", "1970-01-01T00:00:00.000Z"}};
  for (const auto& [name, value] : columns) {
    const std::string column = name;
    OGRFieldDefn definition(name, column == "update_time"    ? OFTDateTime
                                  : column == "useAsDefault" ? OFTInteger
                                                             : OFTString);
    if (column == "useAsDefault") definition.SetSubType(OFSTBoolean);
    require_written(styles->CreateField(&definition) == OGRERR_NONE, path);
  }
  OGRFeature feature(styles->GetLayerDefn());
  for (const auto& [name, value] : columns) feature.SetField(name, value.c_str());
  require_written(styles->CreateFeature(&feature) == OGRERR_NONE, path);
}

void write_dataset(const std::string& path, const char* driver, const std::function<void(GDALDataset& file)>& fill) {
  ingest::setup_gdal();
  // Otherwise a GeoPackage tells when it was written.
  CPLSetThreadLocalConfigOption("OGR_CURRENT_DATE", "1970-01-01T00:00:00.000Z");
  const auto write = [&](const std::string& name) {
    GDALDatasetUniquePtr file(
        GetGDALDriverManager()->GetDriverByName(driver)->Create(name.c_str(), 0, 0, 0, GDT_Unknown, nullptr));
    require_written(file != nullptr, path);
    fill(*file);
    CPLErrorReset();
    file.reset();
    require_written(CPLGetLastErrorType() < CE_Failure, path);
  };
  if (std::string_view(driver) == "GPKG") return write_atomically(path, write);
  // Drivers of texts do not say that the disk is full: they write to memory.
  const MemoryFile memory{CPLString().Printf("/vsimem/%p", static_cast<const void*>(&path))};
  write(memory.name);
  vsi_l_offset size = 0;
  const GByte* bytes = VSIGetMemFileBuffer(memory.name.c_str(), &size, FALSE);
  write_bytes(path, {bytes, size_t(size)});
}

void write_geopackage(const std::string& path, const std::function<void(GDALDataset& file)>& fill) {
  if (std::filesystem::path(path).extension() != ".gpkg")
    throw Error(ExitCode::kUsage, path + ": the name must end in .gpkg");
  write_dataset(path, "GPKG", fill);
}

}  // namespace landfix::tools
