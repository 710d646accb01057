#include "builder/ingest/raster.h"

#include <cpl_conv.h>
#include <cpl_vsi.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "builder/error.h"
#include "builder/ingest/gdal.h"
#include "builder/ingest/smooth_map.h"
#include "builder/ingest/zone.h"

namespace landfix::ingest {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kOutlinePointsPerSide = 32;
constexpr int64_t kLargestPatch = int64_t(1) << 24;  ///< source pixels read at once, where a window can be divided
constexpr int64_t kLargestSinglePatch = int64_t(1) << 28;  ///< source pixels under one pixel of the grid
constexpr int kOpaque = 128;

Error bad_input(const std::string& path, const std::string& why) {
  return Error(ExitCode::kBadInput, fmt::format("{}: {}", path, why));
}

std::string cause(const GdalMessages& messages) { return messages.text().empty() ? "" : " (" + messages.text() + ")"; }

/// Transforms in place; what cannot be transformed becomes NaN.
void transform(OGRCoordinateTransformation& transformation, int count, double* x, double* y) {
  std::vector<int> good(size_t(count), 0);
  transformation.Transform(count, x, y, nullptr, good.data());
  for (int i = 0; i < count; ++i) {
    if (!good[size_t(i)] || !std::isfinite(x[i]) || !std::isfinite(y[i]))
      x[i] = y[i] = std::numeric_limits<double>::quiet_NaN();
  }
}

/// Leaves valid only what `condition` (0 or 255) holds for; an empty mask means all valid.
void restrict(cv::Mat& valid, const cv::Mat& condition) {
  valid = valid.empty() ? condition : cv::Mat(valid & condition);
}

/// 255 where all channels have these values (of the channels' precision), else 0.
cv::Mat equal_pixels(const cv::Mat& pixels, const std::vector<double>& values) {
  cv::Scalar value;
  for (size_t i = 0; i < values.size(); ++i)
    value[int(i)] = pixels.depth() == CV_32F ? double(float(values[i])) : values[i];
  cv::Mat equal;
  cv::inRange(pixels, value, value, equal);
  return equal;
}

OGRSpatialReference wgs84() {
  OGRSpatialReference crs;
  crs.importFromEPSG(4326);
  crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return crs;
}

}  // namespace

std::string wkt_of(const OGRSpatialReference& crs) {
  const char* const options[] = {"FORMAT=WKT2_2019", nullptr};
  char* text = nullptr;
  crs.exportToWkt(&text, options);
  const std::unique_ptr<char, decltype(&CPLFree)> owner(text, CPLFree);
  return text ? text : "";
}

OGRSpatialReference zone_crs(const tiles::Zone& zone) {
  OGRSpatialReference crs;
  crs.importFromEPSG(tiles::epsg_code(zone));
  crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return crs;
}

HandlePool::Handle& HandlePool::of(const Raster& raster) {
  OfThread& of_thread = of_thread_.local();
  std::list<Handle>& mine = of_thread.handles;
  const auto known = std::find_if(mine.begin(), mine.end(), [&](const Handle& h) { return h.raster == &raster; });
  if (known != mine.end()) {
    mine.splice(mine.begin(), mine, known);
    return mine.front();
  }
  if (mine.size() == kPerThread) mine.pop_back();
  Handle handle;
  handle.raster = &raster;
  handle.dataset = raster.open();
  handle.source_from_grid = raster.transformation(false);
  handle.scratch = &of_thread.scratch;
  mine.push_front(std::move(handle));
  return mine.front();
}

