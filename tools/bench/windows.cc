// Random windows: the pack against memcpy from its own mapping and against GDAL on the same imagery.
#include <cpl_error.h>
#include <fmt/format.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>
#include <sys/resource.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <random>

#include "builder/error.h"
#include "tiles/grid.h"
#include "tools/bench/sections.h"
#include "tools/bench/timing.h"
#include "tools/common/manifest_json.h"
#include "tools/common/open_pack.h"

namespace landfix::bench {
namespace {

constexpr int kSide = 512;
constexpr size_t kBytes = size_t(kSide) * kSide;
constexpr int kRounds = 5;
constexpr double kEnough_s = 10;  ///< no further round after this time
constexpr int kGdalCacheMiB = 16;

constexpr const char* kMethod =
    "{} random windows of {}x{} px, the same for all, {} rounds (fewer after {} s); files in the page cache, pack "
    "prepared, one thread; p99 without windows that other programs interrupted; GDAL: dataset open, first band, "
    "GDAL_CACHEMAX={}";

using Pixels = std::vector<uint8_t>;

struct Place {
  double east_m, north_m;
};

/// Centres of windows, on pixels' corners, so that the windows end on pixels' edges and lie inside the image.
std::vector<Place> random_places(const lf_info& map, int count, uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto between = [&](double low, double high) {
    return std::floor(low + (high - low) * double(random() >> 11) * 0x1p-53);
  };
  std::vector<Place> places;
  for (int i = 0; i < count; ++i)
    places.push_back(
        {between(map.west_m + kSide, map.east_m - kSide), between(map.south_m + kSide, map.north_m - kSide)});
  return places;
}

/// A way to get the window of place `i`.
using Read = std::function<void(size_t i, uint8_t* out)>;

/// What the vehicle does: from mean and covariance to pixels.
class PackWindows {
 public:
  PackWindows(const Pack& pack, const std::vector<Place>& places)
      : pack_(pack), places_(places), layer_(*pack.find_layer("gray")) {}

  Region region(size_t i) const {
    // Three sigmas end just inside the edge of the outermost pixels.
    const double sigma = (kSide / 2 - 0.25) / 3;
    const Ellipse ellipse{places_[i].east_m, places_[i].north_m, sigma * sigma, 0, sigma * sigma, 3};
    return *pack_.region(layer_, ellipse, 1);
  }
  void read(size_t i, uint8_t* out) const { tools::check(pack_.read(region(i), {out, kBytes}, kSide), "window"); }
  void prepare() const {
    for (size_t i = 0; i < places_.size(); ++i) tools::check(pack_.prepare(region(i)), "window");
  }

 private:
  const Pack& pack_;
  const std::vector<Place>& places_;
  uint32_t layer_;
};

/// The least that can be done: rows copied from where they are known to lie in the mapping.
class Gather {
 public:
  Gather(const Pack& pack, const PackWindows& windows, size_t count) {
    for (size_t i = 0; i < count; ++i) pieces_.push_back(pieces_of(pack, windows.region(i)));
  }
  void read(size_t i, uint8_t* out) const {
    for (const Piece& p : pieces_[i])
      for (int y = 0; y < p.rows; ++y)
        std::memcpy(out + p.to + size_t(y) * kSide, p.from + size_t(y) * tiles::kTilePixels, p.columns);
  }

 private:
  /// What a window takes from one tile.
  struct Piece {
    const uint8_t* from;
    size_t to, columns;
    int rows;
  };

  static std::vector<Piece> pieces_of(const Pack& pack, const Region& r) {
    std::vector<Piece> pieces;
    uint64_t cursor = 0;
    lf_tile tile;
    while (lf_next_tile(pack.c_pack(), &r, nullptr, &cursor, &tile) == LF_OK) {
      const tiles::TileIndex index{tile.level, tile.x, tile.y};
      const int64_t column = tiles::first_column(index), row = tiles::first_row(index);
      const int64_t x0 = std::max(column, r.first_column),
                    x1 = std::min(column + tiles::kTilePixels, r.first_column + kSide);
      const int64_t y0 = std::max(row, r.first_row), y1 = std::min(row + tiles::kTilePixels, r.first_row + kSide);
      pieces.push_back({static_cast<const uint8_t*>(tile.pixels) + (y0 - row) * tile.row_bytes + (x0 - column),
                        size_t((y0 - r.first_row) * kSide + (x0 - r.first_column)), size_t(x1 - x0), int(y1 - y0)});
    }
    return pieces;
  }

