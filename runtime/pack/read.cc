// Regions: from a filter's uncertainty to pixels in the caller's buffer.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>

#include "runtime/pack/pack.h"
#include "runtime/pack/queries.h"

using landfix::pack::Layer;
using landfix::pack::Level;
using landfix::schema::TileRecord;
using landfix::tiles::kTilePixels;
using landfix::tiles::PixelRect;
using landfix::tiles::TileIndex;
using landfix::tiles::TileRange;

lf_status lf_pack::resolve(const lf_region& r, const Layer*& layer, const Level*& level) const {
  if (r.layer >= layer_count) return LF_INVALID_ARGUMENT;
  layer = &layers[r.layer];
  level = layer->find_level(r.level);
  if (level == nullptr || r.width == 0 || r.height == 0) return LF_INVALID_ARGUMENT;
  if (uint64_t(r.width) * r.height > LF_MAX_REGION_PIXELS) return LF_REGION_TOO_LARGE;
  const int64_t half = int64_t(1) << (landfix::tiles::kDomainLog2 - 1 - r.level);
  if (r.first_column < -half || r.first_column > half - int64_t(r.width)) return LF_INVALID_ARGUMENT;
  if (r.first_row < -half || r.first_row > half - int64_t(r.height)) return LF_INVALID_ARGUMENT;
  return LF_OK;
}

