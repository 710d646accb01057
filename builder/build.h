// The pipeline of `landfix build`: images and heights in, a pack out.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "builder/ingest/alignment.h"
#include "builder/ingest/source.h"
#include "builder/landmarks/known.h"
#include "builder/progress.h"
#include "tiles/codec.h"
#include "tiles/geodesy.h"
#include "tiles/navigability.h"

namespace landfix {

struct BuildOptions {
  std::vector<ingest::SourceOptions> images;
  std::optional<ingest::SourceOptions> elevation;
  std::string landmark_model, road_model;  ///< files of `landfix train-objects`, `train-roads`; empty: landfix's own
  std::vector<landmarks::VectorInput> vectors;  ///< known landmarks and roads; of what several know the first is taken
  std::string
      area_file;     ///< polygons of a vector file; at most one of area_file and bbox. Neither: what the images cover
  std::string bbox;  ///< "W,S,E,N" in degrees
  std::optional<tiles::Zone> zone;             ///< absent: the standard zone of the images' centre
  std::optional<double> gsd_m;                 ///< a power of two; absent: the one nearest to the finest image's
  std::vector<tiles::Footprint> footprints;    ///< that navigability is judged for, a layer each; of imagery up to 16 m
  std::string set;                             ///< of layers (see layer_set.h); empty: "all"
  std::vector<std::string> layers;             ///< names from the registry, "landmarks" and "roads", instead of a set
  std::map<std::string, tiles::Codec> codecs;  ///< by layer, instead of the set's or the layer's own
  std::optional<int> jpeg_quality;             ///< instead of the set's
  bool align = false;                          ///< remove the shifts between images that are measured
  double plane_height_m = 0;                   ///< metres above the ellipsoid, assumed where no height tile lies
  std::optional<double>
      georegistration_error_m;  ///< one sigma per axis; absent: the largest of the images', if all state one
  std::filesystem::path output;
  bool force = false;  ///< replace a file that is there
  int threads = 0;     ///< 0: one per core
  const std::atomic<bool>* stop =
      nullptr;  ///< becomes true: finish the jobs under way, keep the journal, throw Interrupted
  std::function<void(size_t jobs)> after_job;  ///< for tests: called with the number of jobs that this run has finished
};

/// Asked to stop. The journal is kept: the same build continues.
struct Interrupted : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// "raw", "jpeg", "zstd" or "context", as on the command line and in the manifest's parameters.
const char* name_of(tiles::Codec codec);

struct LevelSummary {
  int level = 0;
  uint64_t tiles = 0;
  uint64_t bytes = 0;  ///< of tile data, before equal tiles are stored once
};

struct LayerSummary {
  std::string name;
  tiles::Codec codec = tiles::Codec::kRaw;
  std::vector<LevelSummary> levels;  ///< finest first
};

/// How far an image lies off the one that it was compared with.
struct ShiftSummary {
  std::string image;  ///< name of its file; "#2" and so on where images in other folders have the same one
  ingest::Alignment alignment;
  std::string text;
  bool removed = false;
};

struct BuildSummary {
  std::vector<LayerSummary> layers;
  std::vector<std::string> features;  ///< what vector layers hold: "landmarks: 123 buildings", "roads: 4.5 km, ..."
  tiles::Zone zone;
  double gsd_m = 0;
  double area_km2 = 0;  ///< of the bounds, or of the tiles where that is less
  uint64_t file_bytes = 0;
  uint64_t tiles = 0;
  uint64_t stored_tiles = 0;  ///< different data
  size_t resumed_jobs = 0;    ///< taken over from an earlier run
  double megapixels = 0;      ///< at the base level, of this run
  double seconds = 0;
  std::vector<std::string> warnings;
  std::vector<ShiftSummary> shifts;  ///< of images that overlap others
};

/// Builds `options.output`, whole or not at all. While it runs, and after it failed or was killed, the folder
/// `output`.build holds its journal; the same build continues from it, another one starts over. The bytes of the pack
/// depend on the inputs' names and contents and on the options that matter, not on threads, folders, time or
/// interruptions. Memory is bounded by the tiles in flight. Throws Error: kUsage, kBadInput and kIo with what to do
/// about it; Interrupted.
BuildSummary build(const BuildOptions& options, Progress& progress);

}  // namespace landfix
