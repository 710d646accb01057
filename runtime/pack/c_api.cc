// The C ABI: null checks, then the work of the other files.
#include <algorithm>
#include <cstring>
#include <new>

#include "runtime/pack/queries.h"
#include "tiles/geodesy.h"

namespace {

using landfix::tiles::Ellipse;
using landfix::tiles::Zone;

const char* text_or_empty(const flatbuffers::String* s) { return s ? s->c_str() : ""; }

Ellipse ellipse_of(const lf_ellipse& e) { return {e.east_m, e.north_m, {e.cov_ee, e.cov_en, e.cov_nn}, e.k}; }

Zone zone_of(const lf_pack& pack) { return {pack.manifest->grid()->zone(), pack.manifest->grid()->north()}; }

void set(double* out, double value) {
  if (out != nullptr) *out = value;
}

template <typename Fill>
lf_status open_with(const lf_open_options* options, lf_pack** out, Fill fill) {
  if (out == nullptr) return LF_INVALID_ARGUMENT;
  *out = nullptr;
  if (options != nullptr && options->struct_size < sizeof(lf_open_options)) return LF_INVALID_ARGUMENT;
  if (options != nullptr && options->trusted_key_count > 0 && options->trusted_keys == nullptr)
    return LF_INVALID_ARGUMENT;
  std::unique_ptr<lf_pack> pack(new (std::nothrow) lf_pack);
  if (!pack) return LF_OUT_OF_MEMORY;
  const bool copy = options != nullptr && (options->flags & LF_OPEN_COPY);
  if (const lf_status s = fill(pack->mapping, copy); s != LF_OK) return s;
  std::span<const uint8_t[32]> keys;
  if (options != nullptr && options->trusted_key_count > 0) keys = {options->trusted_keys, options->trusted_key_count};
  const lf_status s = pack->load(keys);
  if (s == LF_OK) *out = pack.release();
  return s;
}

}  // namespace

const char* lf_status_text(lf_status status) {
  switch (status) {
    case LF_OK:
      return "ok";
    case LF_INVALID_ARGUMENT:
      return "an argument is null, not finite, not a covariance, or names no layer of the pack";
    case LF_IO:
      return "the file cannot be opened or read; check its path and permissions";
    case LF_NOT_A_PACK:
      return "not a landfix pack; if it was one, a text-mode transfer may have changed it: copy it again in binary "
             "mode";
    case LF_UNKNOWN_VERSION:
      return "made by a newer landfix than this one reads; update landfix or rebuild the pack";
    case LF_TRUNCATED:
      return "the file's length differs from what its header says; copy it again";
    case LF_DAMAGED:
      return "the file is damaged: a checksum or record is wrong; copy it again from the original or rebuild it";
    case LF_UNSIGNED:
      return "the pack bears no signature, and only packs signed by a trusted key are accepted; sign it with 'landfix "
             "sign'";
    case LF_UNTRUSTED:
      return "the pack's signature is wrong or made by none of the trusted keys; get it from a source that you trust";
    case LF_OUT_OF_MEMORY:
      return "out of memory";
    case LF_NO_SUCH_LAYER:
      return "the pack has no such layer; 'landfix info' lists those it has";
    case LF_OUTSIDE_MAP:
      return "the map has no data there; 'landfix info' shows its bounds";
    case LF_NOT_PREPARED:
      return "the layer is compressed: prepare the region before it is read";
    case LF_BUFFER_TOO_SMALL:
      return "the buffer is too small for the region";
    case LF_REGION_TOO_LARGE:
      return "the region has too many pixels; ask for a smaller one or a coarser GSD";
    case LF_WRONG_TYPE:
      return "the layer's pixels are of another type: pixels, heights, bit planes, landmarks and roads are read with "
             "a call of their own each";
    case LF_END:
      return "no more tiles";
  }
  return "unknown status";
}

const char* lf_version(void) { return LANDFIX_VERSION; }
uint32_t lf_abi_version(void) { return LF_ABI_VERSION; }

lf_status lf_open(const char* path, const lf_open_options* options, lf_pack** pack) {
  if (path == nullptr) return LF_INVALID_ARGUMENT;
  return open_with(options, pack, [&](landfix::pack::Mapping& m, bool copy) { return m.open(path, copy); });
}

