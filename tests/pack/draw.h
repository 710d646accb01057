// Draws packs for tests: a layer's tiles as letters on a map, their pixels by a function. Written by the builder's own
// pack writer.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "builder/export/pack_writer.h"
#include "builder/export/vector_layers.h"
#include "tiles/codec.h"
#include "tiles/grid.h"

namespace landfix::tests {

/// A pixel of a drawing: global column and row of its level, and the letter of its tile.
struct PixelOf {
  char letter;
  int level;
  int64_t column, row;
  int channel;
};

/// The rows of `map` are rows of tiles from north to south, separated by new lines; a letter is a tile, '.' is a hole.
struct DrawnLevel {
  int level = 0;
  int32_t west_x = 0, south_y = 0;  ///< tile of the south-western letter
  std::string map;
};

struct DrawnLayer {
  std::string name = "gray";
  tiles::TileFormat format;
  std::vector<DrawnLevel> levels;            ///< finest first
  std::function<int(const PixelOf&)> pixel;  ///< bit layers: 0 or 1
  std::function<tiles::Codec(char letter)> codec = [](char) { return tiles::Codec::kRaw; };
  float value_offset = 0, value_step = 0;  ///< i16 layers
  std::string description;
  /// Indices into the description's epochs; empty: not stated.
  std::function<catalog::EpochSet(char letter)> epochs = [](char) { return catalog::EpochSet(); };
};

struct Drawing {
  std::vector<DrawnLayer> layers = {};
  std::optional<std::vector<tiles::Landmark>> landmarks = {};  ///< the layer `landmarks`, behind the others
  std::optional<tiles::RoadGraph> roads = {};                  ///< the layer `roads`, last
  exporter::EpochsOfTile vector_epochs = {};
  /// Zone 32 north, no sources, no geoid; bounds are those of the drawn tiles. `layers` is filled in from the drawing.
  exporter::PackDescription description = default_description();

  static exporter::PackDescription default_description();
};

/// The bytes of the pack.
std::vector<uint8_t> draw(const Drawing& drawing);

/// A folder for the files of one test, removed with it.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

std::vector<uint8_t> read_file(const std::filesystem::path& path);
void write_file(const std::filesystem::path& path, std::span<const uint8_t> bytes);

}  // namespace landfix::tests
