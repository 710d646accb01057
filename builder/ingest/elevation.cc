#include "builder/ingest/elevation.h"

#include <fmt/format.h>

#include <cmath>

#include "builder/error.h"
#include "builder/ingest/hash.h"
#include "builder/ingest/provenance.h"
#include "builder/ingest/raster.h"
#include "builder/ingest/smooth_map.h"
#include "builder/ingest/vertical.h"

namespace landfix::ingest {
namespace {

constexpr const char* kDatumItem = "LANDFIX_VERTICAL_DATUM";
constexpr double kShiftToleranceM = 0.5e-3;
constexpr double kFoot = 0.3048, kSurveyFoot = 1200.0 / 3937.0;

/// The datum that the file itself states, by metadata or CRS; empty: none.
std::string datum_in_file(Raster& raster) {
  if (const char* item = raster.dataset().GetMetadataItem(kDatumItem)) {
    return parse_datum(item, ExitCode::kBadInput, raster.path() + ": " + kDatumItem);
  }
  return datum_of(raster.crs());
}

std::string choose_datum(const SourceOptions& file, const Sidecar& sidecar, Raster& raster,
                         std::vector<std::string>& warnings) {
  const std::string in_file = datum_in_file(raster);
  std::string given;
  if (!file.datum.empty()) {
    given = parse_datum(file.datum, ExitCode::kUsage, file.path);
  } else if (!sidecar.datum.empty()) {
    given = parse_datum(sidecar.datum, ExitCode::kBadInput, file.path + ".json");
  }
  if (given.empty() && in_file.empty()) {
    throw Error(
        ExitCode::kBadInput,
        fmt::format(
            "{}: does not say what its heights refer to. Say it with --dem-datum ellipsoid, --dem-datum egm96 or "
            "--dem-datum EPSG:n (a vertical CRS), or with \"datum\" in {}.json",
            file.path, file.path));
  }
  if (!given.empty() && !in_file.empty() && given != in_file) {
    warnings.push_back(
        fmt::format("{}: heights taken as above {}, as given, although the file says {}", file.path, given, in_file));
  }
  return given.empty() ? in_file : given;
}

double metres_of_unit(const std::string& unit, const std::string& path) {
  if (unit.empty() || unit == "m" || unit == "metre" || unit == "meter" || unit == "metres" || unit == "meters")
    return 1;
  if (unit == "ft" || unit == "foot" || unit == "feet") return kFoot;
  if (unit == "US survey foot" || unit == "us-ft" || unit == "ftUS" || unit == "sft") return kSurveyFoot;
  throw Error(
      ExitCode::kBadInput,
      fmt::format(
          "{}: heights in \"{}\"; expected metres or feet. Convert them, or correct it: gdal_edit.py -units m {}", path,
          unit, path));
}

void require_one_height_band(GDALDataset& dataset, const std::string& path) {
  if (dataset.GetRasterCount() != 1) {
    throw Error(ExitCode::kBadInput,
                fmt::format("{}: has {} bands; expected heights in one. Choose it: gdal_translate -b N IN OUT", path,
                            dataset.GetRasterCount()));
  }
  if (GDALDataTypeIsComplex(dataset.GetRasterBand(1)->GetRasterDataType())) {
    throw Error(ExitCode::kBadInput, fmt::format("{}: has complex pixels; expected heights", path));
  }
}

}  // namespace

struct ElevationModel::Impl {
  explicit Impl(const SourceOptions& file) : raster(file.path, std::make_shared<HandlePool>()) {}