lf_status lf_open_memory(const void* data, size_t size, const lf_open_options* options, lf_pack** pack) {
  return open_with(options, pack, [&](landfix::pack::Mapping& m, bool) { return m.borrow(data, size); });
}

void lf_close(lf_pack* pack) { delete pack; }

lf_status lf_get_info(const lf_pack* pack, lf_info* info) {
  if (pack == nullptr || info == nullptr) return LF_INVALID_ARGUMENT;
  const auto& m = *pack->manifest;
  lf_info i{};
  i.version_major = pack->header.version_major;
  i.version_minor = pack->header.version_minor;
  i.zone = m.grid()->zone();
  i.north = m.grid()->north();
  i.is_signed = pack->header.signature_kind != uint32_t(landfix::schema::SignatureKind::kNone);
  i.has_heights = pack->height_layer != nullptr;
  i.layer_count = pack->layer_count;
  i.source_count = m.sources()->size();
  i.parameter_count = m.parameters() ? m.parameters()->size() : 0;
  i.epoch_count = m.epochs() ? m.epochs()->size() : 0;
  i.west_m = m.bounds()->west_m(), i.south_m = m.bounds()->south_m();
  i.east_m = m.bounds()->east_m(), i.north_m = m.bounds()->north_m();
  i.plane_height_m = m.plane_height_m();
  i.georegistration_error_m = double(m.georegistration_error_m());
  i.file_length = pack->header.file_length;
  i.builder = text_or_empty(m.builder());
  std::memcpy(i.root, pack->header.root.bytes, 32);
  std::memcpy(i.public_key, pack->header.public_key, 32);
  *info = i;
  return LF_OK;
}

lf_status lf_find_layer(const lf_pack* pack, const char* name, uint32_t* layer) {
  if (pack == nullptr || name == nullptr || layer == nullptr) return LF_INVALID_ARGUMENT;
  for (uint32_t i = 0; i < pack->layer_count; ++i)
    if (std::strcmp(pack->layers[i].name, name) == 0) {
      *layer = i;
      return LF_OK;
    }
  return LF_NO_SUCH_LAYER;
}

lf_status lf_get_layer(const lf_pack* pack, uint32_t layer, lf_layer_info* info) {
  if (pack == nullptr || info == nullptr || layer >= pack->layer_count) return LF_INVALID_ARGUMENT;
  const auto& l = pack->layers[layer];
  *info = {l.name, l.description, uint8_t(l.type), l.format.channels, l.format.nodata, l.level_count};
  return LF_OK;
}

lf_status lf_get_level(const lf_pack* pack, uint32_t layer, uint32_t index, lf_level_info* info) {
  if (pack == nullptr || info == nullptr || layer >= pack->layer_count) return LF_INVALID_ARGUMENT;
  const auto& l = pack->layers[layer];
  if (index >= l.level_count) return LF_INVALID_ARGUMENT;
  *info = {l.levels[index].level, l.levels[index].tile_count, landfix::tiles::gsd_of(l.levels[index].level)};
  return LF_OK;
}

lf_status lf_get_source(const lf_pack* pack, uint32_t index, lf_source_info* info) {
  if (pack == nullptr || info == nullptr || index >= pack->manifest->sources()->size()) return LF_INVALID_ARGUMENT;
  const auto& s = *pack->manifest->sources()->Get(index);
  *info = {s.name()->c_str(),
           text_or_empty(s.capture_date()),
           text_or_empty(s.licence()),
           text_or_empty(s.attribution()),
           text_or_empty(s.crs()),
           text_or_empty(s.vertical_datum()),
           uint8_t(s.role()),
           s.gsd_m(),
           {}};
  if (s.sha256() != nullptr) std::memcpy(info->sha256, s.sha256()->data(), 32);
  return LF_OK;
}

lf_status lf_get_epoch(const lf_pack* pack, uint32_t index, lf_epoch_info* info) {
  if (pack == nullptr || info == nullptr) return LF_INVALID_ARGUMENT;
  const auto* epochs = pack->manifest->epochs();
  if (epochs == nullptr || index >= epochs->size()) return LF_INVALID_ARGUMENT;
  const auto& e = *epochs->Get(index);
  *info = {text_or_empty(e.date()), e.sources() ? e.sources()->size() : 0, e.sources() ? e.sources()->data() : nullptr};
  return LF_OK;
}

