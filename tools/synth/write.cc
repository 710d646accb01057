// Writes a world to disk: tiles drawn in parallel, written in order, so that the files do not depend on the threads.
#include <cpl_error.h>
#include <fmt/format.h>
#include <gdal_priv.h>
#include <ogrsf_frmts.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>
#include <variant>

#include "builder/error.h"
#include "tools/synth/world.h"

namespace landfix::synth {
namespace {

namespace fs = std::filesystem;

constexpr int kTile = 512;
constexpr double kLabelChunk_m = 1024;

[[noreturn]] void fail(const fs::path& file) {
  throw Error(ExitCode::kIo, fmt::format("{}: cannot be written: {}; check free space and permissions, then run again",
                                         file.string(), CPLGetLastErrorMsg()));
}

/// Written tiles wait in GDAL's cache, which by default grows with the machine's memory.
class SmallCache {
 public:
  SmallCache() : before_(GDALGetCacheMax64()) { GDALSetCacheMax64(std::min<GIntBig>(before_, 64 << 20)); }
  ~SmallCache() { GDALSetCacheMax64(before_); }
  SmallCache(const SmallCache&) = delete;
  SmallCache& operator=(const SmallCache&) = delete;

 private:
  GIntBig before_;
};

/// A directory beside the results that vanishes unless its files are published.
class Staging {
 public:
  explicit Staging(fs::path target) : target_(std::move(target)), path_(target_ / ".synth.part") {
    std::error_code error;
    fs::create_directories(path_, error);
    if (error) {
      throw Error(ExitCode::kIo, fmt::format("{}: cannot make the directory: {}; choose another with -o",
                                             target_.string(), error.message()));
    }
  }
  ~Staging() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Staging(const Staging&) = delete;
  Staging& operator=(const Staging&) = delete;

  fs::path file(const std::string& name) {
    names_.push_back(name);
    return path_ / name;
  }

  std::vector<fs::path> publish() {
    std::vector<fs::path> files;
    for (const std::string& name : names_) {
      files.push_back(target_ / name);
      std::error_code error;
      fs::rename(path_ / name, files.back(), error);
      if (error)
        throw Error(ExitCode::kIo,
                    fmt::format("{}: cannot be renamed into place: {}", files.back().string(), error.message()));
    }
    return files;
  }

 private:
  fs::path target_, path_;
  std::vector<std::string> names_;
};

/// Runs `make(k)` for k = 0 … count − 1 in parallel and `take` on the results one at a time and in order.
template <typename Make, typename Take>
void in_order(int64_t count, int threads, Make make, Take take) {
  using Result = std::shared_ptr<decltype(make(int64_t{}))>;
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  int64_t next = 0;
  arena.execute([&] {
    const auto in_flight = static_cast<size_t>(2 * arena.max_concurrency());
    tbb::parallel_pipeline(
        in_flight,
        tbb::make_filter<void, int64_t>(tbb::filter_mode::serial_in_order, [&](tbb::flow_control& flow) -> int64_t {
          if (next == count) flow.stop();
          return next++;
        }) & tbb::make_filter<int64_t, Result>(tbb::filter_mode::parallel, [&](int64_t k) {
          return std::make_shared<typename Result::element_type>(make(k));
        }) & tbb::make_filter<Result, void>(tbb::filter_mode::serial_in_order, [&](const Result& r) { take(*r); }));
  });
}

OGRSpatialReference utm(const WorldOptions& options) {
  OGRSpatialReference crs;
  crs.importFromEPSG((options.south ? 32700 : 32600) + options.zone);
  crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return crs;
}

/// A GeoTIFF being written tile by tile.
class Raster {
 public:
  Raster(fs::path file, const WorldOptions& options, const Window& whole, int bands, GDALDataType type)
      : file_(std::move(file)) {
    CPLStringList creation;
    creation.SetNameValue("TILED", "YES");
    creation.SetNameValue("BLOCKXSIZE", fmt::format("{}", kTile).c_str());
    creation.SetNameValue("BLOCKYSIZE", fmt::format("{}", kTile).c_str());
    creation.SetNameValue("COMPRESS", "DEFLATE");
    creation.SetNameValue("ZLEVEL", "1");
    creation.SetNameValue("PREDICTOR", type == GDT_Float32 ? "3" : "2");
    creation.SetNameValue("INTERLEAVE", "PIXEL");
    creation.SetNameValue("BIGTIFF", "IF_SAFER");
    if (bands > 1) creation.SetNameValue("PHOTOMETRIC", "RGB");
    if (bands == 4) creation.SetNameValue("ALPHA", "NO");
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
    dataset_.reset(driver->Create(file_.c_str(), whole.width, whole.height, bands, type, creation.List()));
    if (!dataset_) fail(file_);
    std::array<double, 6> transform = {whole.west_m, whole.gsd_m, 0, whole.north_m, 0, -whole.gsd_m};
    dataset_->SetGeoTransform(transform.data());
    const OGRSpatialReference crs = utm(options);
    dataset_->SetSpatialRef(&crs);
    if (type == GDT_Float32) dataset_->SetMetadataItem("LANDFIX_VERTICAL_DATUM", "ellipsoid");
  }