Channels Channels::bytes(GDALDataset& dataset, std::vector<int> bands, int alpha, std::optional<double> given) {
  Channels c;
  c.type = CV_8UC(int(bands.size()));
  c.bands = std::move(bands);
  c.alpha = alpha;
  const int flags = dataset.GetRasterBand(c.bands[0])->GetMaskFlags();
  if (alpha != 0) {
    c.mask = Mask::kAlpha;
  } else if ((flags & GMF_PER_DATASET) && !(flags & GMF_ALPHA)) {
    // A band that the user calls a colour is no alpha, whatever the file says.
    c.mask = Mask::kBand;
  }
  if (given) {
    c.nodata.assign(c.bands.size(), *given);
  } else if (c.mask == Mask::kNone && (flags & GMF_NODATA)) {
    for (const int band : c.bands) {
      int known = 0;
      c.nodata.push_back(dataset.GetRasterBand(band)->GetNoDataValue(&known));
      if (known) continue;
      c.nodata.clear();  // this band has data everywhere
      break;
    }
  }
  return c;
}

Channels Channels::heights(GDALDataset& dataset, std::optional<double> given) {
  Channels c;
  c.type = CV_32FC1;
  c.bands = {1};
  c.mask = (dataset.GetRasterBand(1)->GetMaskFlags() & GMF_ALL_VALID) ? Mask::kNone : Mask::kBand;
  if (given) c.nodata = {*given};
  return c;
}

Raster::Raster(std::string path, std::shared_ptr<HandlePool> pool) : path_(std::move(path)), pool_(std::move(pool)) {
  setup_gdal();
  dataset_ = open();
  width_ = dataset_->GetRasterXSize();
  height_ = dataset_->GetRasterYSize();
  if (dataset_->GetRasterCount() == 0) throw bad_input(path_, "has no raster bands");
  check_georeference();
  find_geographic_bounds();
}

