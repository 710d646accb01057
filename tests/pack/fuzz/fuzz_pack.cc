// Fuzz target: whatever the bytes are, opening and every query answer with a status and touch no memory that is not
// theirs.
//
// The first byte of the input decides how the rest is read:
//   even: as a pack, as it is: nearly all of it ends at the first hash, which is the point.
//   odd:  as the header's 264 bytes of fields and what follows the header page. Magic, version, length and all hashes
//   are made right, so that
//         the fuzzer reaches what lies behind them.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "landfix/landfix.h"
#include "tests/pack/patch.h"

namespace {

using landfix::tests::Patch;
using Bytes = std::vector<uint8_t>;

constexpr size_t kHeaderFields = offsetof(landfix::schema::Header, reserved);
constexpr uint64_t kMostHashedBytes = 4 << 20;  // overlapping extents could ask for the hashing of gigabytes
constexpr uint32_t kMostPixels = 1 << 20;

void require(bool holds) {
  if (!holds) std::abort();
}

// How many bytes hashing every tile of every block would take.
uint64_t hashed_bytes(Patch& pack) {
  uint64_t sum = 0;
  for (const auto& block : pack.blocks())
    for (const auto& tile : pack.tiles(block)) sum += sizeof tile + pack.data(tile).size();
  return sum;
}

bool unfold(const uint8_t* data, size_t size, Bytes& out) {
  if (size <= 1 + kHeaderFields) return false;
  Bytes bytes(landfix::schema::kPageSize);
  std::copy_n(data + 1, kHeaderFields, bytes.begin());
  bytes.insert(bytes.end(), data + 1 + kHeaderFields, data + size);
  Patch pack(std::move(bytes));
  std::memcpy(pack.header().magic, landfix::schema::kMagic, sizeof landfix::schema::kMagic);
  pack.header().version_major = landfix::schema::kVersionMajor;
  pack.header().page_size = landfix::schema::kPageSize;
  pack.header().file_length = pack.bytes().size();
  if (pack.blocks().size() > 64 || hashed_bytes(pack) > kMostHashedBytes) return false;
  out = rehashed(std::move(pack));
  return true;
}

void touch(const void* data, size_t size) {
  unsigned sum = 0;
  for (size_t i = 0; i < size; i += 61) sum += static_cast<const uint8_t*>(data)[i];
  [[maybe_unused]] static volatile unsigned sink;
  sink = sum;
}

void touch(const char* text) { touch(text, std::strlen(text)); }

void ask_for_the_manifest(const lf_pack* pack, const lf_info& info) {
  touch(info.builder);
  for (uint32_t i = 0; i < std::min(info.source_count, 16u); ++i) {
    lf_source_info s;
    require(lf_get_source(pack, i, &s) == LF_OK);
    for (const char* text : {s.name, s.capture_date, s.licence, s.attribution, s.crs, s.vertical_datum}) touch(text);
  }
  for (uint32_t i = 0; i < std::min(info.epoch_count, 16u); ++i) {
    lf_epoch_info e;
    require(lf_get_epoch(pack, i, &e) == LF_OK);
    touch(e.date);
    for (uint32_t k = 0; k < e.source_count; ++k) require(e.sources[k] < info.source_count);
  }
  for (uint32_t i = 0; i < std::min(info.parameter_count, 16u); ++i) {
    const char *name, *value;
    require(lf_get_parameter(pack, i, &name, &value) == LF_OK);
    touch(name), touch(value);
  }
}

size_t bytes_of_tile(const lf_layer_info& layer, const lf_tile& tile) {
  return size_t(tile.row_bytes) * 256 * (layer.pixel_type == LF_BIT ? layer.channels : 1);
}

// Reads a region by the call for its pixel type, into a buffer of exactly the size that it needs.
lf_status read_by_type(const lf_pack* pack, const lf_region& r, const lf_layer_info& layer) {
  if (layer.pixel_type == LF_BIT) {
    static std::vector<uint64_t> words;
    const size_t line = (size_t(r.width) + 63) / 64, plane = line * r.height;
    words.assign(plane * layer.channels, 0);
    const lf_status s = lf_read_bits(pack, &r, words.data(), line, plane, words.size());
    // Bits behind the region's width are zero.
    for (size_t i = line - 1; s == LF_OK && r.width % 64 != 0 && i < words.size(); i += line)
      require(words[i] >> (r.width % 64) == 0);
    return s;
  }
  static Bytes pixels;
  const bool heights = layer.pixel_type == LF_I16;
  const size_t row_bytes = size_t(r.width) * (heights ? sizeof(float) : layer.channels), all = row_bytes * r.height;
  pixels.assign(all, 0xA5);
  if (!heights) return lf_read(pack, &r, pixels.data(), row_bytes, all);
  auto* floats = reinterpret_cast<float*>(pixels.data());
  const lf_status s = lf_read_heights(pack, &r, floats, row_bytes, all);
  for (size_t i = 0; s == LF_OK && i < all / sizeof(float); ++i) require(!std::isinf(floats[i]));
  return s;
}

void require_wrong_type(const lf_pack* pack, const lf_region& r, uint8_t type) {
  uint64_t nothing = 0;
  if (type != LF_U8) require(lf_read(pack, &r, &nothing, 0, 0) == LF_WRONG_TYPE);
  if (type != LF_BIT) require(lf_read_bits(pack, &r, &nothing, 0, 0, 0) == LF_WRONG_TYPE);
  float none = 0;
  if (type != LF_I16) require(lf_read_heights(pack, &r, &none, 0, 0) == LF_WRONG_TYPE);
}

void ask_for_epochs(const lf_pack* pack, const lf_region& r, bool verified) {
  lf_info info;
  require(lf_get_info(pack, &info) == LF_OK);
  lf_epoch_range range;
  const lf_status s = lf_region_epochs(pack, &r, &range);
  require(!verified || s == LF_OK || s == LF_OUTSIDE_MAP);
  if (s != LF_OK) return;
  require(range.tiles > 0 && range.dated_tiles <= range.tiles && range.newest <= range.oldest);
  require(range.dated_tiles == 0 || range.oldest < info.epoch_count);
}

void ask_for_epochs_of_tile(const lf_pack* pack, uint32_t layer, const lf_tile& tile) {
  uint16_t epochs[4];
  uint32_t count = 0;
  const lf_status s = lf_tile_epochs(pack, layer, tile.level, tile.x, tile.y, epochs, 4, &count);
  require(s == (count > 4 ? LF_BUFFER_TOO_SMALL : LF_OK));
}

void read_region(const lf_pack* pack, const lf_region& r, const lf_layer_info& layer, const lf_ellipse* ellipse,
                 bool verified) {
  if (uint64_t(r.width) * r.height > kMostPixels) return;
  const lf_status before = read_by_type(pack, r, layer);
  require_wrong_type(pack, r, layer.pixel_type);
  ask_for_epochs(pack, r, verified);
  const lf_status prepared = lf_prepare(pack, &r, before == LF_OK ? uint32_t(LF_PREPARE_COPY) : 0u);
  require(!verified || prepared == LF_OK);
  require((prepared == LF_OK) == (read_by_type(pack, r, layer) == LF_OK));
  uint64_t cursor = 0;
  lf_tile tile;
  for (int i = 0; i < 64 && lf_next_tile(pack, &r, ellipse, &cursor, &tile) == LF_OK; ++i) {
    touch(tile.pixels, bytes_of_tile(layer, tile));
    ask_for_epochs_of_tile(pack, r.layer, tile);
  }
}

// Asks twice: for the counts, and with buffers of exactly that size.
lf_status find_landmarks(const lf_pack* pack, uint32_t layer, const lf_feature_query& q, const lf_info& info) {
  size_t count = 0;
  const lf_status s = lf_find_landmarks(pack, layer, &q, nullptr, 0, &count);
  if (s != LF_BUFFER_TOO_SMALL) return s;
  std::vector<lf_landmark> landmarks(count);
  require(lf_find_landmarks(pack, layer, &q, landmarks.data(), count, &count) == LF_OK && count == landmarks.size());
  for (const lf_landmark& m : landmarks) {
    require(m.landmark_class <= LF_PAVED && m.length_m >= m.width_m && m.width_m >= 0.5f);
    require(m.confidence >= q.min_confidence && m.confidence <= 1 && m.source < int32_t(info.source_count));
    require(std::isnan(m.orientation_rad) || (m.orientation_rad >= 0 && m.orientation_rad < 3.1416f));
  }
  return LF_OK;
}

lf_status find_roads(const lf_pack* pack, uint32_t layer, const lf_feature_query& q, const lf_info& info) {
  size_t roads = 0, vertices = 0, crossings = 0;
  const lf_status s = lf_find_roads(pack, layer, &q, nullptr, 0, &roads, nullptr, 0, &vertices);
  if (s != LF_BUFFER_TOO_SMALL) return s;
  std::vector<lf_road> lines(roads);
  std::vector<lf_point> points(vertices);
  require(lf_find_roads(pack, layer, &q, lines.data(), roads, &roads, points.data(), vertices, &vertices) == LF_OK);
  for (const lf_road& r : lines) {
    require(r.vertex_count >= 2 && r.first_vertex + r.vertex_count <= vertices &&
            r.source < int32_t(info.source_count));
    require(std::isfinite(r.length_m) && r.begin <= LF_ROAD_JOINT && r.end <= LF_ROAD_JOINT);
  }
  const lf_status of_crossings = lf_find_intersections(pack, layer, &q, nullptr, 0, &crossings);
  require(of_crossings == (crossings > 0 ? LF_BUFFER_TOO_SMALL : LF_OK));
  std::vector<lf_intersection> found(crossings);
  require(lf_find_intersections(pack, layer, &q, found.data(), crossings, &crossings) == LF_OK);
  for (const lf_intersection& i : found)
    require(i.degree >= 3 && std::is_sorted(i.bearing_rad, i.bearing_rad + std::min(i.degree, uint32_t(LF_MAX_ARMS))));
  return LF_OK;
}

void ask_for_features(const lf_pack* pack, const lf_info& info, uint32_t index, uint8_t type, bool verified) {
  const lf_ellipse ellipse{(info.west_m + info.east_m) / 2, (info.south_m + info.north_m) / 2, 1e4, 5e3, 1e4, 3};
  const lf_feature_query box{sizeof box, 0, info.west_m, info.south_m, info.east_m, info.north_m, nullptr, 0};
  lf_feature_query around = box;
  around.ellipse = &ellipse, around.class_mask = 5, around.min_confidence = 0.5f;
  lf_region region;
  if (lf_box_region(pack, index, box.west_m, box.south_m, box.east_m, box.north_m, 8, &region) != LF_OK) return;
  if (uint64_t(region.width) * region.height > kMostPixels) return;
  const auto find = [&](const lf_feature_query& q) {
    return type == LF_LANDMARKS ? find_landmarks(pack, index, q, info) : find_roads(pack, index, q, info);
  };
  find(box);
  require_wrong_type(pack, region, type);
  ask_for_epochs(pack, region, verified);
  const lf_status prepared = lf_prepare(pack, &region, 0);
  require(!verified || prepared == LF_OK);
  require((prepared == LF_OK) == (find(box) == LF_OK));
  find(around);
  uint64_t cursor = 0;
  lf_tile tile;
  require(lf_next_tile(pack, &region, nullptr, &cursor, &tile) != LF_OK);
}

void ask_for_regions(const lf_pack* pack, const lf_info& info, uint32_t index, bool verified) {
  lf_layer_info layer;
  require(lf_get_layer(pack, index, &layer) == LF_OK);
  touch(layer.name), touch(layer.description);
  uint32_t found;
  require(lf_find_layer(pack, layer.name, &found) == LF_OK && found == index);
  size_t count;
  const lf_feature_query anywhere{sizeof anywhere, 0, 0, 0, 1, 1, nullptr, 0};
  if (layer.pixel_type != LF_LANDMARKS)
    require(lf_find_landmarks(pack, index, &anywhere, nullptr, 0, &count) == LF_WRONG_TYPE);
  if (layer.pixel_type != LF_ROADS)
    require(lf_find_intersections(pack, index, &anywhere, nullptr, 0, &count) == LF_WRONG_TYPE);
  if (layer.pixel_type == LF_LANDMARKS || layer.pixel_type == LF_ROADS)
    return ask_for_features(pack, info, index, layer.pixel_type, verified);
  const double east = info.west_m + (info.east_m - info.west_m) / 2,
               north = info.south_m + (info.north_m - info.south_m) / 2;
  for (uint32_t k = 0; k < layer.level_count; ++k) {
    lf_level_info level;
    require(lf_get_level(pack, index, k, &level) == LF_OK);
    const double gsd = level.gsd_m, sigma = 50 * gsd;
    const lf_ellipse ellipse{east, north, sigma * sigma, sigma * sigma / 2, sigma * sigma, 3};
    lf_region r;
    if (lf_ellipse_region(pack, index, &ellipse, gsd, &r) == LF_OK) read_region(pack, r, layer, &ellipse, verified);
    if (lf_box_region(pack, index, info.west_m, info.south_m, info.east_m, info.north_m, gsd, &r) == LF_OK)
      read_region(pack, r, layer, nullptr, verified);
    lf_tile tile;
    const double side = 256 * gsd;
    for (const double x : {info.west_m, east, info.east_m})
      if (lf_tile_view(pack, index, level.level, int32_t(std::floor(x / side)), int32_t(std::floor(north / side)),
                       &tile) == LF_OK)
        touch(tile.pixels, bytes_of_tile(layer, tile));
  }
}

void ask_for_points(const lf_pack* pack, const lf_info& info) {
  for (const double f : {0.0, 0.25, 0.5, 1.0, 2.0}) {
    const double east = info.west_m + (info.east_m - info.west_m) * f,
                 north = info.south_m + (info.north_m - info.south_m) * f;
    double value, latitude, longitude, scale;
    lf_height_source source;
    if (lf_height(pack, east, north, &value, &source) == LF_OK) require(std::isfinite(value));
    if (lf_undulation(pack, east, north, &value) == LF_OK) require(std::isfinite(value));
    if (lf_geodetic_from_grid(pack, east, north, &latitude, &longitude, nullptr, &scale) != LF_OK) continue;
    double east_again, north_again;
    require(lf_grid_from_geodetic(pack, latitude, longitude, &east_again, &north_again, nullptr, nullptr) == LF_OK);
    require(std::hypot(east - east_again, north - north_again) < 0.01);
  }
}

void ask_everything(const Bytes& bytes) {
  static const uint8_t kKeys[1][32] = {{1, 2, 3}};
  const lf_open_options trusting{sizeof(lf_open_options), 0, kKeys, 1};
  lf_pack* pack = nullptr;
  require(lf_open_memory(bytes.data(), bytes.size(), &trusting, &pack) != LF_OK && pack == nullptr);
  if (lf_open_memory(bytes.data(), bytes.size(), nullptr, &pack) != LF_OK) return;
  lf_info info;
  require(lf_get_info(pack, &info) == LF_OK);
  ask_for_the_manifest(pack, info);
  ask_for_points(pack, info);
  uint64_t tiles = 0;
  const bool verified = lf_verify_pack(pack, 1, &tiles) == LF_OK;
  require(!verified || lf_verify_pack(pack, 0, nullptr) == LF_OK);
  for (uint32_t i = 0; i < info.layer_count; ++i)
    ask_for_regions(pack, info, i, verified && info.version_minor <= landfix::schema::kVersionMinor);
  ask_for_points(pack, info);
  lf_close(pack);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  Bytes bytes;
  if (data[0] % 2 == 0)
    bytes.assign(data + 1, data + size);
  else if (!unfold(data, size, bytes))
    return 0;
  ask_everything(bytes);
  if (bytes.size() >= landfix::schema::kPageSize) {
    const uint8_t secret_key[64] = {7};
    lf_sign_header(bytes.data(), secret_key);
  }
  return 0;
}