  void write(int x, int y, const cv::Mat& pixels) {
    const int bands = pixels.channels();
    const GDALDataType type = pixels.depth() == CV_8U ? GDT_Byte : GDT_Float32;
    const auto bytes = static_cast<GSpacing>(pixels.elemSize1());
    const CPLErr error =
        dataset_->RasterIO(GF_Write, x, y, pixels.cols, pixels.rows, pixels.data, pixels.cols, pixels.rows, type, bands,
                           nullptr, bytes * bands, static_cast<GSpacing>(pixels.step[0]), bytes, nullptr);
    if (error != CE_None) fail(file_);
  }

  void close() {
    CPLErrorReset();
    dataset_.reset();
    if (CPLGetLastErrorType() >= CE_Failure) fail(file_);
  }

 private:
  fs::path file_;
  GDALDatasetUniquePtr dataset_;
};

struct TileGrid {
  Window whole;

  int64_t columns() const { return (whole.width + kTile - 1) / kTile; }
  int64_t rows() const { return (whole.height + kTile - 1) / kTile; }
  int64_t count() const { return columns() * rows(); }
  int x(int64_t k) const { return static_cast<int>(k % columns()) * kTile; }
  int y(int64_t k) const { return static_cast<int>(k / columns()) * kTile; }
  Window tile(int64_t k) const {
    return {whole.west_m + x(k) * whole.gsd_m, whole.north_m - y(k) * whole.gsd_m, std::min(kTile, whole.width - x(k)),
            std::min(kTile, whole.height - y(k)), whole.gsd_m};
  }
};

/// The world's extent in whole pixels.
TileGrid tile_grid(const Rectangle& extent, double gsd_m) {
  const int64_t left = std::llround(extent.west_m / gsd_m), right = std::llround(extent.east_m / gsd_m);
  const int64_t bottom = std::llround(extent.south_m / gsd_m), top = std::llround(extent.north_m / gsd_m);
  return {{static_cast<double>(left) * gsd_m, static_cast<double>(top) * gsd_m, static_cast<int>(right - left),
           static_cast<int>(top - bottom), gsd_m}};
}

/// One GeoJSON file. OGR brings the grid's coordinates to longitude and latitude.
class LabelFile {
 public:
  LabelFile(fs::path file, const WorldOptions& options, OGRwkbGeometryType type,
            const std::vector<std::pair<const char*, OGRFieldType>>& fields)
      : file_(std::move(file)) {
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GeoJSON");
    dataset_.reset(driver->Create(file_.c_str(), 0, 0, 0, GDT_Unknown, nullptr));
    if (!dataset_) fail(file_);
    OGRSpatialReference crs = utm(options);
    CPLStringList creation;
    creation.SetNameValue("RFC7946", "YES");
    creation.SetNameValue("COORDINATE_PRECISION", "9");
    creation.SetNameValue("SIGNIFICANT_FIGURES", "12");
    layer_ = dataset_->CreateLayer(file_.stem().c_str(), &crs, type, creation.List());
    if (layer_ == nullptr) fail(file_);
    for (const auto& [name, field_type] : fields) add_field(name, field_type);
    add_field("easting_m", OFTReal);
    add_field("northing_m", OFTReal);
  }

  /// `values` in the order of the fields: numbers or text.
  void add(const OGRGeometry& geometry, Point centre, const std::vector<std::variant<double, std::string>>& values) {
    OGRFeature feature(layer_->GetLayerDefn());
    for (size_t k = 0; k < values.size(); ++k) {
      std::visit([&](const auto& v) { set(feature, static_cast<int>(k), v); }, values[k]);
    }
    set(feature, static_cast<int>(values.size()), centre.x);
    set(feature, static_cast<int>(values.size()) + 1, centre.y);
    feature.SetGeometry(&geometry);
    if (layer_->CreateFeature(&feature) != OGRERR_NONE) fail(file_);
    ++count_;
  }

