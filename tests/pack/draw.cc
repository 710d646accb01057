#include "tests/pack/draw.h"

#include <sodium.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>

namespace landfix::tests {
namespace {

namespace fs = std::filesystem;
using schema::TileRecord;
using tiles::TileIndex;
using Bytes = std::vector<uint8_t>;

// Where schemas/FORMAT.md section 3.4 says that a pixel lies.
void draw_pixel(const tiles::TileFormat& f, size_t row, size_t column, size_t channel, int value, Bytes& out) {
  const size_t pixel = (row * tiles::kTilePixels + column) * f.channels + channel;
  const auto i16 = int16_t(value);
  switch (f.type) {
    case tiles::PixelType::kU8:
      out[pixel] = uint8_t(value);
      break;
    case tiles::PixelType::kI16:
      std::memcpy(&out[2 * pixel], &i16, 2);
      break;
    case tiles::PixelType::kBit:
      out[8192 * channel + 32 * row + column / 8] |= uint8_t(value << column % 8);
      break;
  }
}

Bytes draw_pixels(const DrawnLayer& layer, const TileIndex& tile, char letter) {
  Bytes pixels(layer.format.bytes());
  for (int row = 0; row < tiles::kTilePixels; ++row)
    for (int column = 0; column < tiles::kTilePixels; ++column)
      for (int channel = 0; channel < layer.format.channels; ++channel) {
        const int value = layer.pixel(
            {letter, tile.level, tiles::first_column(tile) + column, tiles::first_row(tile) + row, channel});
        draw_pixel(layer.format, size_t(row), size_t(column), size_t(channel), value, pixels);
      }
  return pixels;
}

// The number of a set of epochs in the description, which gains it where it lacks it.
uint16_t number_of(const catalog::EpochSet& set, std::vector<catalog::EpochSet>& sets) {
  if (set.empty()) return 0;
  const auto place = std::find(sets.begin(), sets.end(), set);
  const auto number = uint16_t(place - sets.begin() + 1);
  if (place == sets.end()) sets.push_back(set);
  return number;
}

// Tiles in Hilbert order; the record's offset is the index of its data in `stored`.
exporter::PackLevel draw_level(const DrawnLayer& layer, const DrawnLevel& drawn, ingest::GridBounds& bounds,
                               std::vector<Bytes>& stored, std::vector<catalog::EpochSet>& epoch_sets) {
  std::map<uint64_t, TileRecord> records;
  const auto rows = int32_t(std::count(drawn.map.begin(), drawn.map.end(), '\n'));
  TileIndex tile{drawn.level, drawn.west_x, drawn.south_y + rows};
  for (const char letter : drawn.map) {
    if (letter == '\n') {
      tile.x = drawn.west_x;
      --tile.y;
      continue;
    }
    if (letter != '.') {
      const tiles::Codec codec = layer.codec(letter);
      Bytes data = tiles::encode(codec, layer.format, draw_pixels(layer, tile, letter));
      if (data.empty()) throw std::logic_error("a drawn tile that its codec does not serve");
      TileRecord& record = records[tiles::hilbert_key(tile)];
      record.key = tiles::hilbert_key(tile);
      record.offset = stored.size();
      record.length = uint32_t(data.size());
      record.codec = uint8_t(codec);
      record.epoch_set = number_of(layer.epochs(letter), epoch_sets);
      record.value_offset = layer.value_offset;
      record.value_step = layer.value_step;
      crypto_generichash(record.hash.bytes, sizeof record.hash.bytes, data.data(), data.size(), nullptr, 0);
      stored.push_back(std::move(data));
      bounds.extend(ingest::bounds_of(tile));
    }
    ++tile.x;
  }
  exporter::PackLevel level{drawn.level, {}};
  for (const auto& [key, record] : records) level.tiles.push_back(record);
  return level;
}

ingest::GridBounds around(double east_m, double north_m) { return {east_m - 1, north_m - 1, east_m + 1, north_m + 1}; }

void add_vectors(exporter::PackLayer layer, std::vector<catalog::FinishedTile> tiles, std::vector<Bytes>& stored,
                 exporter::PackDescription& d) {
  for (catalog::FinishedTile& tile : tiles) {
    tile.record.offset = stored.size();
    tile.record.epoch_set = number_of(tile.epochs, d.epoch_sets);
    layer.levels[0].tiles.push_back(tile.record);
    stored.push_back(std::move(tile.data));
  }
  d.layers.push_back(std::move(layer));
}

}  // namespace

exporter::PackDescription Drawing::default_description() {
  exporter::PackDescription d;
  d.zone = {32, true};
  d.builder = "a drawing";
  return d;
}

std::vector<uint8_t> draw(const Drawing& drawing) {
  exporter::PackDescription d = drawing.description;
  std::vector<Bytes> stored;
  ingest::GridBounds bounds;
  for (const DrawnLayer& layer : drawing.layers) {
    exporter::PackLayer out{layer.name, layer.description, layer.format, {}};
    for (const DrawnLevel& level : layer.levels)
      out.levels.push_back(draw_level(layer, level, bounds, stored, d.epoch_sets));
    d.layers.push_back(std::move(out));
  }
  if (drawing.landmarks) {
    for (const tiles::Landmark& m : *drawing.landmarks) bounds.extend(around(m.east_m, m.north_m));
    add_vectors(exporter::landmarks_layer(), exporter::landmark_tiles(*drawing.landmarks, drawing.vector_epochs),
                stored, d);
  }
  if (drawing.roads) {
    for (const tiles::RoadNode& n : drawing.roads->nodes) bounds.extend(around(n.east_m, n.north_m));
    add_vectors(exporter::roads_layer(), exporter::road_tiles(*drawing.roads, drawing.vector_epochs), stored, d);
  }
  if (d.bounds.empty()) d.bounds = bounds;
  const TemporaryFolder folder;
  const std::string path = folder.file("drawn.lfpack");
  exporter::write_pack(path, d, [&](const TileRecord& tile, std::span<uint8_t> out) {
    std::copy(stored[tile.offset].begin(), stored[tile.offset].end(), out.begin());
  });
  return read_file(path);
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (fs::temp_directory_path() / "landfix-test-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder: " + name);
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::vector<uint8_t> read_file(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error("cannot read " + path.string());
  return {std::istreambuf_iterator<char>(in), {}};
}

void write_file(const fs::path& path, std::span<const uint8_t> bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
  if (!out.flush()) throw std::runtime_error("cannot write " + path.string());
}

}  // namespace landfix::tests
