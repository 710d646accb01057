#include "builder/training/chips.h"

#include <fmt/format.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "builder/error.h"
#include "builder/ingest/gdal.h"
#include "builder/ingest/window.h"

namespace landfix::landmarks {
namespace {

constexpr const char* kHeader = "id,x,y,size_m,label";

struct Row {
  std::string id, label, where;
  double x = 0, y = 0, size_m = 0;
};

double number(const std::string& text, const std::string& where) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    throw Error(ExitCode::kBadInput, fmt::format("{}: expected a number, found '{}'", where, text));
  return value;
}

std::vector<Row> read_rows(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw Error(ExitCode::kIo, path + ": cannot be read");
  const auto next = [&](std::string& line) {
    if (!std::getline(file, line)) return false;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    return true;
  };
  std::string line;
  if (!next(line) || line != kHeader)
    throw Error(ExitCode::kBadInput, fmt::format("{}: expected the header '{}', found '{}'", path, kHeader, line));
  std::vector<Row> rows;
  for (int count = 2; next(line); ++count) {
    if (line.empty()) continue;
    std::vector<std::string> fields;
    std::istringstream stream(line);
    for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
    Row row;
    row.where = fmt::format("{}, line {}", path, count);
    if (fields.size() != 5)
      throw Error(ExitCode::kBadInput, fmt::format("{}: expected {}, found '{}'", row.where, kHeader, line));
    row.id = fields[0], row.label = fields[4];
    row.x = number(fields[1], row.where), row.y = number(fields[2], row.where);
    row.size_m = number(fields[3], row.where);
    if (row.size_m <= 0) throw Error(ExitCode::kBadInput, row.where + ": the size must be positive");
    rows.push_back(row);
  }
  return rows;
}

/// From the CRS of an image to degrees on WGS84.
class ToDegrees {
 public:
  explicit ToDegrees(const std::string& path) {
    ingest::setup_gdal();
    const GDALDatasetUniquePtr file(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER));
    if (!file || !file->GetSpatialRef()) throw Error(ExitCode::kBadInput, path + ": no image with a CRS");
    OGRSpatialReference from = *file->GetSpatialRef(), to;
    from.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    to.importFromEPSG(4326);
    to.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    transformation_.reset(OGRCreateCoordinateTransformation(&from, &to));
    if (!transformation_) throw Error(ExitCode::kBadInput, path + ": its CRS cannot be converted to degrees");
  }
  std::optional<tiles::GridPoint> on_grid(const tiles::Zone& zone, double x, double y) const {
    if (!transformation_->Transform(1, &x, &y)) return std::nullopt;
    constexpr double kRadians = M_PI / 180;
    return tiles::grid_from_geodetic(zone, {y * kRadians, x * kRadians});
  }

 private:
  std::unique_ptr<OGRCoordinateTransformation> transformation_;
};

bool inside(const features::GridImage& image, const Chip& chip, double size_m) {
  const double half = size_m / (2 * image.gsd_m);
  const double column = image.column_of(chip.east_m) + 0.5, row = image.row_of(chip.north_m) + 0.5;
  if (column < half || row < half || column > image.pixels.cols - half || row > image.pixels.rows - half) return false;
  return image.valid.at<uint8_t>(std::min(int(row), image.valid.rows - 1), std::min(int(column), image.valid.cols - 1));
}

/// Numbers the sets of squares that overlap, directly or through others.
void find_places(std::vector<Chip>& chips, const std::vector<double>& sizes_m) {
  std::vector<size_t> root(chips.size());
  std::iota(root.begin(), root.end(), size_t(0));
  const auto find = [&](size_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (size_t a = 0; a < chips.size(); ++a) {
    for (size_t b = 0; b < a; ++b) {
      const double reach = (sizes_m[a] + sizes_m[b]) / 2;
      if (std::abs(chips[a].east_m - chips[b].east_m) < reach && std::abs(chips[a].north_m - chips[b].north_m) < reach)
        root[find(a)] = find(b);
    }
  }
  for (size_t i = 0; i < chips.size(); ++i) chips[i].place = int(find(i));
}

}  // namespace

features::LandmarkLabel label_named(const std::string& name, const std::string& where) {
  const auto& names = features::kLandmarkLabelNames;
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    throw Error(ExitCode::kBadInput,
                fmt::format("{}: expected one of {}, found '{}'", where, fmt::join(names, ", "), name));
  return features::LandmarkLabel(found - names.begin());
}

features::GridImage load_evened(const std::string& path, tiles::Zone* zone) {
  const tiles::Zone own = ingest::standard_zone_of(path);
  if (zone) *zone = own;
  features::GridImage image = ingest::load_image({path}, own, std::nullopt, features::kWordGsdM);
  image.pixels = features::with_gain(image.pixels, features::word_gain(image.pixels, image.valid));
  return image;
}

LabelledImage read_chips(const std::string& csv_path, const std::string& image_path) {
  const std::vector<Row> rows = read_rows(csv_path);
  LabelledImage out;
  out.name = csv_path;
  tiles::Zone zone;
  out.image = load_evened(image_path, &zone);
  const ToDegrees to_degrees(image_path);
  std::vector<double> sizes_m;
  for (const Row& row : rows) {
    if (row.label == "mixed") continue;
    const std::optional<tiles::GridPoint> at = to_degrees.on_grid(zone, row.x, row.y);
    Chip chip{row.id, at ? at->east_m : NAN, at ? at->north_m : NAN, label_named(row.label, row.where), 0};
    if (!at || !inside(out.image, chip, row.size_m))
      throw Error(ExitCode::kBadInput, fmt::format("{}: the chip at {} {} of {} m is not inside {}; are its "
                                                   "coordinates in the CRS of the image?",
                                                   row.where, row.x, row.y, row.size_m, image_path));
    out.chips.push_back(chip);
    sizes_m.push_back(row.size_m);
  }
  if (out.chips.empty()) throw Error(ExitCode::kBadInput, csv_path + ": no labelled chip");
  find_places(out.chips, sizes_m);
  return out;
}

cv::Mat patch_at(const features::GridImage& image, double east_m, double north_m, const Warp& warp) {
  const double c = std::cos(warp.angle_rad) * warp.scale, s = std::sin(warp.angle_rad) * warp.scale;
  const double flip = warp.mirrored ? -1 : 1, middle = (kPatchPx - 1) / 2.0;
  const double column = image.column_of(east_m), row = image.row_of(north_m);
  const cv::Matx23d source_from_patch(c * flip, -s, column - (c * flip - s) * middle,  //
                                      s * flip, c, row - (s * flip + c) * middle);
  cv::Mat patch;
  cv::warpAffine(image.pixels, patch, source_from_patch, cv::Size(kPatchPx, kPatchPx),
                 cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REFLECT_101);
  return patch;
}

cv::Mat patch_at(const features::GridImage& image, double east_m, double north_m) {
  return patch_at(image, east_m, north_m, Warp{});
}

}  // namespace landfix::landmarks
