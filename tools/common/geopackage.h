// Vector files for GIS programs, the same bytes every time.
#pragma once

#include <ogrsf_frmts.h>

#include <functional>
#include <string>

namespace landfix::tools {

/// Throws Error (kIo) with the path and what GDAL said last, unless it `holds`.
void require_written(bool holds, const std::string& path);

/// A new layer without fields.
OGRLayer& add_layer(GDALDataset& file, const std::string& name, const OGRSpatialReference& crs, OGRwkbGeometryType type,
                    const std::string& path);
void add_field(OGRLayer& layer, const char* name, OGRFieldType type, const std::string& path);

/// Puts a style (QML) where QGIS looks for that of a layer when it opens the file: the table `layer_styles`.
void add_qgis_style(GDALDataset& file, const std::string& layer, const std::string& qml, const std::string& path);

/// Writes a file of a GDAL driver ("GPKG", "GeoJSON") with what `fill` puts into it, whole or not at all. Throws Error
/// (kIo) where writing fails.
void write_dataset(const std::string& path, const char* driver, const std::function<void(GDALDataset& file)>& fill);

/// The same for a GeoPackage; throws Error (kUsage) for another extension than .gpkg.
void write_geopackage(const std::string& path, const std::function<void(GDALDataset& file)>& fill);

}  // namespace landfix::tools
