// One georeferenced raster file, read onto a zone's grid: opened, checked, placed, resampled.
#pragma once

#include <gdal_priv.h>
#include <ogr_spatialref.h>
#include <tbb/enumerable_thread_specific.h>

#include <list>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "builder/ingest/pixel_window.h"
#include "builder/ingest/sampler.h"
#include "tiles/geodesy.h"

namespace landfix::ingest {

class Raster;

/// GDAL's datasets and transformations serve one thread at a time: each thread opens its own, and keeps the last few.
/// Threads keep their own because datasets inside a VRT are shared by all VRTs of the thread that opened them.
class HandlePool {
 public:
  /// Kept to save allocations; one per thread, since a window's worth is tens of megabytes.
  struct Scratch {
    cv::Mat x, y, pixels, valid;
  };
  struct Handle {
    const Raster* raster = nullptr;
    GDALDatasetUniquePtr dataset;
    std::unique_ptr<OGRCoordinateTransformation> source_from_grid;
    Scratch* scratch = nullptr;  ///< shared by all handles of the thread
  };

  /// This thread's handle of a raster; valid until its next call.
  Handle& of(const Raster& raster);

 private:
  static constexpr size_t kPerThread = 16;
  struct OfThread {
    std::list<Handle> handles;
    Scratch scratch;
  };
  tbb::enumerable_thread_specific<OfThread> of_thread_;
};

/// What is read of a raster: its channels and what tells where they have data.
struct Channels {
  enum class Mask { kNone, kBand, kAlpha };

  int type = CV_8UC1;          ///< CV_8UC(n) or CV_32FC1
  std::vector<int> bands;      ///< GDAL's numbers
  Mask mask = Mask::kNone;     ///< kBand: mask band of the first band, not 0; kAlpha: band `alpha`, from 128
  int alpha = 0;               ///< GDAL's number
  std::vector<double> nodata;  ///< per band: no data where all bands have these values; empty: none

  /// Channels of bytes. Nodata values of the file count where all of `bands` have theirs (one band alone may well be 0
  /// in water), unless `given` replaces them.
  static Channels bytes(GDALDataset& dataset, std::vector<int> bands, int alpha, std::optional<double> given);
  /// One channel of floats.
  static Channels heights(GDALDataset& dataset, std::optional<double> given);
};

class Raster {
 public:
  /// Largest error of the interpolated projection, in source pixels.
  static constexpr double kTolerance = 1e-4;

  /// Opens the file and checks that it is a north-up raster with a known CRS. Throws Error (kIo: no such file;
  /// kBadInput).
  Raster(std::string path, std::shared_ptr<HandlePool> pool);

  const std::string& path() const { return path_; }
  std::string name() const;                                ///< base name
  std::string crs_text() const;                            ///< "EPSG:n" or WKT
  const OGRSpatialReference& crs() const { return crs_; }  ///< as in the file, with its vertical part
  GDALDataset& dataset() { return *dataset_; }             ///< for inspection while setting up
  tiles::Geodetic centre() const;

  /// Sets what is read and onto which grid. Throws Error (kBadInput) where the raster does not fit onto the zone's grid
  /// or PROJ knows no transformation.
  void place(const tiles::Zone& zone, Channels channels);

  const GridBounds& bounds() const { return bounds_; }
  double gsd_m() const { return gsd_m_; }
  const std::vector<cv::Point2d>& outline() const { return outline_; }  ///< densified, on the grid, not closed

  /// Moves the raster on the grid, in addition to what was moved before.
  void move(double east_m, double north_m);

  /// Whether the raster may have data in `b`: by bounds, generously.
  bool may_touch(const GridBounds& b) const;

  /// Fills those pixels of `pixels` that are not yet `valid`. Both of the window's size; CV_8UC(n) or CV_32FC1 and
  /// CV_8UC1. Returns how many were filled. Throws Error (kIo) where reading fails. Safe to call from many threads.
  int64_t fill(const PixelWindow& window, cv::Mat pixels, cv::Mat valid) const;

 private:
  friend class HandlePool;
  struct Part {
    cv::Rect rect;
    Reduction reduction;
  };
  GDALDatasetUniquePtr open() const;
  std::unique_ptr<OGRCoordinateTransformation> transformation(bool to_grid) const;
  void check_georeference();
  void find_geographic_bounds();
  void find_outline();
  void find_gsd();
  void source_from_grid(OGRCoordinateTransformation& transformation, double gsd_m, int count, double* x,
                        double* y) const;
  std::vector<cv::Point2d> border(int points_per_side) const;
  std::vector<Part> locate(HandlePool::Handle& handle, const PixelWindow& window) const;
  std::optional<cv::Rect> source_window(const cv::Mat& x, const cv::Mat& y, const std::vector<Part>& parts) const;
  bool read(HandlePool::Handle& handle, const cv::Rect& source) const;
  int64_t fill_part(HandlePool::Handle& handle, const std::vector<Part>& parts, const cv::Rect& rect, cv::Mat& pixels,
                    cv::Mat& valid) const;

  std::string path_;
  std::shared_ptr<HandlePool> pool_;
  GDALDatasetUniquePtr dataset_;
  OGRSpatialReference crs_, horizontal_crs_;
  double geotransform_[6] = {};
  int width_ = 0, height_ = 0;
  double longitude_period_ = 0;  ///< 360 degrees in units of a geographic CRS; 0: not geographic
  double west_deg_ = 0, south_deg_ = 0, east_deg_ = 0, north_deg_ = 0;
  tiles::Zone zone_;
  Channels channels_;
  GridBounds bounds_;
  std::vector<cv::Point2d> outline_;
  double gsd_m_ = 0;
  double moved_east_m_ = 0, moved_north_m_ = 0;
};

/// A CRS as WKT2.
std::string wkt_of(const OGRSpatialReference& crs);

/// The CRS of a zone, easting first.
OGRSpatialReference zone_crs(const tiles::Zone& zone);

}  // namespace landfix::ingest
