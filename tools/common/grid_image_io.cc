#include "tools/common/grid_image_io.h"

#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <filesystem>
#include <opencv2/imgproc.hpp>

#include "builder/error.h"
#include "builder/ingest/gdal.h"
#include "tools/common/drawing.h"
#include "tools/common/files.h"

namespace landfix::tools {
namespace {

cv::Mat valid_of(const features::GridImage& image) {
  return image.valid.empty() ? cv::Mat(image.pixels.size(), CV_8UC1, cv::Scalar(255)) : image.valid;
}

// Lambert shading with the sun in the north-west, 45 degrees up.
cv::Mat hillshade(const cv::Mat& heights, double gsd_m) {
  cv::Mat dx, dy;
  cv::Sobel(heights, dx, CV_32F, 1, 0, 3, 1 / (8 * gsd_m));
  cv::Sobel(heights, dy, CV_32F, 0, 1, 3, 1 / (8 * gsd_m));
  cv::Mat length, shade = (1 + dx * std::sqrt(0.5) + dy * std::sqrt(0.5)) * std::sqrt(0.5);
  cv::sqrt(1 + dx.mul(dx) + dy.mul(dy), length);
  cv::divide(shade, length, shade);
  return cv::max(0.25, shade);
}

cv::Mat picture_of_heights(const features::GridImage& image, const cv::Mat& valid) {
  double low = 0, high = 1;
  cv::minMaxLoc(image.pixels, &low, &high, nullptr, nullptr, valid);
  cv::Mat heights = image.pixels.clone();
  heights.setTo(low, ~valid);
  cv::Mat ramp, colours, shade = hillshade(heights, image.gsd_m);
  heights.convertTo(ramp, CV_8U, 255 / std::max(high - low, 1e-3), -255 * low / std::max(high - low, 1e-3));
  cv::applyColorMap(ramp, colours, cv::COLORMAP_VIRIDIS);
  colours.convertTo(colours, CV_32FC3);
  cv::cvtColor(shade, shade, cv::COLOR_GRAY2BGR);
  colours = colours.mul(shade, 1.2);
  colours.convertTo(colours, CV_8UC3);
  return colours;
}

void write_bands(GDALDataset& file, const features::GridImage& image, const cv::Mat& valid) {
  const cv::Mat& p = image.pixels;
  const GDALDataType type = p.depth() == CV_32F ? GDT_Float32 : GDT_Byte;
  if (file.RasterIO(GF_Write, 0, 0, p.cols, p.rows, const_cast<uint8_t*>(p.ptr()), p.cols, p.rows, type, p.channels(),
                    nullptr, GSpacing(p.elemSize()), GSpacing(p.step[0]), GSpacing(p.elemSize1())) != CE_None)
    throw Error(ExitCode::kIo, "the GeoTIFF cannot be written; is the disk full?");
  if (type == GDT_Float32 || cv::countNonZero(valid) == int(valid.total())) return;
  if (file.CreateMaskBand(GMF_PER_DATASET) != CE_None ||
      file.GetRasterBand(1)->GetMaskBand()->RasterIO(GF_Write, 0, 0, p.cols, p.rows, const_cast<uint8_t*>(valid.ptr()),
                                                     p.cols, p.rows, GDT_Byte, 1, GSpacing(valid.step[0])) != CE_None)
    throw Error(ExitCode::kIo, "the GeoTIFF's mask cannot be written; is the disk full?");
}

void set_colours(GDALDataset& file, const Palette& palette) {
  GDALColorTable table;
  for (size_t i = 0; i < palette.size(); ++i) {
    const GDALColorEntry entry{palette[i][0], palette[i][1], palette[i][2], 255};
    table.SetColorEntry(int(i), &entry);
  }
  file.GetRasterBand(1)->SetColorTable(&table);
}

void write_geotiff(const std::string& path, const features::GridImage& image, const tiles::Zone& zone,
                   const Palette& palette = {}) {
  ingest::setup_gdal();
  const ingest::GdalMessages messages;
  CPLSetThreadLocalConfigOption("GDAL_TIFF_INTERNAL_MASK", "YES");
  OGRSpatialReference crs;
  crs.importFromEPSG(tiles::epsg_code(zone));
  double transform[6] = {image.west_m, image.gsd_m, 0, image.north_m, 0, -image.gsd_m};
  write_atomically(path, [&](const std::string& temporary) {
    const char* options[] = {"COMPRESS=DEFLATE", "TILED=YES", nullptr};
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
    const cv::Mat& p = image.pixels;
    const GDALDatasetUniquePtr file(driver->Create(temporary.c_str(), p.cols, p.rows, p.channels(),
                                                   p.depth() == CV_32F ? GDT_Float32 : GDT_Byte,
                                                   const_cast<char**>(options)));
    if (!file) throw Error(ExitCode::kIo, path + ": the GeoTIFF cannot be created");
    file->SetGeoTransform(transform);
    file->SetSpatialRef(&crs);
    if (p.depth() == CV_32F) file->GetRasterBand(1)->SetNoDataValue(std::numeric_limits<double>::quiet_NaN());
    if (!palette.empty()) set_colours(*file, palette);
    write_bands(*file, image, valid_of(image));
    file->FlushCache(true);
    if (messages.failed()) throw Error(ExitCode::kIo, path + ": " + messages.text());
  });
}

}  // namespace

cv::Mat picture_of(const features::GridImage& image) {
  const cv::Mat valid = valid_of(image);
  cv::Mat colours;
  if (image.pixels.depth() == CV_32F)
    colours = picture_of_heights(image, valid);
  else if (image.pixels.channels() == 1)
    cv::cvtColor(image.pixels, colours, cv::COLOR_GRAY2BGR);
  else
    cv::cvtColor(image.pixels, colours, cv::COLOR_RGB2BGR);
  cv::Mat picture;
  cv::cvtColor(colours, picture, cv::COLOR_BGR2BGRA);
  picture.setTo(cv::Scalar(0, 0, 0, 0), ~valid);
  return picture;
}

void write_grid_image(const std::string& path, const features::GridImage& image, const tiles::Zone& zone) {
  const std::string extension = std::filesystem::path(path).extension().string();
  if (extension == ".png") return write_picture(path, picture_of(image));
  if (extension == ".tif" || extension == ".tiff") return write_geotiff(path, image, zone);
  throw Error(ExitCode::kUsage, path + ": the name must end in .png (for people) or .tif (values, georeferenced)");
}

void write_class_map(const std::string& path, const features::GridImage& classes, const Palette& palette,
                     const tiles::Zone& zone) {
  const std::string extension = std::filesystem::path(path).extension().string();
  if (extension != ".tif" && extension != ".tiff")
    throw Error(ExitCode::kUsage, path + ": the name of a class map must end in .tif");
  write_geotiff(path, classes, zone, palette);
}

}  // namespace landfix::tools