  Raster raster;
  Source source;
  std::vector<std::string> warnings;
  double factor = 1, offset = 0;                         // datum units = factor * stored + offset
  std::unique_ptr<VerticalTransformation> to_ellipsoid;  // none: they are already
};

ElevationModel::ElevationModel(const SourceOptions& file, const tiles::Zone& zone)
    : impl_(std::make_unique<Impl>(file)) {
  Raster& raster = impl_->raster;
  require_one_height_band(raster.dataset(), file.path);
  const Sidecar sidecar = read_sidecar(file.path);
  Source& s = impl_->source;
  s.vertical_datum = choose_datum(file, sidecar, raster, impl_->warnings);
  s.nodata = file.nodata ? file.nodata : sidecar.nodata;
  raster.place(zone, Channels::heights(raster.dataset(), s.nodata));
  GDALRasterBand& band = *raster.dataset().GetRasterBand(1);
  // A vertical CRS in feet brings its unit along; else the band's own unit counts.
  const bool unit_by_datum = metres_per_unit(s.vertical_datum) != 1;
  const double unit = unit_by_datum ? 1 : metres_of_unit(band.GetUnitType(), file.path);
  impl_->factor = band.GetScale() * unit;
  impl_->offset = band.GetOffset() * unit;
  if (s.vertical_datum != kEllipsoid) {
    impl_->to_ellipsoid = std::make_unique<VerticalTransformation>(s.vertical_datum, zone, raster.bounds(), file.path);
  }
  s.path = file.path;
  s.name = raster.name();
  s.date = file.date.empty() ? sidecar.date : file.date;
  s.licence = sidecar.licence;
  s.attribution = sidecar.attribution;
  s.georegistration_error_m = sidecar.georegistration_error_m;
  s.crs = raster.crs_text();
  s.gsd_m = raster.gsd_m();
  s.bounds = raster.bounds();
  s.sha256 = raster_sha256(file.path);
}

ElevationModel::~ElevationModel() = default;
ElevationModel::ElevationModel(ElevationModel&&) noexcept = default;
ElevationModel& ElevationModel::operator=(ElevationModel&&) noexcept = default;

const Source& ElevationModel::source() const { return impl_->source; }
const std::vector<std::string>& ElevationModel::warnings() const { return impl_->warnings; }

void ElevationModel::require_overlap(const GridBounds& area) const {
  const GridBounds& b = impl_->raster.bounds();
  if (b.intersects(area)) return;
  throw Error(
      ExitCode::kNoData,
      fmt::format("{}: the heights do not overlap the images: they cover easting {:.0f} to {:.0f}, northing {:.0f} to "
                  "{:.0f} of "
                  "the grid, the area {:.0f} to {:.0f}, {:.0f} to {:.0f}. Is it the right file, and is its CRS right?",
                  impl_->source.path, b.west_m, b.east_m, b.south_m, b.north_m, area.west_m, area.east_m, area.south_m,
                  area.north_m));
}

features::GridImage ElevationModel::read(const PixelWindow& window) const {
  require_readable(window);
  const cv::Size size(int(window.width), int(window.height));
  features::GridImage image{cv::Mat::zeros(size, CV_32FC1), cv::Mat::zeros(size, CV_8UC1),
                            double(window.column) * window.gsd_m, -double(window.row) * window.gsd_m, window.gsd_m};
  if (!impl_->raster.may_touch(window.bounds()) || impl_->raster.fill(window, image.pixels, image.valid) == 0)
    return image;
  cv::Mat shift = cv::Mat::zeros(size, CV_64FC1), scale = cv::Mat::ones(size, CV_64FC1);
  if (impl_->to_ellipsoid) {
    const PointFunction exact = [&](int count, double* x, double* y) {
      for (int i = 0; i < count; ++i) {
        x[i] *= window.gsd_m;
        y[i] *= -window.gsd_m;
      }
      impl_->to_ellipsoid->shift_and_scale(count, x, y);
    };
    for_each_cell(window, [&](const Cell& cell, const cv::Rect& part) {
      evaluate_in_cell(exact, kShiftToleranceM, window, cell, part, shift, scale);
    });
  }
  for (int r = 0; r < size.height; ++r) {
    for (int c = 0; c < size.width; ++c) {
      if (!image.valid.at<uchar>(r, c)) continue;
      float& height = image.pixels.at<float>(r, c);
      height =
          float(shift.at<double>(r, c) + scale.at<double>(r, c) * (impl_->factor * double(height) + impl_->offset));
      if (std::isfinite(height)) continue;
      throw Error(ExitCode::kBadInput,
                  fmt::format("{}: PROJ's grid for {} ends inside the raster: crop the heights or convert them first",
                              impl_->source.path, impl_->source.vertical_datum));
    }
  }
  return image;
}

}  // namespace landfix::ingest