lf_status lf_get_parameter(const lf_pack* pack, uint32_t index, const char** name, const char** value) {
  if (pack == nullptr || name == nullptr || value == nullptr) return LF_INVALID_ARGUMENT;
  const auto* parameters = pack->manifest->parameters();
  if (parameters == nullptr || index >= parameters->size()) return LF_INVALID_ARGUMENT;
  *name = parameters->Get(index)->name()->c_str();
  *value = parameters->Get(index)->value()->c_str();
  return LF_OK;
}

lf_status lf_ellipse_region(const lf_pack* pack, uint32_t layer, const lf_ellipse* ellipse, double gsd_m,
                            lf_region* region) {
  if (pack == nullptr || ellipse == nullptr || region == nullptr) return LF_INVALID_ARGUMENT;
  return landfix::pack::ellipse_region(*pack, layer, ellipse_of(*ellipse), gsd_m, *region);
}

lf_status lf_box_region(const lf_pack* pack, uint32_t layer, double west_m, double south_m, double east_m,
                        double north_m, double gsd_m, lf_region* region) {
  if (pack == nullptr || region == nullptr) return LF_INVALID_ARGUMENT;
  return landfix::pack::box_region(*pack, layer, {west_m, south_m, east_m, north_m}, gsd_m, *region);
}

lf_status lf_read(const lf_pack* pack, const lf_region* region, void* out, size_t row_bytes, size_t out_bytes) {
  if (pack == nullptr || region == nullptr || out == nullptr) return LF_INVALID_ARGUMENT;
  return landfix::pack::read_pixels(*pack, *region, static_cast<uint8_t*>(out), row_bytes, out_bytes);
}

lf_status lf_read_heights(const lf_pack* pack, const lf_region* region, float* out, size_t row_bytes,
                          size_t out_bytes) {
  if (pack == nullptr || region == nullptr || out == nullptr) return LF_INVALID_ARGUMENT;
  return landfix::pack::read_values(*pack, *region, out, row_bytes, out_bytes);
}

lf_status lf_read_bits(const lf_pack* pack, const lf_region* region, uint64_t* out, size_t row_words,
                       size_t plane_words, size_t out_words) {
  if (pack == nullptr || region == nullptr || out == nullptr) return LF_INVALID_ARGUMENT;
  return landfix::pack::read_bits(*pack, *region, out, row_words, plane_words, out_words);
}

lf_status lf_tile_epochs(const lf_pack* pack, uint32_t layer, int32_t level, int32_t x, int32_t y, uint16_t* epochs,
                         uint32_t capacity, uint32_t* count) {
  if (pack == nullptr || count == nullptr || (epochs == nullptr && capacity > 0)) return LF_INVALID_ARGUMENT;
  std::span<const uint16_t> found;
  if (const lf_status s = landfix::pack::tile_epochs(*pack, layer, {level, x, y}, found); s != LF_OK) return s;
  *count = uint32_t(found.size());
  if (found.size() > capacity) return LF_BUFFER_TOO_SMALL;
  std::copy(found.begin(), found.end(), epochs);
  return LF_OK;
}

lf_status lf_region_epochs(const lf_pack* pack, const lf_region* region, lf_epoch_range* range) {
  if (pack == nullptr || region == nullptr || range == nullptr) return LF_INVALID_ARGUMENT;
  return landfix::pack::region_epochs(*pack, *region, *range);
}

lf_status lf_tile_view(const lf_pack* pack, uint32_t layer, int32_t level, int32_t x, int32_t y, lf_tile* tile) {
  if (pack == nullptr || tile == nullptr) return LF_INVALID_ARGUMENT;
  return landfix::pack::tile_view(*pack, layer, {level, x, y}, *tile);
}

lf_status lf_next_tile(const lf_pack* pack, const lf_region* region, const lf_ellipse* ellipse, uint64_t* cursor,
                       lf_tile* tile) {
  if (pack == nullptr || region == nullptr || cursor == nullptr || tile == nullptr) return LF_INVALID_ARGUMENT;
  if (ellipse == nullptr) return landfix::pack::next_tile(*pack, *region, nullptr, *cursor, *tile);
  const Ellipse e = ellipse_of(*ellipse);
  return landfix::pack::next_tile(*pack, *region, &e, *cursor, *tile);
}