  std::vector<std::vector<Piece>> pieces_;
};

/// Windows of the first band of an open dataset at its own pixels, around the same places.
class GdalWindows {
 public:
  GdalWindows(const std::filesystem::path& file, const tiles::Zone& zone, const std::vector<Place>& places,
              const char* const* open_options = nullptr)
      : data_(GDALDataset::Open(file.c_str(), GDAL_OF_RASTER | GDAL_OF_VERBOSE_ERROR, nullptr, open_options)) {
    if (!data_ || data_->GetGeoTransform(transform_) != CE_None) fail();
    OGRSpatialReference grid;
    grid.SetWellKnownGeogCS("WGS84");
    grid.SetUTM(zone.number, zone.north);
    const std::unique_ptr<OGRCoordinateTransformation> dataset_from_grid(
        OGRCreateCoordinateTransformation(&grid, data_->GetSpatialRef()));
    for (Place p : places) {
      dataset_from_grid->Transform(1, &p.east_m, &p.north_m);
      corners_.push_back({int(std::lround((p.east_m - transform_[0]) / transform_[1])) - kSide / 2,
                          int(std::lround((p.north_m - transform_[3]) / transform_[5])) - kSide / 2});
    }
  }
  void read(size_t i, uint8_t* out) const {
    const auto [x, y] = corners_[i];
    if (data_->GetRasterBand(1)->RasterIO(GF_Read, x, y, kSide, kSide, out, kSide, kSide, GDT_Byte, 0, 0, nullptr) !=
        CE_None)
      fail();
  }
  double pixel_size() const { return transform_[1]; }

 private:
  struct Corner {
    int x, y;
  };
  [[noreturn]] static void fail() { throw Error(ExitCode::kIo, CPLGetLastErrorMsg()); }

  GDALDatasetUniquePtr data_;
  double transform_[6];
  std::vector<Corner> corners_;
};

struct Timed {
  double median_s = 0;     ///< over all windows of all rounds
  double p99_s = 0;        ///< of the windows during which the scheduler left the thread its core; NaN without any
  double interrupted = 0;  ///< share of the others
};

/// How often the scheduler has taken the core from this thread for another one.
long interruptions() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_nivcsw;
}

/// Reads all windows in turn, several times over.
Timed time_windows(const std::string& name, size_t count, const Read& read) {
  say("reading windows: " + name);
  Pixels out(kBytes);
  std::vector<double> all, undisturbed;
  const Clock::time_point start = Clock::now();
  for (int round = 0; round < kRounds && (round == 0 || seconds_since(start) < kEnough_s); ++round) {
    for (size_t i = 0; i < count; ++i) {
      const long before = interruptions();
      all.push_back(time_of([&] { read(i, out.data()); }));
      if (interruptions() == before) undisturbed.push_back(all.back());
    }
  }
  return {median(all), undisturbed.empty() ? NAN : quantile(undisturbed, 0.99),
          1 - double(undisturbed.size()) / double(all.size())};
}

/// Brings a file into the page cache.
void warm_up(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::vector<char> buffer(size_t(1) << 20);
  while (in.read(buffer.data(), std::streamsize(buffer.size()))) {
  }
}

double mean(const Pixels& pixels, int margin) {
  double sum = 0;
  for (int y = margin; y < kSide - margin; ++y)
    for (int x = margin; x < kSide - margin; ++x) sum += pixels[size_t(y) * kSide + size_t(x)];
  return sum / ((kSide - 2.0 * margin) * (kSide - 2.0 * margin));
}

double mean_difference(const Pixels& a, const Pixels& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::abs(int(a[i]) - int(b[i]));
  return sum / double(a.size());
}

/// All windows once more, compared: exactly where nothing is lost; JPEG may be off by its own error, and another
/// projection shows the same ground in other pixels.
void compare(const PackWindows& pack, const Gather& gather, const GdalWindows& raw, const GdalWindows& cog,
             const GdalWindows& mbtiles, const std::vector<Place>& places, const Pack& geodesy, Report& report) {
  Pixels expected(kBytes), got(kBytes);
  double raw_differs = 0, gather_differs = 0, cog_worst = 0, mbtiles_worst = 0;
  for (size_t i = 0; i < places.size(); ++i) {
    pack.read(i, expected.data());
    gather.read(i, got.data());
    gather_differs += got != expected;
    raw.read(i, got.data());
    raw_differs += got != expected;
    cog.read(i, got.data());
    cog_worst = std::max(cog_worst, mean_difference(got, expected));
    mbtiles.read(i, got.data());
    const Place p = places[i];
    const double ground_m =
        mbtiles.pixel_size() * std::cos(geodesy.geodetic_from_grid(p.east_m, p.north_m)->latitude_rad);
    const int margin = std::max(0, int(kSide / 2 * (1 - ground_m)));
    mbtiles_worst = std::max(mbtiles_worst, std::abs(mean(expected, margin) - mean(got, 0)));
  }
  report.equal("check: memcpy, windows that differ", gather_differs, "windows", 0);
  report.equal("check: raw GeoTIFF, windows that differ", raw_differs, "windows", 0);
  report.equal("check: JPEG COG, mean difference in the worst window", cog_worst, "gray", 8);
  report.equal("check: MBTiles, difference of means in the worst window", mbtiles_worst, "gray", 3);
}

}  // namespace