  int64_t close() {
    CPLErrorReset();
    dataset_.reset();
    if (CPLGetLastErrorType() >= CE_Failure) fail(file_);
    return count_;
  }

 private:
  void add_field(const char* name, OGRFieldType type) {
    OGRFieldDefn definition(name, type);
    if (layer_->CreateField(&definition) != OGRERR_NONE) fail(file_);
  }
  static void set(OGRFeature& feature, int field, double value) {
    feature.SetField(field, std::round(value * 1000) / 1000);
  }
  static void set(OGRFeature& feature, int field, const std::string& value) { feature.SetField(field, value.c_str()); }

  fs::path file_;
  GDALDatasetUniquePtr dataset_;
  OGRLayer* layer_ = nullptr;
  int64_t count_ = 0;
};

OGRPolygon polygon_of(const Outline& outline) {
  OGRLinearRing ring;
  for (const Point& p : outline) ring.addPoint(p.x, p.y);
  ring.closeRings();
  OGRPolygon polygon;
  polygon.addRing(&ring);
  return polygon;
}

OGRLineString line_of(const std::vector<Point>& points) {
  OGRLineString line;
  for (const Point& p : points) line.addPoint(p.x, p.y);
  return line;
}

Point middle(const std::vector<Point>& points) {
  const Rectangle r = bounds_of(points);
  return {(r.west_m + r.east_m) / 2, (r.south_m + r.north_m) / 2};
}

/// The six files of truth.
class LabelWriter {
 public:
  LabelWriter(Staging& staging, const WorldOptions& options)
      : buildings_(staging.file("buildings.geojson"), options, wkbPolygon,
                   {{"height_m", OFTReal}, {"eave_m", OFTReal}, {"base_m", OFTReal}, {"roof", OFTString}}),
        trees_(staging.file("trees.geojson"), options, wkbPoint,
               {{"radius_m", OFTReal}, {"height_m", OFTReal}, {"base_m", OFTReal}, {"leaf", OFTString}}),
        roads_(staging.file("roads.geojson"), options, wkbLineString, {{"width_m", OFTReal}, {"kind", OFTString}}),
        intersections_(staging.file("intersections.geojson"), options, wkbPoint, {{"degree", OFTReal}}),
        fields_(staging.file("fields.geojson"), options, wkbPolygon, {{"crop", OFTString}}),
        water_(staging.file("water.geojson"), options, wkbPolygon, {{"level_m", OFTReal}}) {}

  /// Writes the labels whose middle, moved into the world, lies in `chunk`: every object of the world once.
  void add(const Labels& labels, const Rectangle& chunk, const Rectangle& world) {
    const auto owned = [&](Point p) {
      constexpr double kInside_m = 1e-6;
      return chunk.contains({std::clamp(p.x, world.west_m, world.east_m - kInside_m),
                             std::clamp(p.y, world.south_m, world.north_m - kInside_m)});
    };
    const auto kind = [](auto value) { return std::string(name_of(value)); };
    for (const Building& b : labels.buildings) {
      const Outline outline = b.outline();
      if (owned(middle(outline)))
        buildings_.add(polygon_of(outline), b.centre, {b.height_m, b.eave_m, b.base_m, kind(b.roof)});
    }
    for (const Tree& t : labels.trees) {
      trees_.add(OGRPoint(t.position.x, t.position.y), t.position,
                 {t.radius_m, t.height_m, t.base_m, std::string(t.conifer ? "needle" : "broad")});
    }
    for (const Road& r : labels.roads) {
      if (owned(middle(r.line))) roads_.add(line_of(r.line), middle(r.line), {r.width_m, kind(r.kind)});
    }
    for (const Intersection& i : labels.intersections) {
      intersections_.add(OGRPoint(i.position.x, i.position.y), i.position, {static_cast<double>(i.degree)});
    }
    for (const Field& f : labels.fields) {
      if (owned(middle(f.outline))) fields_.add(polygon_of(f.outline), middle(f.outline), {kind(f.crop)});
    }
    for (const Lake& l : labels.water) {
      const Outline shore = l.outline();
      if (owned(middle(shore))) water_.add(polygon_of(shore), l.centre, {l.level_m});
    }
  }

