// Writes a pack: the last step of every build. schemas/FORMAT.md is the specification.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "builder/catalog/catalog.h"
#include "builder/ingest/bounds.h"
#include "builder/ingest/geoid.h"
#include "builder/ingest/source.h"
#include "schemas/pack_layout.h"
#include "tiles/codec.h"
#include "tiles/geodesy.h"

namespace landfix::exporter {

struct PackLevel {
  int level = 0;
  std::vector<schema::TileRecord> tiles;  ///< strictly ascending keys; `offset` is for ReadTile alone
};

/// Values as in the file.
enum class VectorContent : uint8_t { kNone = 0, kLandmarks = 1, kRoads = 2 };

struct PackLayer {
  std::string name;
  std::string description;
  tiles::TileFormat format;       ///< of raster layers
  std::vector<PackLevel> levels;  ///< finest first; raster levels without tiles are left out of the pack
  /// Other than kNone: a vector layer, with the one level kVectorLevel (builder/export/vector_layers.h makes them).
  VectorContent content = VectorContent::kNone;
};

enum class SourceRole : uint8_t { kImage = 0, kElevation = 1, kVector = 2 };

struct PackSource {
  SourceRole role = SourceRole::kImage;
  ingest::Source source;
};

/// A capture date and the images that show it.
struct PackEpoch {
  std::string date;               ///< ISO 8601; empty: undated
  std::vector<uint16_t> sources;  ///< indices into PackDescription::sources, ascending
};

/// All of a pack but the tile data. Equal descriptions and data give equal files.
struct PackDescription {
  tiles::Zone zone;
  ingest::GridBounds bounds;
  std::vector<PackLayer> layers;
  std::vector<PackSource> sources;
  std::vector<PackEpoch> epochs;  ///< newest first (equal dates may follow each other), undated last
  /// Indices into `epochs`, strictly ascending; `epoch_set` of the tiles' records counts from 1 in it. In any order:
  /// the pack holds those in use, each once, in the order in which its tiles need them.
  std::vector<catalog::EpochSet> epoch_sets;
  std::optional<ingest::GeoidGrid> geoid;
  double plane_height_m = 0;  ///< above the ellipsoid
  std::optional<double> georegistration_error_m;
  std::string builder;
  std::vector<std::pair<std::string, std::string>> parameters;  ///< name, value
};

/// Fills `out` (of `tile.length` bytes) with the data of a tile of the description.
using ReadTile = std::function<void(const schema::TileRecord& tile, std::span<uint8_t> out)>;

struct PackStatistics {
  uint64_t file_bytes = 0;
  uint64_t tiles = 0;         ///< records
  uint64_t stored_tiles = 0;  ///< different data
};

/// Writes `path` as a whole or not at all: to `path`.part in the same folder, flushed, then renamed (over a file that
/// is there). `advance` is told of the bytes of tile data as they are written. Throws Error: kIo where the disk is full
/// or writing fails (says how much is needed; the .part is removed), kInternal for a description that no pack can hold.
/// What `read` throws passes through, as for `advance`.
PackStatistics write_pack(const std::filesystem::path& path, const PackDescription& description, const ReadTile& read,
                          const std::function<void(uint64_t bytes)>& advance = {});

/// Fills in `root` and then `header_hash` from the fields before them.
void seal(schema::Header& header);

/// The manifest's bytes, with these sets of epochs instead of the description's. `first_block` of the levels counts on
/// from 0 in the order of the description, without empty levels.
std::vector<uint8_t> encode_manifest(const PackDescription& description, std::span<const catalog::EpochSet> epoch_sets);

/// How many directory blocks hold `tiles` records.
inline uint64_t blocks_for(uint64_t tiles) { return (tiles + schema::kBlockTiles - 1) / schema::kBlockTiles; }

}  // namespace landfix::exporter