namespace landfix::pack {
namespace {

const Level& choose_level(const Layer& layer, double gsd_m) {
  uint32_t best = 0;
  for (uint32_t i = 1; i < layer.level_count; ++i)
    if (tiles::gsd_of(layer.levels[i].level) <= gsd_m * (1 + 1e-9)) best = i;
  return layer.levels[best];
}

lf_status make_region(const lf_pack& pack, uint32_t layer, const PixelRect& rect, lf_region& out) {
  if (uint64_t(rect.width) > LF_MAX_REGION_PIXELS || uint64_t(rect.height) > LF_MAX_REGION_PIXELS ||
      uint64_t(rect.width) * uint64_t(rect.height) > LF_MAX_REGION_PIXELS)
    return LF_REGION_TOO_LARGE;
  const double gsd = tiles::gsd_of(rect.level);
  const schema::Bounds& b = *pack.manifest->bounds();
  const double west = rect.west_m(), north = rect.north_m();
  if (west >= b.east_m() || west + double(rect.width) * gsd <= b.west_m() || north <= b.south_m() ||
      north - double(rect.height) * gsd >= b.north_m())
    return LF_OUTSIDE_MAP;
  out = {layer, rect.level, rect.column, rect.row, uint32_t(rect.width), uint32_t(rect.height), west, north, gsd};
  return LF_OK;
}

// The part of a tile that a region covers: rows and columns in the tile and in the region.
struct Overlap {
  int64_t tile_column, tile_row, region_column, region_row, width, height;
};

Overlap overlap_of(const lf_region& r, const TileIndex& t) {
  const int64_t column = tiles::first_column(t), row = tiles::first_row(t);
  const int64_t x0 = std::max(column, r.first_column),
                x1 = std::min(column + kTilePixels, r.first_column + int64_t(r.width));
  const int64_t y0 = std::max(row, r.first_row), y1 = std::min(row + kTilePixels, r.first_row + int64_t(r.height));
  return {x0 - column, y0 - row, x0 - r.first_column, y0 - r.first_row, x1 - x0, y1 - y0};
}

// What a region takes from one tile; no pixels where there is no tile.
struct Piece {
  Overlap overlap;
  const uint8_t* pixels;
  const TileRecord* record;
};

// Calls visit(pieces) for the tiles of the region, up to kStripTiles side by side at a time.
template <typename Visit>
lf_status for_each_strip(const lf_pack& pack, const Layer& layer, const Level& level, const lf_region& region,
                         Visit visit) {
  constexpr int32_t kStripTiles = 8;
  const TileRange range = tiles::tiles_of(rect_of(region));
  for (int32_t y = range.y_max; y >= range.y_min; --y)
    for (int32_t x = range.x_min; x <= range.x_max; x += kStripTiles) {
      Piece strip[kStripTiles];
      const int32_t count = std::min(kStripTiles, range.x_max - x + 1);
      for (int32_t i = 0; i < count; ++i) {
        const TileIndex tile{level.level, x + i, y};
        strip[i] = {overlap_of(region, tile), nullptr, nullptr};
        const lf_status s = pack.pixels_of(layer, level, tile, strip[i].pixels, strip[i].record);
        if (s != LF_OK && s != LF_OUTSIDE_MAP) return s;
      }
      visit(std::span<const Piece>(strip, size_t(count)));
    }
  return LF_OK;
}

// Row by row over all tiles of a strip, later rows on their way from memory while this one is copied: a third faster
// than tile by tile, where the processor has but one short run of bytes to look ahead in.
void copy_strip(std::span<const Piece> strip, const tiles::TileFormat& format, uint8_t* out, size_t row_bytes) {
  constexpr int64_t kRowsAhead = 12;
  constexpr size_t kCacheLine = 64;
  const size_t pixel = format.channels, tile_line = kTilePixels * pixel;
  const int64_t height = strip[0].overlap.height;
  for (int64_t y = 0; y < height; ++y)
    for (const Piece& piece : strip) {
      const Overlap& o = piece.overlap;
      const size_t line = size_t(o.width) * pixel;
      uint8_t* to = out + size_t(o.region_row + y) * row_bytes + size_t(o.region_column) * pixel;
      if (piece.pixels == nullptr) {
        std::memset(to, format.nodata, line);
        continue;
      }
      const uint8_t* from = piece.pixels + size_t(o.tile_row + y) * tile_line + size_t(o.tile_column) * pixel;
      if (y + kRowsAhead < height)
        for (size_t i = 0; i < line; i += kCacheLine) __builtin_prefetch(from + kRowsAhead * tile_line + i);
      std::memcpy(to, from, line);
    }
}

void copy_values(const Piece& piece, int16_t nodata, float* out, size_t row_values) {
  const Overlap& o = piece.overlap;
  for (int64_t y = 0; y < o.height; ++y) {
    float* to = out + size_t(o.region_row + y) * row_values + o.region_column;
    if (piece.pixels == nullptr) {
      std::fill_n(to, o.width, std::numeric_limits<float>::quiet_NaN());
      continue;
    }
    const auto* from = reinterpret_cast<const int16_t*>(piece.pixels) + (o.tile_row + y) * kTilePixels + o.tile_column;
    for (int64_t x = 0; x < o.width; ++x)
      to[x] = from[x] == nodata ? std::numeric_limits<float>::quiet_NaN()
                                : piece.record->value_offset + piece.record->value_step * from[x];
  }
}

constexpr int64_t kWordBits = 64, kTileWords = kTilePixels / kWordBits;

constexpr size_t words_for(int64_t bits) { return size_t((bits + kWordBits - 1) / kWordBits); }

// Bits [begin, end) of word `index` of a row.
uint64_t mask_of(int64_t index, int64_t begin, int64_t end) {
  const int64_t from = std::clamp<int64_t>(begin - index * kWordBits, 0, kWordBits),
                to = std::clamp<int64_t>(end - index * kWordBits, 0, kWordBits);
  return from == to ? 0 : ~uint64_t(0) >> (kWordBits - (to - from)) << from;
}

// Adds what a region takes from one tile, plane by plane, to rows that are 0 there. Seen from the region, the words of
// a row of the tile begin at bit `origin`, which may lie before the region.
void add_planes(const Piece& piece, const tiles::TileFormat& format, uint64_t* out, size_t row_words,
                size_t plane_words, int64_t words) {
  if (piece.pixels == nullptr && format.nodata == 0) return;
  const Overlap& o = piece.overlap;
  const int64_t origin = o.region_column - o.tile_column;
  const int64_t shift = origin & (kWordBits - 1), first_word = (origin - shift) / kWordBits;
  const int64_t begin = std::max<int64_t>(0, -first_word), end = std::min(kTileWords + 1, words - first_word);
  uint64_t masks[kTileWords];
  for (int64_t k = 0; k < kTileWords; ++k) masks[k] = mask_of(k, o.tile_column, o.tile_column + o.width);
  for (size_t p = 0; p < format.channels; ++p)
    for (int64_t y = 0; y < o.height; ++y) {
      // Between words of 0, so that each word of the region is made of two of the tile.
      uint64_t row[kTileWords + 2] = {};
      if (piece.pixels != nullptr)
        std::memcpy(row + 1, piece.pixels + p * tiles::kPlaneBytes + size_t(o.tile_row + y) * tiles::kPlaneRowBytes,
                    tiles::kPlaneRowBytes);
      else
        std::fill_n(row + 1, kTileWords, ~uint64_t(0));
      for (int64_t k = 0; k < kTileWords; ++k) row[k + 1] &= masks[k];
      uint64_t* to = out + p * plane_words + size_t(o.region_row + y) * row_words;
      for (int64_t k = begin; k < end; ++k)
        to[first_word + k] |= row[k + 1] << shift | row[k] >> 1 >> (kWordBits - 1 - shift);
    }
}

lf_status check_planes(const lf_region& r, size_t planes, size_t row_words, size_t plane_words, size_t out_words) {
  const size_t line = words_for(r.width);
  if (row_words < line || out_words < line || (r.height - 1) > (out_words - line) / row_words)
    return LF_BUFFER_TOO_SMALL;
  const size_t plane = (r.height - 1) * row_words + line;
  if (planes == 1) return LF_OK;
  return plane_words >= plane && planes - 1 <= (out_words - plane) / plane_words ? LF_OK : LF_BUFFER_TOO_SMALL;
}

lf_status check_buffer(const lf_region& r, size_t pixel_bytes, size_t row_bytes, size_t out_bytes) {
  const size_t line = r.width * pixel_bytes;
  if (row_bytes < line) return LF_BUFFER_TOO_SMALL;
  return out_bytes >= line && (r.height - 1) <= (out_bytes - line) / row_bytes ? LF_OK : LF_BUFFER_TOO_SMALL;
}

}  // namespace

lf_status ellipse_region(const lf_pack& pack, uint32_t layer, const tiles::Ellipse& ellipse, double gsd_m,
                         lf_region& out) {
  if (layer >= pack.layer_count || !(gsd_m > 0)) return LF_INVALID_ARGUMENT;
  const auto rect = tiles::bounding_pixels(ellipse, choose_level(pack.layers[layer], gsd_m).level);
  return rect ? make_region(pack, layer, *rect, out) : LF_INVALID_ARGUMENT;
}

lf_status box_region(const lf_pack& pack, uint32_t layer, const Box& box, double gsd_m, lf_region& out) {
  if (layer >= pack.layer_count || !(gsd_m > 0)) return LF_INVALID_ARGUMENT;
  for (const double v : {box.west_m, box.south_m, box.east_m, box.north_m})
    if (!(std::abs(v) < tiles::kDomainHalf)) return LF_INVALID_ARGUMENT;
  if (box.east_m < box.west_m || box.north_m < box.south_m) return LF_INVALID_ARGUMENT;
  const int level = choose_level(pack.layers[layer], gsd_m).level;
  const double gsd = tiles::gsd_of(level);
  // Half-open: a box that ends on a pixel's edge does not touch the next pixel, but there is always one pixel.
  const auto west = int64_t(std::floor(box.west_m / gsd)), top = int64_t(std::floor(-box.north_m / gsd));
  const auto east = std::max(west + 1, int64_t(std::ceil(box.east_m / gsd)));
  const auto bottom = std::max(top + 1, int64_t(std::ceil(-box.south_m / gsd)));
  return make_region(pack, layer, {level, west, top, east - west, bottom - top}, out);
}

lf_status read_pixels(const lf_pack& pack, const lf_region& region, uint8_t* out, size_t row_bytes, size_t out_bytes) {
  const Layer* layer;
  const Level* level;
  if (const lf_status s = pack.resolve(region, layer, level); s != LF_OK) return s;
  if (layer->type != LF_U8) return LF_WRONG_TYPE;
  const size_t pixel = layer->format.channels;
  if (const lf_status s = check_buffer(region, pixel, row_bytes, out_bytes); s != LF_OK) return s;
  return for_each_strip(pack, *layer, *level, region,
                        [&](std::span<const Piece> strip) { copy_strip(strip, layer->format, out, row_bytes); });
}

lf_status read_values(const lf_pack& pack, const lf_region& region, float* out, size_t row_bytes, size_t out_bytes) {
  const Layer* layer;
  const Level* level;
  if (const lf_status s = pack.resolve(region, layer, level); s != LF_OK) return s;
  if (layer->type != LF_I16) return LF_WRONG_TYPE;
  if (row_bytes % sizeof(float) != 0) return LF_INVALID_ARGUMENT;
  if (const lf_status s = check_buffer(region, sizeof(float), row_bytes, out_bytes); s != LF_OK) return s;
  return for_each_strip(pack, *layer, *level, region, [&](std::span<const Piece> strip) {
    for (const Piece& piece : strip) copy_values(piece, layer->format.nodata, out, row_bytes / sizeof(float));
  });
}

lf_status read_bits(const lf_pack& pack, const lf_region& region, uint64_t* out, size_t row_words, size_t plane_words,
                    size_t out_words) {
  const Layer* layer;
  const Level* level;
  if (const lf_status s = pack.resolve(region, layer, level); s != LF_OK) return s;
  if (layer->type != LF_BIT) return LF_WRONG_TYPE;
  const size_t planes = layer->format.channels, words = words_for(region.width);
  if (const lf_status s = check_planes(region, planes, row_words, plane_words, out_words); s != LF_OK) return s;
  for (size_t p = 0; p < planes; ++p)
    for (size_t y = 0; y < region.height; ++y) std::fill_n(out + p * plane_words + y * row_words, words, uint64_t(0));
  return for_each_strip(pack, *layer, *level, region, [&](std::span<const Piece> strip) {
    for (const Piece& piece : strip) add_planes(piece, layer->format, out, row_words, plane_words, int64_t(words));
  });
}

lf_status tile_view(const lf_pack& pack, uint32_t layer_index, const TileIndex& index, lf_tile& out) {
  if (layer_index >= pack.layer_count) return LF_INVALID_ARGUMENT;
  const Layer& layer = pack.layers[layer_index];
  const Level* level = layer.find_level(index.level);
  if (level == nullptr) return LF_INVALID_ARGUMENT;
  if (layer.is_vector()) return LF_WRONG_TYPE;
  const uint8_t* pixels;
  const TileRecord* record;
  if (const lf_status s = pack.pixels_of(layer, *level, index, pixels, record); s != LF_OK) return s;
  const double gsd = tiles::gsd_of(index.level);
  out = {index.level,
         index.x,
         index.y,
         uint32_t(layer.format.row_bytes()),
         double(tiles::first_column(index)) * gsd,
         -double(tiles::first_row(index)) * gsd,
         gsd,
         record->value_offset,
         record->value_step,
         pixels};
  return LF_OK;
}

lf_status next_tile(const lf_pack& pack, const lf_region& region, const tiles::Ellipse* ellipse, uint64_t& cursor,
                    lf_tile& out) {
  const Layer* layer;
  const Level* level;
  if (const lf_status s = pack.resolve(region, layer, level); s != LF_OK) return s;
  if (ellipse != nullptr && !tiles::is_valid(*ellipse)) return LF_INVALID_ARGUMENT;
  const TileRange range = tiles::tiles_of(rect_of(region));
  const auto columns = uint64_t(range.x_max - range.x_min + 1), rows = uint64_t(range.y_max - range.y_min + 1);
  while (cursor < columns * rows) {
    const TileIndex tile{region.level, range.x_min + int32_t(cursor % columns),
                         range.y_max - int32_t(cursor / columns)};
    ++cursor;
    if (ellipse != nullptr && !tiles::touches(*ellipse, tile)) continue;
    const lf_status s = tile_view(pack, region.layer, tile, out);
    if (s != LF_OUTSIDE_MAP) return s;
  }
  return LF_END;
}

lf_status prepare(const lf_pack& pack, const lf_region& region, bool copy) {
  const Layer* layer;
  const Level* level;
  if (const lf_status s = pack.resolve(region, layer, level); s != LF_OK) return s;
  const TileRange range = tiles::tiles_of(rect_of(region));
  for (int32_t y = range.y_max; y >= range.y_min; --y)
    for (int32_t x = range.x_min; x <= range.x_max; ++x)
      if (const lf_status s = pack.prepare_tile(*layer, *level, {level->level, x, y}, copy); s != LF_OK) return s;
  return LF_OK;
}

}  // namespace landfix::pack
