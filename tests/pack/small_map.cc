#include "tests/pack/small_map.h"

#include <cctype>

namespace landfix::tests {

int pattern(const PixelOf& p) {
  if (std::isupper(p.letter) && (p.column & 255) >= 128) return 0;
  return 1 + int((p.letter * 53 + (p.column & 255) * 7 + (p.row & 255) * 13 + p.channel * 29) % 255);
}

DrawnLayer small_gray(tiles::Codec codec) {
  DrawnLayer layer;
  layer.levels = {{0, kWestX, kSouthY, "abc\nd.E"}, {1, kWestX >> 1, kSouthY >> 1, "pq\nrs"}};
  layer.pixel = pattern;
  layer.codec = [codec](char) { return codec; };
  return layer;
}

int bit_pattern(const PixelOf& p) {
  if (std::isupper(p.letter) && (p.column & 255) >= 128) return 1;
  // A product of odd numbers mixes the low bits upwards; the channel picks one of those above.
  const auto mixed = uint32_t((p.letter * 259 + (p.column & 255)) * 2654435761u ^ (p.row & 255) * 2246822519u);
  const int a = int((mixed * 3266489917u >> 29) % 3) - 1, b = int((mixed * 668265263u >> 28) % 3) - 1;
  return p.channel == 0 ? a > 0 : p.channel == 1 ? a < 0 : p.channel == 2 ? b > 0 : b < 0;
}

DrawnLayer small_bits(tiles::Codec codec) {
  DrawnLayer layer = small_gray(codec);
  layer.name = "orientation";
  layer.format = {tiles::PixelType::kBit, 4, 1};
  layer.pixel = bit_pattern;
  return layer;
}

std::vector<uint8_t> small_pack(tiles::Codec codec) {
  Drawing drawing{.layers = {small_gray(codec)}};
  drawing.description.bounds = {kWestM, kSouthM, kEastM, kNorthM};
  return draw(drawing);
}

char small_letter(int64_t column, int64_t row) {
  const tiles::TileIndex t = tiles::tile_of_pixel(0, column, row);
  const int x = t.x - kWestX, y = kSouthY + 1 - t.y;
  return x < 0 || x > 2 || y < 0 || y > 1 ? '.' : "abcd.E"[3 * y + x];
}

Read read(const Pack& pack, const Region& region, size_t channels) {
  const size_t row_bytes = region.width * channels;
  Read r{LF_OK, std::vector<uint8_t>(row_bytes * region.height)};
  r.status = pack.read(region, r.pixels, row_bytes);
  return r;
}

}  // namespace landfix::tests
