// Which band of an image shows what.
#pragma once

#include <gdal_priv.h>

#include <string>
#include <vector>

#include "builder/error.h"
#include "builder/ingest/source.h"

namespace landfix::ingest {

struct BandLayout {
  std::vector<BandRole> roles;  ///< ascending
  std::vector<int> bands;       ///< GDAL's number (from 1) of the band of each role
  int alpha = 0;                ///< GDAL's number of the alpha band; 0: none
};

/// `text`: a role for every band of the file, in the file's order, separated by commas: gray, red, green, blue, nir,
/// alpha, or "-" for a band to leave out. Empty: by the file's colour interpretation; where that is silent, 1 band is
/// gray, 3 are red, green, blue, 4 with near infrared. Throws Error: `code` for a malformed text, kBadInput for a
/// number of bands that has no usual meaning.
BandLayout band_layout(GDALDataset& dataset, const std::string& path, const std::string& text, ExitCode code);

}  // namespace landfix::ingest
