// Opening: everything that is checked before a pack answers its first question (FORMAT.md section 4.1).
#include <sodium.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <new>
#include <string_view>

#include "runtime/pack/pack.h"
#include "tiles/geodesy.h"
#include "tiles/vector_tile.h"

namespace landfix::pack {
namespace {

using schema::Header;

lf_status check_header(const Header& h, uint64_t size) {
  if (h.header_hash != hash_of(&h, offsetof(Header, header_hash))) return LF_DAMAGED;
  if (h.version_major != schema::kVersionMajor) return LF_UNKNOWN_VERSION;
  if (h.file_length != size) return LF_TRUNCATED;
  if (h.page_size != schema::kPageSize) return LF_DAMAGED;
  if (h.root != hash_of(&h, offsetof(Header, root))) return LF_DAMAGED;
  if (h.manifest_length > schema::kMaxManifestBytes || h.manifest_offset % 8 != 0 ||
      !inside(h.manifest_offset, h.manifest_length, size))
    return LF_DAMAGED;
  if (h.block_count > size / sizeof(schema::BlockRecord) || h.block_table_offset % 8 != 0 ||
      !inside(h.block_table_offset, h.block_count * sizeof(schema::BlockRecord), size))
    return LF_DAMAGED;
  return LF_OK;
}

lf_status check_signature(const Header& h, std::span<const uint8_t[32]> keys) {
  if (keys.empty()) return LF_OK;
  if (h.signature_kind == uint32_t(schema::SignatureKind::kNone)) return LF_UNSIGNED;
  if (h.signature_kind != uint32_t(schema::SignatureKind::kEd25519)) return LF_UNTRUSTED;
  bool trusted = false;
  for (const auto& key : keys) trusted |= std::memcmp(key, h.public_key, 32) == 0;
  if (!trusted) return LF_UNTRUSTED;
  const SignedMessage message = signed_message(h.root);
  return crypto_sign_verify_detached(h.signature, message.data(), message.size(), h.public_key) == 0 ? LF_OK
                                                                                                     : LF_UNTRUSTED;
}

bool check_geoid(const schema::Geoid& g) {
  const uint64_t nodes = uint64_t(g.columns()) * g.rows();
  return g.columns() >= 2 && g.rows() >= 2 && g.undulation_m()->size() == nodes && std::isfinite(g.west_m()) &&
         std::isfinite(g.south_m()) && std::isfinite(g.spacing_m()) && g.spacing_m() > 0 &&
         std::all_of(g.undulation_m()->begin(), g.undulation_m()->end(), [](float v) { return std::isfinite(v); });
}

using Indices = flatbuffers::Vector<uint16_t>;

// Strictly ascending indices into a list of `size`; absent ones are none.
bool are_indices(const Indices* indices, size_t size) {
  if (indices == nullptr || indices->size() == 0) return true;
  return std::adjacent_find(indices->begin(), indices->end(), std::greater_equal<>()) == indices->end() &&
         indices->Get(indices->size() - 1) < size;
}

// Newest first, undated last: the order of the bytes of ISO 8601 dates, downwards.
bool check_epochs(const schema::Manifest& m) {
  const size_t epochs = m.epochs() ? m.epochs()->size() : 0, sets = m.epoch_sets() ? m.epoch_sets()->size() : 0;
  if (epochs > schema::kMaxEpochs || sets > schema::kMaxEpochs) return false;
  std::string_view newer;
  for (uint32_t i = 0; i < epochs; ++i) {
    const schema::Epoch& epoch = *m.epochs()->Get(i);
    const std::string_view date = epoch.date() ? epoch.date()->string_view() : std::string_view();
    if ((i > 0 && date > newer) || !are_indices(epoch.sources(), m.sources()->size())) return false;
    newer = date;
  }
  for (uint32_t i = 0; i < sets; ++i) {
    const Indices* set = m.epoch_sets()->Get(i)->epochs();
    if (set->size() == 0 || !are_indices(set, epochs)) return false;
  }
  return true;
}

lf_status check_manifest(const schema::Manifest& m) {
  const schema::Bounds& b = *m.bounds();
  for (const double v : {b.west_m(), b.south_m(), b.east_m(), b.north_m()})
    if (!(std::abs(v) <= tiles::kDomainHalf)) return LF_DAMAGED;
  if (b.west_m() > b.east_m() || b.south_m() > b.north_m()) return LF_DAMAGED;
  if (!tiles::is_valid({m.grid()->zone(), m.grid()->north()})) return LF_DAMAGED;
  if (!std::isfinite(m.plane_height_m()) || !std::isfinite(m.georegistration_error_m())) return LF_DAMAGED;
  if (m.geoid() != nullptr && !check_geoid(*m.geoid())) return LF_DAMAGED;
  if (m.layers()->size() > kMaxLayers) return LF_DAMAGED;
  for (const auto* source : *m.sources())
    if (source->sha256() != nullptr && source->sha256()->size() != 32) return LF_DAMAGED;
  return check_epochs(m) ? LF_OK : LF_DAMAGED;
}

bool is_known(const schema::Layer& l) {
  if (l.kind() == schema::LayerKind::Vector)
    return l.content() == schema::VectorContent::Landmarks || l.content() == schema::VectorContent::Roads;
  if (l.kind() != schema::LayerKind::Raster || l.channels() == 0) return false;
  switch (l.pixel_type()) {
    case schema::PixelType::U8:
      return true;
    case schema::PixelType::I16:
      return l.channels() == 1;
    case schema::PixelType::Bit:
      return l.channels() <= tiles::kMaxBitChannels;
  }
  return false;
}

bool holds_nodata(const tiles::TileFormat& f) {
  switch (f.type) {
    case tiles::PixelType::kU8:
      return f.nodata >= 0 && f.nodata <= 255;
    case tiles::PixelType::kI16:
      return true;
    case tiles::PixelType::kBit:
      return f.nodata == 0 || f.nodata == 1;
  }
  return false;
}

// What a tile of the layer holds.
bool load_type(const schema::Layer& in, Layer& out) {
  if (in.kind() == schema::LayerKind::Vector) {
    out.type = in.content() == schema::VectorContent::Landmarks ? LF_LANDMARKS : LF_ROADS;
    out.format.channels = 0;
    return in.levels()->size() == 1 && in.levels()->Get(0)->level() == tiles::kVectorLevel;
  }
  out.format.type = tiles::PixelType(in.pixel_type());
  out.format.channels = in.channels();
  out.format.nodata = in.nodata();
  out.type = lf_pixel_type(in.pixel_type());
  return holds_nodata(out.format);
}

lf_status load_layer(const schema::Layer& in, std::span<const schema::BlockRecord> blocks, Layer& out) {
  out.name = in.name()->c_str();
  out.description = in.description() ? in.description()->c_str() : "";
  if (!load_type(in, out)) return LF_DAMAGED;
  if (in.levels()->size() == 0 || in.levels()->size() > kMaxLevels) return LF_DAMAGED;
  for (const schema::Level* l : *in.levels()) {
    if (l->level() < tiles::kMinLevel || l->level() > tiles::kMaxLevel) return LF_DAMAGED;
    if (out.level_count && out.levels[out.level_count - 1].level >= l->level()) return LF_DAMAGED;
    if (!inside(l->first_block(), l->block_count(), blocks.size())) return LF_DAMAGED;
    for (uint32_t i = 0; i < l->block_count(); ++i) {
      const schema::BlockRecord& b = blocks[l->first_block() + i];
      if (b.first_key > b.last_key || (i > 0 && blocks[l->first_block() + i - 1].last_key >= b.first_key))
        return LF_DAMAGED;
    }
    out.levels[out.level_count++] = {l->level(), l->first_block(), l->block_count(), l->tile_count()};
  }
  return LF_OK;
}

// A slot must belong to one level: the checked bits and the cache depend on the format that the slot was first used
// with.
bool runs_overlap(const Layer* layers, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i)
    for (uint32_t a = 0; a < layers[i].level_count; ++a)
      for (uint32_t j = i; j < count; ++j)
        for (uint32_t b = j == i ? a + 1 : 0; b < layers[j].level_count; ++b) {
          const Level &p = layers[i].levels[a], &q = layers[j].levels[b];
          if (p.first_block < uint64_t(q.first_block) + q.block_count &&
              q.first_block < uint64_t(p.first_block) + p.block_count)
            return true;
        }
  return false;
}

lf_status load_layers(lf_pack& pack) {
  pack.layers.reset(new (std::nothrow) Layer[pack.manifest->layers()->size()]);
  if (!pack.layers) return LF_OUT_OF_MEMORY;
  for (const schema::Layer* l : *pack.manifest->layers()) {
    if (!is_known(*l)) continue;
    Layer& layer = pack.layers[pack.layer_count];
    if (const lf_status s = load_layer(*l, pack.blocks, layer); s != LF_OK) return s;
    for (uint32_t i = 0; i < pack.layer_count; ++i)
      if (std::strcmp(pack.layers[i].name, layer.name) == 0) return LF_DAMAGED;
    ++pack.layer_count;
    if (std::strcmp(layer.name, "height") == 0 && layer.type == LF_I16) pack.height_layer = &layer;
  }
  return runs_overlap(pack.layers.get(), pack.layer_count) ? LF_DAMAGED : LF_OK;
}

lf_status load_vector_sources(lf_pack& pack) {
  const auto& sources = *pack.manifest->sources();
  pack.vector_sources.reset(new (std::nothrow) uint32_t[sources.size()]);
  if (!pack.vector_sources) return LF_OUT_OF_MEMORY;
  for (uint32_t i = 0; i < sources.size(); ++i)
    if (sources.Get(i)->role() == schema::SourceRole::Vector) pack.vector_sources[pack.vector_source_count++] = i;
  return LF_OK;
}

}  // namespace