GDALDatasetUniquePtr Raster::open() const {
  VSIStatBufL status;
  if (VSIStatExL(path_.c_str(), &status, VSI_STAT_EXISTS_FLAG) != 0) {
    throw Error(ExitCode::kIo, fmt::format("{}: no such file", path_));
  }
  const GdalMessages messages;
  GDALDatasetUniquePtr dataset(GDALDataset::Open(path_.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!dataset) throw bad_input(path_, "is not a raster that GDAL can read" + cause(messages));
  return dataset;
}

void Raster::check_georeference() {
  const bool placed = dataset_->GetGeoTransform(geotransform_) == CE_None;
  const bool identity =
      geotransform_[0] == 0 && geotransform_[3] == 0 && geotransform_[1] == 1 && std::abs(geotransform_[5]) == 1;
  if (!placed || identity) {
    if (dataset_->GetGCPCount() > 0) {
      throw bad_input(path_,
                      "has ground control points but is not rectified. Warp it first: gdalwarp -tps -r cubic IN OUT");
    }
    throw bad_input(path_,
                    "has no georeference. Expected a geotransform or world file; give it one, for instance "
                    "gdal_translate -a_srs EPSG:n -a_ullr WEST NORTH EAST SOUTH IN OUT");
  }
  if (geotransform_[2] != 0 || geotransform_[4] != 0) {
    throw bad_input(
        path_, "its geotransform is rotated or sheared. Turn it north up first: gdalwarp -r cubic -dstalpha IN OUT");
  }
  if (geotransform_[1] == 0 || geotransform_[5] == 0 ||
      !std::all_of(geotransform_, geotransform_ + 6, [](double v) { return std::isfinite(v); })) {
    throw bad_input(path_, "its geotransform is not usable: pixels of no size");
  }
  const OGRSpatialReference* crs = dataset_->GetSpatialRef();
  if (crs == nullptr || crs->IsEmpty() || crs->IsLocal() || !(crs->IsGeographic() || crs->IsProjected())) {
    throw bad_input(path_, fmt::format("its coordinate reference system is {}. Name it: gdal_edit.py -a_srs EPSG:n {}",
                                       crs == nullptr || crs->IsEmpty() ? "missing" : "unknown or local", path_));
  }
  crs_ = *crs;
  horizontal_crs_ = crs_;
  horizontal_crs_.StripVertical();
  horizontal_crs_.DemoteTo2D(nullptr);
  if (horizontal_crs_.IsGeographic()) longitude_period_ = 2 * std::numbers::pi / horizontal_crs_.GetAngularUnits();
}

std::vector<cv::Point2d> Raster::border(int points_per_side) const {
  std::vector<cv::Point2d> points;
  for (int side = 0; side < 4; ++side) {
    for (int i = 0; i < points_per_side; ++i) {
      const double f = double(i) / points_per_side;
      const double column = side == 0 ? f : side == 1 ? 1 : side == 2 ? 1 - f : 0;
      const double row = side == 0 ? 0 : side == 1 ? f : side == 2 ? 1 : 1 - f;
      points.emplace_back(geotransform_[0] + column * width_ * geotransform_[1],
                          geotransform_[3] + row * height_ * geotransform_[5]);
    }
  }
  return points;
}

void Raster::find_geographic_bounds() {
  const GdalMessages messages;
  const OGRSpatialReference target = wgs84();
  const std::unique_ptr<OGRCoordinateTransformation> to_wgs84(
      OGRCreateCoordinateTransformation(&horizontal_crs_, &target));
  if (!to_wgs84)
    throw bad_input(path_, "its coordinate reference system cannot be converted to WGS 84" + cause(messages));
  std::vector<cv::Point2d> points = border(kOutlinePointsPerSide);
  points.emplace_back(geotransform_[0] + 0.5 * width_ * geotransform_[1],
                      geotransform_[3] + 0.5 * height_ * geotransform_[5]);
  transform(*to_wgs84, 1, &points.back().x, &points.back().y);
  const double centre_deg = points.back().x;
  west_deg_ = south_deg_ = std::numeric_limits<double>::infinity();
  east_deg_ = north_deg_ = -std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < points.size(); ++i) {
    cv::Point2d& p = points[i];
    if (i + 1 < points.size()) transform(*to_wgs84, 1, &p.x, &p.y);
    if (std::isnan(p.x) || std::abs(p.y) > 90) {
      throw bad_input(
          path_, "lies where its own coordinate reference system is not defined: is the CRS right?" + cause(messages));
    }
    // Longitudes as neighbours of the centre, also across the antimeridian.
    p.x = centre_deg + std::remainder(p.x - centre_deg, 360.0);
    west_deg_ = std::min(west_deg_, p.x);
    east_deg_ = std::max(east_deg_, p.x);
    south_deg_ = std::min(south_deg_, p.y);
    north_deg_ = std::max(north_deg_, p.y);
  }
}

std::string Raster::name() const { return CPLGetFilename(path_.c_str()); }

std::string Raster::crs_text() const {
  const char* authority = crs_.GetAuthorityName(nullptr);
  const char* code = crs_.GetAuthorityCode(nullptr);
  if (authority && code) return fmt::format("{}:{}", authority, code);
  return wkt_of(crs_);
}

tiles::Geodetic Raster::centre() const {
  return {0.5 * (south_deg_ + north_deg_) * kDegree, std::remainder(0.5 * (west_deg_ + east_deg_), 360.0) * kDegree};
}

std::unique_ptr<OGRCoordinateTransformation> Raster::transformation(bool to_grid) const {
  const GdalMessages messages;
  const OGRSpatialReference grid = zone_crs(zone_);
  OGRCoordinateTransformationOptions options;
  options.SetBallparkAllowed(false);
  options.SetAreaOfInterest(std::max(-180.0, west_deg_), south_deg_, std::min(180.0, east_deg_), north_deg_);
  std::unique_ptr<OGRCoordinateTransformation> t(OGRCreateCoordinateTransformation(
      to_grid ? &horizontal_crs_ : &grid, to_grid ? &grid : &horizontal_crs_, options));
  if (!t) {
    throw bad_input(
        path_,
        fmt::format("PROJ knows no transformation between {} and {}{}. A datum grid may be missing (projsync, or the "
                    "package proj-data)",
                    crs_text(), grid.GetName(), cause(messages)));
  }
  return t;
}

