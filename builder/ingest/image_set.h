// All images of a build as one thing: a stack of dated epochs on the pack's grid, read window by window.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "builder/ingest/pixel_window.h"
#include "builder/ingest/source.h"
#include "tiles/geodesy.h"
#include "tiles/grid.h"

namespace landfix::ingest {

/// Images of one capture date with the same bands.
struct EpochInfo {
  std::string date;             ///< "2009-08-18", or empty: undated
  std::vector<BandRole> roles;  ///< of the channels, ascending
  std::vector<int> sources;     ///< indices into ImageSet::sources(), ascending
};

/// One capture date in a window. Images of one date with different bands form separate epochs.
struct Epoch {
  std::string date;             ///< "2009-08-18", or empty: undated
  std::vector<BandRole> roles;  ///< of the channels of `bands`, ascending: red, green, blue, nir
  cv::Mat bands;                ///< H×W CV_8UC(n); 0 where not valid
  cv::Mat valid;                ///< H×W CV_8UC1: 255 where there is data, else 0; same size as `bands`, never all 0
  std::vector<int> sources;     ///< indices into ImageSet::sources() of the images that gave pixels, ascending
  size_t index = 0;             ///< in ImageSet::epochs()
};

struct Stack {
  tiles::PixelRect rect;
  std::vector<Epoch> epochs;  ///< newest first, undated last; only those with at least one valid pixel
};

/// Images of any CRS, overlapping, of several dates, resampled to one zone's grid. Within an epoch the image that was
/// listed first wins where it has data. Safe to read from many threads at once. A pixel's value does not depend on the
/// window it is read with.
///
/// Validity: a source pixel has no data where its alpha is below 128, where the dataset's mask is 0, or where all bands
/// that are read equal the file's nodata values. An output pixel is valid where at least 24 % of its kernel's weight
/// has data.
class ImageSet {
 public:
  /// Opens and checks every file, reads sidecars (`FILE.json`: date, licence, attribution, bands,
  /// georegistration_error_m) and hashes contents. `zone`: nullopt takes the standard zone of the centre of all images.
  /// Throws Error: kUsage for no file or a malformed date or band list of the options; kIo for missing files and failed
  /// reads; kBadInput for what cannot be used (no georeference, no CRS, rotated, not 8-bit, palette, malformed sidecar,
  /// off the zone's grid).
  explicit ImageSet(std::span<const SourceOptions> files, std::optional<tiles::Zone> zone = std::nullopt);
  ~ImageSet();
  ImageSet(ImageSet&&) noexcept;
  ImageSet& operator=(ImageSet&&) noexcept;

  const tiles::Zone& zone() const;
  const std::vector<Source>& sources() const;  ///< in the order of the files given
  /// Newest first, undated last; in the order of the files where dates are equal.
  const std::vector<EpochInfo>& epochs() const;
  const GridBounds& bounds() const;                  ///< union over all sources
  const std::vector<std::string>& warnings() const;  ///< what looks as if it were not meant
  double finest_gsd_m() const;                       ///< native GSD of the finest source
  int derived_level() const;                         ///< the level nearest to the finest source's GSD

  /// Whether some image's footprint may touch the rectangle (a cheap test by bounds).
  bool touches(const GridBounds& b) const;

  /// Outlines of the images on the grid as WKT multipolygon, densified; neighbours may overlap.
  std::string footprints_wkt() const;

  /// Resamples what every epoch shows in `rect`: bilinear, widened to the destination pixel where that is coarser than
  /// the source, at coordinates exact to 1e-4 source pixels (checked in every cell of the grid, see smooth_map.h).
  /// Throws Error: kIo naming the file where reading fails, kInternal for an empty window or one of more than 2^26
  /// pixels.
  Stack read(const tiles::PixelRect& rect) const;

  /// The same for a window of any GSD.
  std::vector<Epoch> read(const PixelWindow& window) const;

  /// What one source alone shows; nullopt where it has no data.
  std::optional<Epoch> read_source(size_t source, const PixelWindow& window) const;

  /// Moves a source on the grid from where its georeference puts it, in addition to what was moved before. Not while
  /// others read.
  void move_source(size_t source, double east_m, double north_m);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace landfix::ingest
