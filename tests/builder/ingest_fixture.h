// What the tests of builder/ingest share: small rasters drawn into a temporary folder, and expected errors.
#pragma once

#include <cpl_conv.h>
#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "builder/error.h"
#include "builder/ingest/gdal.h"
#include "builder/ingest/image_set.h"

namespace landfix::ingest {

inline constexpr double kDegree = std::numbers::pi / 180;
inline const tiles::Zone kZone32{32, true};

/// A raster to write: UTM zone 32N at 0.5 m unless said otherwise, in the middle of the zone.
struct Sketch {
  std::string crs = "EPSG:32632";
  double geotransform[6] = {500'000, 0.5, 0, 5'200'000, 0, -0.5};
  int width = 64, height = 48, bands = 3;
  GDALDataType type = GDT_Byte;
  std::vector<std::string> creation;
  std::function<double(int band, int column, int row)> value = [](int band, int column, int row) {
    return (17 * band + 3 * column + 5 * row) % 256;
  };
  std::function<void(GDALDataset&)> finish = [](GDALDataset&) {};
};

/// Heights in metres that rise by 0.25 a column and fall by 0.5 a row.
inline Sketch slope() {
  Sketch sketch;
  sketch.bands = 1;
  sketch.type = GDT_Float32;
  sketch.value = [](int, int column, int row) { return 400 + 0.25 * column - 0.5 * row; };
  return sketch;
}

class Ingest : public ::testing::Test {
 protected:
  void SetUp() override {
    setup_gdal();
    folder_ = std::filesystem::temp_directory_path() /
              ("landfix_ingest_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()) + "_" +
               std::to_string(CPLGetCurrentProcessID()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  std::string write(const std::string& name, const Sketch& sketch) const {
    CPLStringList creation;
    for (const std::string& option : sketch.creation) creation.AddString(option.c_str());
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
    GDALDatasetUniquePtr dataset(
        driver->Create(path(name).c_str(), sketch.width, sketch.height, sketch.bands, sketch.type, creation.List()));
    double geotransform[6];
    std::copy(sketch.geotransform, sketch.geotransform + 6, geotransform);
    if (geotransform[1] != 0) dataset->SetGeoTransform(geotransform);
    if (!sketch.crs.empty()) {
      OGRSpatialReference crs;
      crs.SetFromUserInput(sketch.crs.c_str());
      dataset->SetSpatialRef(&crs);
    }
    for (int band = 1; band <= sketch.bands; ++band) {
      for (int row = 0; row < sketch.height; ++row) {
        std::vector<double> line;
        for (int column = 0; column < sketch.width; ++column) line.push_back(sketch.value(band, column, row));
        EXPECT_EQ(dataset->GetRasterBand(band)->RasterIO(GF_Write, 0, row, sketch.width, 1, line.data(), sketch.width,
                                                         1, GDT_Float64, 0, 0, nullptr),
                  CE_None);
      }
    }
    sketch.finish(*dataset);
    return path(name);
  }

  std::string write_text(const std::string& name, const std::string& text) const {
    std::ofstream(path(name)) << text;
    return path(name);
  }

  std::filesystem::path folder_;
};

inline ImageSet images(const std::vector<SourceOptions>& files, std::optional<tiles::Zone> zone = std::nullopt) {
  return ImageSet(files, zone);
}

/// Expects an Error with this code whose message holds all of `words`.
inline void expect_error(ExitCode code, const std::vector<std::string>& words, const std::function<void()>& action) {
  try {
    action();
    ADD_FAILURE() << "no error";
  } catch (const Error& e) {
    EXPECT_EQ(int(e.code()), int(code)) << e.what();
    for (const std::string& word : words)
      EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << word << " in: " << e.what();
  }
}

inline void transform_point(const std::string& from, const tiles::Zone& to, double& x, double& y) {
  OGRSpatialReference source, target;
  source.SetFromUserInput(from.c_str());
  target.importFromEPSG(tiles::epsg_code(to));
  source.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  target.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  const std::unique_ptr<OGRCoordinateTransformation> t(OGRCreateCoordinateTransformation(&source, &target));
  ASSERT_TRUE(t && t->Transform(1, &x, &y));
}

}  // namespace landfix::ingest
