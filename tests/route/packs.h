// A pack with navigability layers, drawn node by node and written by the pack writer.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>

#include "builder/catalog/hash.h"
#include "builder/export/pack_writer.h"
#include "tests/route/fields.h"
#include "tiles/navigability.h"
#include "tools/common/open_pack.h"

namespace landfix::route {

/// Writes a pack of one tile of level 6, 16 km around at(0, 0), into a folder of its own. Flat ground at 400 m.
class NavigablePack : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// What is known at metres east and north of at(0, 0).
  using Draw = std::function<std::optional<tiles::Navigability>(double x_m, double y_m)>;

  void add(const tiles::Footprint& footprint, const Draw& draw) {
    const int level = tiles::navigability_level(footprint), side = 1 << (kTile.level - level);
    exporter::PackLayer layer{tiles::layer_of(footprint), "", kFormat, {{level, {}}}, {}};
    for (int32_t i = 0; i < side * side; ++i)
      layer.levels[0].tiles.push_back(tile({level, kTile.x * side + i % side, kTile.y * side + i / side}, draw));
    std::ranges::sort(layer.levels[0].tiles, {}, &schema::TileRecord::key);
    description_.layers.push_back(layer);
  }

  Pack written() {
    const double side_m = tiles::tile_side(kTile.level);
    description_.zone = kZone;
    description_.plane_height_m = 400;
    description_.geoid = ingest::GeoidGrid{"egm96", kTile.x * side_m, kTile.y * side_m, side_m, 2, 2, {50, 50, 50, 50}};
    description_.bounds = {kTile.x * side_m, kTile.y * side_m, (kTile.x + 1) * side_m, (kTile.y + 1) * side_m};
    exporter::write_pack(path_, description_, [this](const schema::TileRecord& tile, std::span<uint8_t> out) {
      std::ranges::copy(data_.at(tile.offset), out.begin());
    });
    return tools::open_pack(path_);
  }

  schema::TileRecord tile(const tiles::TileIndex& at, const Draw& draw) {
    const double spacing_m = tiles::gsd_of(at.level), west_m = at.x * tiles::tile_side(at.level),
                 north_m = (at.y + 1) * tiles::tile_side(at.level);
    std::vector<uint8_t> pixels(kFormat.bytes(), 0);
    for (size_t i = 0; i < pixels.size() / tiles::kNavigabilityChannels; ++i) {
      const double column = double(i % tiles::kTilePixels) + 0.5, row = double(i / tiles::kTilePixels) + 0.5;
      const auto what = draw(west_m + column * spacing_m - kEast, north_m - row * spacing_m - kNorth);
      if (!what) continue;
      const tiles::NavigabilityPixel pixel = tiles::encode_navigability(*what);
      std::copy(pixel.begin(), pixel.end(), pixels.begin() + long(i * pixel.size()));
    }
    schema::TileRecord record{};
    record.key = tiles::hilbert_key(at);
    record.offset = data_.size();
    record.codec = uint8_t(tiles::Codec::kZstd);
    data_[record.offset] = tiles::encode(tiles::Codec::kZstd, kFormat, pixels, {});
    record.length = uint32_t(data_[record.offset].size());
    record.hash = catalog::hash_of(data_[record.offset]);
    return record;
  }

  static constexpr tiles::TileIndex kTile{6, 30, 317};
  static constexpr tiles::TileFormat kFormat{tiles::PixelType::kU8, uint8_t(tiles::kNavigabilityChannels), 0};
  const std::string folder_ = testing::TempDir() + "route_" + std::to_string(::getpid());
  const std::string path_ = folder_ + "/map.lfpack";
  exporter::PackDescription description_;
  std::map<uint64_t, std::vector<uint8_t>> data_;
};

inline tiles::Navigability place(double fix) {
  tiles::Navigability n{};
  n.fix_probability.fill(fix);
  n.fix_probability[size_t(tiles::Finder::kGray)] = 0.01;
  n.false_probability = 0.02;
  n.major_m = 4;
  n.minor_m = 2;
  return n;
}

}  // namespace landfix::route
