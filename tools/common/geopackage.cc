#include "tools/common/geopackage.h"

#include <gdal_priv.h>

#include <filesystem>

#include "builder/error.h"
#include "builder/ingest/gdal.h"
#include "tools/common/files.h"

namespace landfix::tools {

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

void write_dataset(const std::string& path, const char* driver, const std::function<void(GDALDataset& file)>& fill) {
  ingest::setup_gdal();
  // Otherwise a GeoPackage tells when it was written.
  CPLSetThreadLocalConfigOption("OGR_CURRENT_DATE", "1970-01-01T00:00:00.000Z");
  write_atomically(path, [&](const std::string& temporary) {
    GDALDatasetUniquePtr file(
        GetGDALDriverManager()->GetDriverByName(driver)->Create(temporary.c_str(), 0, 0, 0, GDT_Unknown, nullptr));
    require_written(file != nullptr, path);
    fill(*file);
    CPLErrorReset();
    file.reset();
    require_written(CPLGetLastErrorType() < CE_Failure, path);
  });
}

void write_geopackage(const std::string& path, const std::function<void(GDALDataset& file)>& fill) {
  if (std::filesystem::path(path).extension() != ".gpkg")
    throw Error(ExitCode::kUsage, path + ": the name must end in .gpkg");
  write_dataset(path, "GPKG", fill);
}

}  // namespace landfix::tools