schema::Hash hash_of(const void* data, size_t size) {
  schema::Hash h;
  crypto_generichash(h.bytes, sizeof h.bytes, static_cast<const uint8_t*>(data), size, nullptr, 0);
  return h;
}

SignedMessage signed_message(const schema::Hash& root) {
  SignedMessage message;
  std::memcpy(message.data(), schema::kSignatureContext, kContextBytes);
  std::memcpy(message.data() + kContextBytes, root.bytes, sizeof root.bytes);
  return message;
}

}  // namespace landfix::pack

lf_status lf_pack::load(std::span<const uint8_t[32]> keys) {
  using namespace landfix;
  const uint8_t* data = mapping.data();
  const size_t size = mapping.size();
  if (size < sizeof schema::kMagic || std::memcmp(data, schema::kMagic, sizeof schema::kMagic) != 0)
    return LF_NOT_A_PACK;
  if (size < sizeof header) return LF_TRUNCATED;
  if (sodium_init() < 0) return LF_OUT_OF_MEMORY;
  std::memcpy(&header, data, sizeof header);
  if (const lf_status s = pack::check_header(header, size); s != LF_OK) return s;
  if (const lf_status s = pack::check_signature(header, keys); s != LF_OK) return s;

  const uint8_t* bytes = data + header.manifest_offset;
  if (pack::hash_of(bytes, header.manifest_length) != header.manifest_hash) return LF_DAMAGED;
  flatbuffers::Verifier verifier(bytes, header.manifest_length, 16, 1u << 20);
  if (!schema::VerifyManifestBuffer(verifier)) return LF_DAMAGED;
  manifest = schema::GetManifest(bytes);
  if (const lf_status s = pack::check_manifest(*manifest); s != LF_OK) return s;

  blocks = {reinterpret_cast<const schema::BlockRecord*>(data + header.block_table_offset), header.block_count};
  if (pack::hash_of(blocks.data(), blocks.size_bytes()) != header.block_table_hash) return LF_DAMAGED;
  if (!checked_blocks.allocate(blocks.size()) || !checked_tiles.allocate(blocks.size() * schema::kBlockTiles) ||
      !cache.allocate(blocks.size() * schema::kBlockTiles))
    return LF_OUT_OF_MEMORY;
  if (const lf_status s = pack::load_vector_sources(*this); s != LF_OK) return s;
  return pack::load_layers(*this);
}