void Raster::place(const tiles::Zone& zone, Channels channels) {
  zone_ = zone;
  channels_ = std::move(channels);
  find_outline();
  find_gsd();
}

void Raster::find_outline() {
  const auto to_grid = transformation(true);
  const GdalMessages messages;
  outline_ = border(kOutlinePointsPerSide);
  bounds_ = {};
  bool fits = true;
  for (const double latitude : {south_deg_, north_deg_}) {
    for (const double longitude : {west_deg_, east_deg_}) {
      fits = fits && tiles::grid_from_geodetic(zone_, {latitude * kDegree, longitude * kDegree}).has_value();
    }
  }
  for (cv::Point2d& p : outline_) {
    transform(*to_grid, 1, &p.x, &p.y);
    fits = fits && std::abs(p.x) < tiles::kDomainHalf && std::abs(p.y) < tiles::kDomainHalf;
    bounds_.extend({p.x, p.y, p.x, p.y});
  }
  if (!fits) {
    throw bad_input(path_,
                    fmt::format("does not fit onto the grid of zone {}{}. Choose the zone of the place with --zone",
                                zone_text(zone_), cause(messages)));
  }
}

void Raster::find_gsd() {
  const auto to_grid = transformation(true);
  const GdalMessages messages;
  const double x = geotransform_[0] + 0.5 * width_ * geotransform_[1],
               y = geotransform_[3] + 0.5 * height_ * geotransform_[5];
  double xs[] = {x - 0.5 * geotransform_[1], x + 0.5 * geotransform_[1], x, x};
  double ys[] = {y, y, y - 0.5 * geotransform_[5], y + 0.5 * geotransform_[5]};
  transform(*to_grid, 4, xs, ys);
  const double area = std::abs((xs[1] - xs[0]) * (ys[3] - ys[2]) - (xs[3] - xs[2]) * (ys[1] - ys[0]));
  const auto place = tiles::geodetic_from_grid(zone_, 0.5 * (xs[0] + xs[1]), 0.5 * (ys[0] + ys[1]));
  gsd_m_ = place ? std::sqrt(area) / place->scale : 0;
  if (!(gsd_m_ > 0)) throw bad_input(path_, "the size of its pixels on the ground cannot be told");
}

void Raster::source_from_grid(OGRCoordinateTransformation& transformation, double gsd_m, int count, double* x,
                              double* y) const {
  for (int i = 0; i < count; ++i) {
    x[i] = x[i] * gsd_m - moved_east_m_;
    y[i] = -y[i] * gsd_m - moved_north_m_;
  }
  transform(transformation, count, x, y);
  const double centre = geotransform_[0] + 0.5 * width_ * geotransform_[1];
  for (int i = 0; i < count; ++i) {
    if (longitude_period_ > 0) x[i] = centre + std::remainder(x[i] - centre, longitude_period_);
    x[i] = (x[i] - geotransform_[0]) / geotransform_[1];
    y[i] = (y[i] - geotransform_[3]) / geotransform_[5];
  }
}

/// Source coordinates of all pixels of the window, into the handle.
std::vector<Raster::Part> Raster::locate(HandlePool::Handle& handle, const PixelWindow& window) const {
  cv::Mat &to_x = handle.scratch->x, &to_y = handle.scratch->y;
  to_x.create(int(window.height), int(window.width), CV_64FC1);
  to_y.create(int(window.height), int(window.width), CV_64FC1);
  const PointFunction exact = [&](int count, double* x, double* y) {
    source_from_grid(*handle.source_from_grid, window.gsd_m, count, x, y);
  };
  std::vector<Part> parts;
  for_each_cell(window, [&](const Cell& cell, const cv::Rect& rect) {
    evaluate_in_cell(exact, kTolerance, window, cell, rect, to_x, to_y);
    // How far one step east and one step south go in the source, at the middle of the cell: the same for every window.
    const double column = double(cell.column + cell.side / 2), row = double(cell.row + cell.side / 2);
    double x[] = {column, column + 1, column}, y[] = {row, row, row + 1};
    exact(3, x, y);
    const Reduction reduction{std::hypot(x[1] - x[0], x[2] - x[0]), std::hypot(y[1] - y[0], y[2] - y[0])};
    const bool known = std::isfinite(reduction.x) && std::isfinite(reduction.y);
    parts.push_back({rect, known ? reduction : Reduction{}});
  });
  return parts;
}