lf_status lf_prepare(const lf_pack* pack, const lf_region* region, uint32_t flags) {
  if (pack == nullptr || region == nullptr) return LF_INVALID_ARGUMENT;
  return landfix::pack::prepare(*pack, *region, flags & LF_PREPARE_COPY);
}

lf_status lf_find_landmarks(const lf_pack* pack, uint32_t layer, const lf_feature_query* query, lf_landmark* landmarks,
                            size_t capacity, size_t* count) {
  if (pack == nullptr || query == nullptr || count == nullptr || (landmarks == nullptr && capacity > 0))
    return LF_INVALID_ARGUMENT;
  return landfix::pack::find_landmarks(*pack, layer, *query, {landmarks, capacity}, *count);
}

lf_status lf_find_intersections(const lf_pack* pack, uint32_t layer, const lf_feature_query* query,
                                lf_intersection* intersections, size_t capacity, size_t* count) {
  if (pack == nullptr || query == nullptr || count == nullptr || (intersections == nullptr && capacity > 0))
    return LF_INVALID_ARGUMENT;
  return landfix::pack::find_intersections(*pack, layer, *query, {intersections, capacity}, *count);
}

lf_status lf_find_roads(const lf_pack* pack, uint32_t layer, const lf_feature_query* query, lf_road* roads,
                        size_t road_capacity, size_t* road_count, lf_point* vertices, size_t vertex_capacity,
                        size_t* vertex_count) {
  if (pack == nullptr || query == nullptr || road_count == nullptr || vertex_count == nullptr ||
      (roads == nullptr && road_capacity > 0) || (vertices == nullptr && vertex_capacity > 0))
    return LF_INVALID_ARGUMENT;
  return landfix::pack::find_roads(*pack, layer, *query, {{roads, road_capacity}, {vertices, vertex_capacity}},
                                   *road_count, *vertex_count);
}

lf_status lf_height(const lf_pack* pack, double east_m, double north_m, double* height_m, lf_height_source* source) {
  if (pack == nullptr || height_m == nullptr) return LF_INVALID_ARGUMENT;
  double h;
  lf_height_source from;
  const lf_status s = landfix::pack::height(*pack, east_m, north_m, h, from);
  if (s != LF_OK) return s;
  *height_m = h;
  if (source != nullptr) *source = from;
  return LF_OK;
}

lf_status lf_undulation(const lf_pack* pack, double east_m, double north_m, double* undulation_m) {
  if (pack == nullptr || undulation_m == nullptr) return LF_INVALID_ARGUMENT;
  return landfix::pack::undulation(*pack, east_m, north_m, *undulation_m);
}

lf_status lf_grid_from_geodetic(const lf_pack* pack, double latitude_rad, double longitude_rad, double* east_m,
                                double* north_m, double* convergence_rad, double* scale) {
  if (pack == nullptr || east_m == nullptr || north_m == nullptr) return LF_INVALID_ARGUMENT;
  const auto g = landfix::tiles::grid_from_geodetic(zone_of(*pack), {latitude_rad, longitude_rad});
  if (!g) return LF_INVALID_ARGUMENT;
  *east_m = g->east_m, *north_m = g->north_m;
  set(convergence_rad, g->convergence_rad), set(scale, g->scale);
  return LF_OK;
}

lf_status lf_geodetic_from_grid(const lf_pack* pack, double east_m, double north_m, double* latitude_rad,
                                double* longitude_rad, double* convergence_rad, double* scale) {
  if (pack == nullptr || latitude_rad == nullptr || longitude_rad == nullptr) return LF_INVALID_ARGUMENT;
  const auto g = landfix::tiles::geodetic_from_grid(zone_of(*pack), east_m, north_m);
  if (!g) return LF_INVALID_ARGUMENT;
  *latitude_rad = g->latitude_rad, *longitude_rad = g->longitude_rad;
  set(convergence_rad, g->convergence_rad), set(scale, g->scale);
  return LF_OK;
}

lf_status lf_verify_pack(const lf_pack* pack, int deep, uint64_t* tiles) {
  if (pack == nullptr) return LF_INVALID_ARGUMENT;
  uint64_t count = 0;
  const lf_status s = landfix::pack::verify(*pack, deep != 0, count);
  if (tiles != nullptr) *tiles = count;
  return s;
}