  void close(WriteSummary& summary) {
    summary.buildings = buildings_.close();
    summary.trees = trees_.close();
    summary.roads = roads_.close();
    summary.intersections = intersections_.close();
    summary.fields = fields_.close();
    summary.water = water_.close();
  }

 private:
  LabelFile buildings_, trees_, roads_, intersections_, fields_, water_;
};

void write_sidecar(const fs::path& file, const WorldOptions& options) {
  const nlohmann::ordered_json sidecar = {
      {"date", date_of(options.year, options.season)}, {"licence", "CC0-1.0"}, {"attribution", "landfix synth"}};
  std::ofstream out(file);
  out << sidecar.dump(2) << '\n';
  out.close();
  if (!out) fail(file);
}

/// Draws, writes and counts what is done.
class Writer {
 public:
  Writer(const WorldOptions& options, const fs::path& directory, const WriteOptions& how)
      : world_(options),
        how_(how),
        staging_(directory),
        ortho_(tile_grid(world_.extent(), options.gsd_m)),
        heights_(tile_grid(world_.extent(), options.dem_gsd_m)) {}

  WriteSummary write() {
    write_ortho();
    write_heights();
    write_labels();
    write_sidecar(staging_.file("ortho.tif.json"), world_.options());
    summary_.files = staging_.publish();
    if (how_.on_progress) how_.on_progress(1);
    return summary_;
  }

 private:
  void write_ortho() {
    Raster raster(staging_.file("ortho.tif"), world_.options(), ortho_.whole, world_.options().near_infrared ? 4 : 3,
                  GDT_Byte);
    in_order(
        ortho_.count(), how_.threads, [&](int64_t k) { return std::pair(k, world_.ortho(ortho_.tile(k))); },
        [&](const auto& tile) {
          raster.write(ortho_.x(tile.first), ortho_.y(tile.first), tile.second.pixels);
          advance(summary_.ortho_pixels, tile.second.pixels);
        });
    raster.close();
  }

  void write_heights() {
    Raster dtm(staging_.file("dtm.tif"), world_.options(), heights_.whole, 1, GDT_Float32);
    Raster dsm(staging_.file("dsm.tif"), world_.options(), heights_.whole, 1, GDT_Float32);
    in_order(
        heights_.count(), how_.threads, [&](int64_t k) { return std::pair(k, world_.heights(heights_.tile(k))); },
        [&](const auto& tile) {
          const auto& [k, images] = tile;
          dtm.write(heights_.x(k), heights_.y(k), images.first.pixels);
          dsm.write(heights_.x(k), heights_.y(k), images.second.pixels);
          advance(summary_.height_pixels, images.first.pixels);
        });
    dtm.close();
    dsm.close();
  }

  void write_labels() {
    const Rectangle extent = world_.extent();
    const auto side = static_cast<int64_t>(std::ceil(world_.options().size_m / kLabelChunk_m));
    LabelWriter writer(staging_, world_.options());
    const auto chunk = [&](int64_t k) {
      const double west = extent.west_m + static_cast<double>(k % side) * kLabelChunk_m;
      const double south = extent.south_m + static_cast<double>(k / side) * kLabelChunk_m;
      return Rectangle{west, south, std::min(west + kLabelChunk_m, extent.east_m),
                       std::min(south + kLabelChunk_m, extent.north_m)};
    };
    in_order(
        side * side, how_.threads, [&](int64_t k) { return std::pair(k, world_.labels(chunk(k))); },
        [&](const auto& made) { writer.add(made.second, chunk(made.first), extent); });
    writer.close(summary_);
  }

  void advance(int64_t& counter, const cv::Mat& pixels) {
    counter += static_cast<int64_t>(pixels.total());
    const auto total = [](const Window& w) { return static_cast<double>(w.width) * w.height; };
    const auto done = static_cast<double>(summary_.ortho_pixels + summary_.height_pixels);
    if (how_.on_progress) how_.on_progress(done / (total(ortho_.whole) + total(heights_.whole)));
  }

  World world_;
  WriteOptions how_;
  Staging staging_;
  TileGrid ortho_, heights_;
  WriteSummary summary_;
};

}  // namespace

WriteSummary write_world(const WorldOptions& options, const fs::path& directory, const WriteOptions& how) {
  GDALAllRegister();
  const SmallCache cache;
  return Writer(options, directory, how).write();
}

}  // namespace landfix::synth