/// The pixels of the raster that the kernels at these places need; nullopt for none.
std::optional<cv::Rect> Raster::source_window(const cv::Mat& x, const cv::Mat& y,
                                              const std::vector<Part>& parts) const {
  const double infinity = std::numeric_limits<double>::infinity();
  double west = infinity, east = -infinity, north = infinity, south = -infinity;
  for (int r = 0; r < x.rows; ++r) {
    const double* row_x = x.ptr<double>(r);
    const double* row_y = y.ptr<double>(r);
    for (int c = 0; c < x.cols; ++c) {  // comparisons in this order leave NaN out
      west = row_x[c] < west ? row_x[c] : west;
      east = row_x[c] > east ? row_x[c] : east;
      north = row_y[c] < north ? row_y[c] : north;
      south = row_y[c] > south ? row_y[c] : south;
    }
  }
  double margin_x = 1, margin_y = 1;
  for (const Part& p : parts) {
    margin_x = std::max(margin_x, kernel_radius(p.reduction.x));
    margin_y = std::max(margin_y, kernel_radius(p.reduction.y));
  }
  const int left = int(std::clamp(std::floor(west - margin_x - 1), 0.0, double(width_)));
  const int right = int(std::clamp(std::ceil(east + margin_x + 1), 0.0, double(width_)));
  const int top = int(std::clamp(std::floor(north - margin_y - 1), 0.0, double(height_)));
  const int bottom = int(std::clamp(std::ceil(south + margin_y + 1), 0.0, double(height_)));
  if (left >= right || top >= bottom) return std::nullopt;
  return cv::Rect(left, top, right - left, bottom - top);
}

/// Reads pixels and validity into the handle; false where nothing has data. `valid` stays empty where everything has.
bool Raster::read(HandlePool::Handle& handle, const cv::Rect& s) const {
  const GdalMessages messages;
  GDALDataset& dataset = *handle.dataset;
  const int count = int(channels_.bands.size());
  cv::Mat &pixels = handle.scratch->pixels, &valid = handle.scratch->valid;
  pixels.create(s.height, s.width, channels_.type);
  const GSpacing pixel_bytes = GSpacing(pixels.elemSize()), channel_bytes = GSpacing(pixels.elemSize1());
  std::vector<int> bands = channels_.bands;
  bool good = dataset.RasterIO(GF_Read, s.x, s.y, s.width, s.height, pixels.data, s.width, s.height,
                               channels_.type == CV_32FC1 ? GDT_Float32 : GDT_Byte, count, bands.data(), pixel_bytes,
                               GSpacing(pixels.step[0]), channel_bytes, nullptr) == CE_None;
  valid.release();
  if (good && (channels_.mask == Channels::Mask::kBand || channels_.mask == Channels::Mask::kAlpha)) {
    GDALRasterBand* band = channels_.mask == Channels::Mask::kAlpha
                               ? dataset.GetRasterBand(channels_.alpha)
                               : dataset.GetRasterBand(channels_.bands[0])->GetMaskBand();
    cv::Mat mask(s.height, s.width, CV_8UC1);
    good = band->RasterIO(GF_Read, s.x, s.y, s.width, s.height, mask.data, s.width, s.height, GDT_Byte, 1,
                          GSpacing(mask.step[0]), nullptr) == CE_None;
    valid = mask >= (channels_.mask == Channels::Mask::kAlpha ? kOpaque : 1);
  }
  // A damaged JPEG block is a mere warning to GDAL, and gray pixels.
  const bool damaged = messages.text().find("JPEG") != std::string::npos;
  if (!good || damaged || messages.failed()) {
    throw Error(
        ExitCode::kIo,
        fmt::format("{}: reading columns {} to {}, rows {} to {} failed{}. The file may be truncated or damaged: "
                    "compare it with its source, or try gdalinfo -checksum",
                    path_, s.x, s.x + s.width - 1, s.y, s.y + s.height - 1, cause(messages)));
  }
  if (!channels_.nodata.empty()) restrict(valid, ~equal_pixels(pixels, channels_.nodata));
  if (channels_.type == CV_32FC1) {
    restrict(valid, pixels == pixels);  // NaN equals nothing
    pixels.setTo(0, ~valid);
  }
  if (valid.empty()) return true;
  const int with_data = cv::countNonZero(valid);
  if (with_data == s.area()) valid.release();
  return with_data > 0;
}

