// What is known about an input file: identity, provenance, place. Goes into the pack's manifest.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "builder/ingest/bounds.h"

namespace landfix::ingest {

/// What a band of an image shows. The order is the order of channels in an Epoch.
enum class BandRole : uint8_t { kGray, kRed, kGreen, kBlue, kNir };

/// "gray", "red", "green", "blue" or "nir".
const char* name_of(BandRole role);

/// What the command line says about one input file; it goes before the sidecar, which goes before the file itself.
struct SourceOptions {
  std::string path;        ///< any raster that GDAL opens
  std::string date = {};   ///< capture date "2009-08-18"; empty: undated
  std::string bands = {};  ///< images: a role for every band of the file, "nir,red,green" or "red,green,blue,-"
  std::string datum = {};  ///< heights: "ellipsoid", "egm96" or "EPSG:n"
  /// No data where all bands that are read have this value (images: 0 to 255), besides mask and alpha.
  std::optional<double> nodata = std::nullopt;
};

/// Provenance of an input. `path` is for messages only: it never goes into a pack.
struct Source {
  std::string path;
  std::string name;         ///< base name of the file
  std::string sha256;       ///< hex digest of the file; of a VRT, of the list of digests of all files it reads
  std::string date;         ///< "2009-08-18", or empty: undated
  std::string licence;      ///< from the sidecar; empty where not said
  std::string attribution;  ///< from the sidecar; empty where not said
  std::optional<double> georegistration_error_m;  ///< from the sidecar
  std::string crs;                                ///< "EPSG:3857" where it has a code, else its WKT
  std::string vertical_datum;                     ///< heights only: "ellipsoid", "egm96", "EPSG:5773", ...
  std::vector<BandRole> bands;                    ///< images only: roles of the channels that are read, ascending
  std::optional<double> nodata;  ///< as the command line or the sidecar says it; what the file itself says is not here
  double gsd_m = 0;              ///< native ground sample distance at the image's centre, in true metres on the ground
  GridBounds bounds;             ///< on the zone's grid, of the whole raster
};

}  // namespace landfix::ingest
