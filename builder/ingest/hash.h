// SHA-256 of input files, for provenance and for finding out what changed.
#pragma once

#include <string>

namespace landfix::ingest {

/// Hex digest of what a raster consists of. One file: its SHA-256, as sha256sum prints it. Several (a VRT and what it
/// reads, a mask or world file beside the image; overviews are left out): SHA-256 of the concatenated digests in GDAL's
/// order. Throws Error (kIo).
std::string raster_sha256(const std::string& path);

/// The same of a vector file: a Shapefile, say, consists of several files.
std::string vector_sha256(const std::string& path);

}  // namespace landfix::ingest