int64_t Raster::fill_part(HandlePool::Handle& handle, const std::vector<Part>& parts, const cv::Rect& rect,
                          cv::Mat& pixels, cv::Mat& valid) const {
  const HandlePool::Scratch& scratch = *handle.scratch;
  const auto source = source_window(scratch.x(rect), scratch.y(rect), parts);
  if (!source) return 0;
  const int64_t patch = int64_t(source->width) * source->height;
  if (patch > kLargestPatch && rect.area() > 1) {
    const bool wide = rect.width >= rect.height;
    const cv::Rect first = wide ? cv::Rect(rect.x, rect.y, rect.width / 2, rect.height)
                                : cv::Rect(rect.x, rect.y, rect.width, rect.height / 2);
    const cv::Rect second = wide ? cv::Rect(first.br().x, rect.y, rect.width - first.width, rect.height)
                                 : cv::Rect(rect.x, first.br().y, rect.width, rect.height - first.height);
    return fill_part(handle, parts, first, pixels, valid) + fill_part(handle, parts, second, pixels, valid);
  }
  if (patch > kLargestSinglePatch) {
    throw bad_input(path_,
                    fmt::format("one pixel of the grid covers {} of its pixels: choose a finer GSD or reduce it with "
                                "gdal_translate -outsize",
                                patch));
  }
  if (!read(handle, *source)) return 0;
  const Patch piece{scratch.pixels, scratch.valid, source->x, source->y};
  int64_t filled = 0;
  for (const Part& part : parts) {
    const cv::Rect r = part.rect & rect;
    if (!r.empty()) filled += resample(piece, scratch.x(r), scratch.y(r), part.reduction, pixels(r), valid(r));
  }
  return filled;
}

void Raster::move(double east_m, double north_m) {
  moved_east_m_ += east_m;
  moved_north_m_ += north_m;
  bounds_ = {bounds_.west_m + east_m, bounds_.south_m + north_m, bounds_.east_m + east_m, bounds_.north_m + north_m};
  for (cv::Point2d& p : outline_) p += cv::Point2d(east_m, north_m);
}

bool Raster::may_touch(const GridBounds& b) const {
  // Kernels reach a little beyond the border, and the border is a curve between the outline's points.
  const double margin =
      2 * gsd_m_ + 1e-3 * std::max(bounds_.east_m - bounds_.west_m, bounds_.north_m - bounds_.south_m);
  return b.intersects(
      {bounds_.west_m - margin, bounds_.south_m - margin, bounds_.east_m + margin, bounds_.north_m + margin});
}

int64_t Raster::fill(const PixelWindow& window, cv::Mat pixels, cv::Mat valid) const {
  HandlePool::Handle& handle = pool_->of(*this);
  const std::vector<Part> parts = locate(handle, window);
  return fill_part(handle, parts, cv::Rect(0, 0, int(window.width), int(window.height)), pixels, valid);
}

}  // namespace landfix::ingest