void bench_windows(const Data& d, const Options& o, Report& report) {
  GDALAllRegister();
  GDALSetCacheMax64(int64_t(kGdalCacheMiB) << 20);
  report.section("windows", fmt::format(kMethod, o.windows, kSide, kSide, kRounds, kEnough_s, kGdalCacheMiB));
  for (const auto& file : {d.pack, d.raw, d.cog, d.mbtiles}) warm_up(file);
  const Pack pack = tools::open_pack(d.pack.string());
  const std::vector<Place> places = random_places(pack.info(), o.windows, o.seed);
  const tiles::Zone zone = tools::zone_of(pack);
  const PackWindows windows(pack, places);
  windows.prepare();
  const Gather gather(pack, windows, places.size());
  // GDAL writes gray as JPEG of three bands and would make up a fourth, alpha.
  constexpr const char* kThreeBands[] = {"BAND_COUNT=3", nullptr};
  const GdalWindows raw(d.raw, zone, places), cog(d.cog, zone, places), mbtiles(d.mbtiles, zone, places, kThreeBands);

  const auto reading = [&](const char* name, const auto& source) {
    return time_windows(name, places.size(), [&](size_t i, uint8_t* out) { source.read(i, out); });
  };
  const Timed t_pack = reading("pack", windows), t_gather = reading("memcpy", gather),
              t_raw = reading("raw GeoTIFF", raw), t_cog = reading("JPEG COG", cog),
              t_mbtiles = reading("MBTiles", mbtiles);

  report.measured("pack, region of an ellipse and read: median", t_pack.median_s * 1e3, "ms");
  report.at_most("pack, region of an ellipse and read: p99", t_pack.p99_s * 1e3, "ms", 0.2);
  report.measured("windows left out of p99: interrupted by other programs", 100 * t_pack.interrupted, "%");
  report.measured("memcpy from the same mapping: median", t_gather.median_s * 1e3, "ms");
  report.at_most("time of the pack over memcpy", t_pack.median_s / t_gather.median_s, "x", 2);
  report.measured("GDAL, raw tiled GeoTIFF: median", t_raw.median_s * 1e3, "ms");
  report.at_least("pack faster than raw tiled GeoTIFF", t_raw.median_s / t_pack.median_s, "x", 3);
  report.measured("GDAL, JPEG COG: median", t_cog.median_s * 1e3, "ms");
  report.at_least("pack faster than JPEG COG", t_cog.median_s / t_pack.median_s, "x", 30);
  report.measured("GDAL, MBTiles: median", t_mbtiles.median_s * 1e3, "ms");
  report.measured("pack faster than MBTiles", t_mbtiles.median_s / t_pack.median_s, "x");
  compare(windows, gather, raw, cog, mbtiles, places, pack, report);
}

}  // namespace landfix::bench
