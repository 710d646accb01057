// Every field of a pack as JSON: header and records by the structs of schemas/, the rest through FlatBuffers and the C
// API.
#include <sodium.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "landfix/landfix.hpp"
#include "schemas/pack_generated.h"
#include "tests/pack/fixture.h"
#include "tests/pack/patch.h"
#include "tiles/grid.h"

namespace landfix::tests {
namespace {

using nlohmann::json;

std::string hex(std::span<const uint8_t> bytes) {
  std::string text(bytes.size() * 2 + 1, 0);
  sodium_bin2hex(text.data(), text.size(), bytes.data(), bytes.size());
  text.pop_back();
  return text;
}

std::string digest(std::span<const uint8_t> bytes) {
  uint8_t out[32];
  crypto_generichash(out, sizeof out, bytes.data(), bytes.size(), nullptr, 0);
  return hex(out);
}

json text(const flatbuffers::String* s) { return s ? json(s->str()) : json(nullptr); }

json header_of(const schema::Header& h) {
  return {{"version_major", h.version_major},
          {"version_minor", h.version_minor},
          {"page_size", h.page_size},
          {"file_length", h.file_length},
          {"manifest_offset", h.manifest_offset},
          {"manifest_length", h.manifest_length},
          {"block_table_offset", h.block_table_offset},
          {"block_count", h.block_count},
          {"manifest_hash", hex(h.manifest_hash.bytes)},
          {"block_table_hash", hex(h.block_table_hash.bytes)},
          {"root", hex(h.root.bytes)},
          {"signature_kind", h.signature_kind},
          {"public_key", hex(h.public_key)},
          {"signature", hex(h.signature)},
          {"header_hash", hex(h.header_hash.bytes)}};
}

json source_of(const schema::Source& s) {
  json bands = json::array();
  if (s.bands())
    for (const auto* band : *s.bands()) bands.push_back(band->str());
  return {{"name", text(s.name())},
          {"role", uint8_t(s.role())},
          {"sha256", s.sha256() ? json(hex({s.sha256()->data(), s.sha256()->size()})) : json(nullptr)},
          {"capture_date", text(s.capture_date())},
          {"licence", text(s.licence())},
          {"attribution", text(s.attribution())},
          {"crs", text(s.crs())},
          {"vertical_datum", text(s.vertical_datum())},
          {"bands", bands},
          {"gsd_m", s.gsd_m()}};
}

json indices_of(const flatbuffers::Vector<uint16_t>* indices) {
  json out = json::array();
  if (indices)
    for (const uint16_t i : *indices) out.push_back(i);
  return out;
}

json geoid_of(const schema::Geoid* g) {
  if (g == nullptr) return nullptr;
  json nodes = json::array();
  for (const float n : *g->undulation_m()) nodes.push_back(double(n));
  return {{"model", text(g->model())},   {"west_m", g->west_m()},   {"south_m", g->south_m()},
          {"spacing_m", g->spacing_m()}, {"columns", g->columns()}, {"rows", g->rows()},
          {"undulation_m", nodes}};
}

json layer_of(const schema::Layer& l) {
  json levels = json::array();
  for (const auto* v : *l.levels())
    levels.push_back({{"level", v->level()},
                      {"first_block", v->first_block()},
                      {"block_count", v->block_count()},
                      {"tile_count", v->tile_count()}});
  return {{"name", text(l.name())},
          {"kind", uint8_t(l.kind())},
          {"pixel_type", uint8_t(l.pixel_type())},
          {"channels", l.channels()},
          {"nodata", l.nodata()},
          {"levels", levels},
          {"description", text(l.description())},
          {"content", uint8_t(l.content())}};
}

json manifest_of(const schema::Manifest& m) {
  json layers = json::array(), sources = json::array(), parameters = json::array();
  for (const auto* l : *m.layers()) layers.push_back(layer_of(*l));
  for (const auto* s : *m.sources()) sources.push_back(source_of(*s));
  if (m.parameters())
    for (const auto* p : *m.parameters())
      parameters.push_back({{"name", text(p->name())}, {"value", text(p->value())}});
  json epochs = json::array(), sets = json::array();
  if (m.epochs())
    for (const auto* e : *m.epochs())
      epochs.push_back({{"date", text(e->date())}, {"sources", indices_of(e->sources())}});
  if (m.epoch_sets())
    for (const auto* s : *m.epoch_sets()) sets.push_back(indices_of(s->epochs()));
  const schema::Bounds& b = *m.bounds();
  return {{"grid", {{"zone", m.grid()->zone()}, {"north", m.grid()->north()}}},
          {"bounds", {b.west_m(), b.south_m(), b.east_m(), b.north_m()}},
          {"layers", layers},
          {"sources", sources},
          {"geoid", geoid_of(m.geoid())},
          {"plane_height_m", m.plane_height_m()},
          {"georegistration_error_m", double(m.georegistration_error_m())},
          {"builder", text(m.builder())},
          {"parameters", parameters},
          {"epochs", epochs},
          {"epoch_sets", sets}};
}

json block_of(const schema::BlockRecord& b) {
  return {{"first_key", b.first_key},
          {"last_key", b.last_key},
          {"offset", b.offset},
          {"count", b.count},
          {"hash", hex(b.hash.bytes)}};
}

double rounded(double value) { return std::round(value * 1000) / 1000; }

FeatureQuery query_of(const tiles::TileIndex& index) {
  const double side = tiles::tile_side(index.level), west = index.x * side, south = index.y * side;
  return {.ellipse = {}, .west_m = west, .south_m = south, .east_m = west + side, .north_m = south + side};
}

json landmarks_of(const Pack& pack, uint32_t layer, const tiles::TileIndex& index) {
  std::vector<Landmark> landmarks(65536);
  size_t count = 0;
  if (pack.find_landmarks(layer, query_of(index), landmarks, count) != LF_OK)
    throw std::runtime_error("landmarks that cannot be found");
  json out = json::array();
  for (size_t i = 0; i < count; ++i) {
    const Landmark& m = landmarks[i];
    const bool oriented = !std::isnan(m.orientation_rad);
    out.push_back({{"place_m", {m.east_m, m.north_m}},
                   {"class", m.landmark_class},
                   {"length_m", rounded(double(m.length_m))},
                   {"width_m", rounded(double(m.width_m))},
                   {"orientation_rad", oriented ? json(rounded(double(m.orientation_rad))) : json(nullptr)},
                   {"confidence", rounded(double(m.confidence))},
                   {"distinctiveness_m", int(m.distinctiveness_m)},
                   {"epochs_seen", m.epochs_seen},
                   {"source", m.source}});
  }
  return out;
}

json roads_of(const Pack& pack, uint32_t layer, const tiles::TileIndex& index) {
  std::vector<Road> roads(65536);
  std::vector<Point> vertices(262144);
  size_t count = 0, vertex_count = 0;
  if (pack.find_roads(layer, query_of(index), roads, count, vertices, vertex_count) != LF_OK)
    throw std::runtime_error("roads that cannot be found");
  json out = json::array();
  for (size_t i = 0; i < count; ++i) {
    json line = json::array();
    for (size_t k = 0; k < roads[i].vertex_count; ++k) {
      const Point& p = vertices[roads[i].first_vertex + k];
      line.push_back({p.east_m, p.north_m});
    }
    out.push_back({{"line_m", line},
                   {"width_m", rounded(double(roads[i].width_m))},
                   {"confidence", rounded(double(roads[i].confidence))},
                   {"source", roads[i].source},
                   {"begin", roads[i].begin},
                   {"end", roads[i].end}});
  }
  return out;
}

json pixels_of(const Pack& pack, uint32_t layer, const tiles::TileIndex& index) {
  const auto view = pack.tile(layer, index.level, index.x, index.y);
  if (!view) throw std::runtime_error(view.text());
  const size_t bytes =
      pack.layer(layer)->pixel_type == LF_BIT ? 8192u * pack.layer(layer)->channels : size_t(view->row_bytes) * 256;
  return digest({static_cast<const uint8_t*>(view->pixels), bytes});
}

json tile_of(const Pack& pack, uint32_t layer, const tiles::TileIndex& index, const schema::TileRecord& t) {
  const double side = tiles::tile_side(index.level), west = index.x * side, south = index.y * side;
  const auto region = pack.box(layer, west, south, west + side, south + side, tiles::gsd_of(index.level));
  if (!region || pack.prepare(*region) != LF_OK) throw std::runtime_error("a tile that cannot be prepared");
  std::array<uint16_t, 64> epochs_of_tile;
  const auto count = pack.tile_epochs(layer, index.level, index.x, index.y, epochs_of_tile);
  if (!count) throw std::runtime_error(count.text());
  const json epochs(std::vector<uint16_t>(epochs_of_tile.begin(), epochs_of_tile.begin() + *count));
  const uint8_t type = pack.layer(layer)->pixel_type;
  const json features = type == LF_LANDMARKS ? landmarks_of(pack, layer, index)
                        : type == LF_ROADS   ? roads_of(pack, layer, index)
                                             : json(nullptr);
  return {{"layer", pack.layer(layer)->name},
          {"level", index.level},
          {"x", index.x},
          {"y", index.y},
          {"key", t.key},
          {"offset", t.offset},
          {"length", t.length},
          {"codec", t.codec},
          {"epochs", epochs},
          {"value_offset", double(t.value_offset)},
          {"value_step", double(t.value_step)},
          {"hash", hex(t.hash.bytes)},
          {"features", features},
          {"pixels", features.is_null() ? pixels_of(pack, layer, index) : json(nullptr)}};
}

}  // namespace

std::string describe(const std::vector<uint8_t>& bytes) {
  const auto pack = Pack::open_memory(std::as_bytes(std::span(bytes)));
  if (!pack) throw std::runtime_error(pack.text());
  Patch patch(bytes);
  const schema::Manifest& manifest = *schema::GetManifest(patch.manifest().data());
  json out{{"header", header_of(patch.header())},
           {"manifest", manifest_of(manifest)},
           {"blocks", json::array()},
           {"tiles", json::array()}};
  for (const schema::BlockRecord& block : patch.blocks()) out["blocks"].push_back(block_of(block));
  for (const auto* layer : *manifest.layers())
    for (const auto* level : *layer->levels())
      for (const schema::BlockRecord& block : patch.blocks().subspan(level->first_block(), level->block_count()))
        for (const schema::TileRecord& tile : patch.tiles(block))
          out["tiles"].push_back(tile_of(*pack, *pack->find_layer(layer->name()->c_str()),
                                         tiles::tile_of_key(level->level(), tile.key), tile));
  return out.dump(1);
}

}  // namespace landfix::tests
