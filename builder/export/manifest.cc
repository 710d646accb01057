#include "builder/error.h"
#include "builder/export/pack_writer.h"
#include "schemas/pack_generated.h"

namespace landfix::exporter {
namespace {

using flatbuffers::FlatBufferBuilder;
using flatbuffers::Offset;
using String = Offset<flatbuffers::String>;

// Absent rather than empty.
String text_or_none(FlatBufferBuilder& builder, const std::string& text) {
  return text.empty() ? String{} : builder.CreateString(text);
}

uint8_t hex_digit(char c) {
  if (c >= '0' && c <= '9') return uint8_t(c - '0');
  if (c >= 'a' && c <= 'f') return uint8_t(c - 'a' + 10);
  throw Error(ExitCode::kInternal, "a source's SHA-256 is not in lower-case hexadecimal digits");
}

std::vector<uint8_t> bytes_of_hex(const std::string& text) {
  std::vector<uint8_t> bytes(text.size() / 2);
  for (size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = uint8_t(hex_digit(text[2 * i]) << 4 | hex_digit(text[2 * i + 1]));
  return bytes;
}

Offset<schema::Layer> encode_layer(FlatBufferBuilder& builder, const PackLayer& layer, uint32_t& next_block) {
  std::vector<Offset<schema::Level>> levels;
  for (const PackLevel& level : layer.levels) {
    if (level.tiles.empty() && layer.content == VectorContent::kNone) continue;
    const auto blocks = uint32_t(blocks_for(level.tiles.size()));
    levels.push_back(
        schema::CreateLevel(builder, int8_t(level.level), next_block, blocks, uint32_t(level.tiles.size())));
    next_block += blocks;
  }
  const auto level_vector = builder.CreateVector(levels);
  const auto name = builder.CreateString(layer.name);
  const auto description = text_or_none(builder, layer.description);
  if (layer.content != VectorContent::kNone)
    return schema::CreateLayer(builder, name, schema::LayerKind::Vector, {}, 1, 0, level_vector, description,
                               schema::VectorContent(uint8_t(layer.content)));
  return schema::CreateLayer(builder, name, schema::LayerKind::Raster, schema::PixelType(uint8_t(layer.format.type)),
                             layer.format.channels, layer.format.nodata, level_vector, description);
}

Offset<schema::Source> encode_source(FlatBufferBuilder& builder, const PackSource& source) {
  const ingest::Source& s = source.source;
  const auto name = builder.CreateString(s.name);
  const auto sha256 = s.sha256.empty() ? 0 : builder.CreateVector(bytes_of_hex(s.sha256));
  const auto date = text_or_none(builder, s.date), licence = text_or_none(builder, s.licence),
             attribution = text_or_none(builder, s.attribution), crs = text_or_none(builder, s.crs),
             datum = text_or_none(builder, s.vertical_datum);
  std::vector<String> names;
  for (const ingest::BandRole role : s.bands) names.push_back(builder.CreateString(ingest::name_of(role)));
  const auto bands = names.empty() ? Offset<flatbuffers::Vector<String>>{} : builder.CreateVector(names);
  return schema::CreateSource(builder, name, schema::SourceRole(uint8_t(source.role)), sha256, date, licence,
                              attribution, crs, datum, bands, s.gsd_m);
}

Offset<schema::Epoch> encode_epoch(FlatBufferBuilder& builder, const PackEpoch& epoch) {
  const auto date = text_or_none(builder, epoch.date);
  return schema::CreateEpoch(builder, date, builder.CreateVector(epoch.sources));
}

Offset<schema::EpochSet> encode_epoch_set(FlatBufferBuilder& builder, const catalog::EpochSet& set) {
  return schema::CreateEpochSet(builder, builder.CreateVector(set));
}

Offset<schema::Parameter> encode_parameter(FlatBufferBuilder& builder,
                                           const std::pair<std::string, std::string>& parameter) {
  const auto name = builder.CreateString(parameter.first), value = builder.CreateString(parameter.second);
  return schema::CreateParameter(builder, name, value);
}

// A raster layer without tiles has no level, and so is none: readers refuse it. A vector layer says that nothing was
// found.
bool has_level(const PackLayer& layer) {
  return layer.content != VectorContent::kNone ||
         std::ranges::any_of(layer.levels, [](const PackLevel& level) { return !level.tiles.empty(); });
}

// Encodes every item by `encode`.
template <typename Items, typename Encode>
auto encode_all(FlatBufferBuilder& builder, const Items& items, Encode encode) {
  std::vector<decltype(encode(builder, *items.begin()))> offsets;
  for (const auto& item : items) offsets.push_back(encode(builder, item));
  return builder.CreateVector(offsets);
}

Offset<schema::Geoid> encode_geoid(FlatBufferBuilder& builder, const std::optional<ingest::GeoidGrid>& geoid) {
  if (!geoid) return {};
  const auto model = builder.CreateString(geoid->model);
  const auto undulation = builder.CreateVector(geoid->undulation_m);
  return schema::CreateGeoid(builder, model, geoid->west_m, geoid->south_m, geoid->spacing_m, uint32_t(geoid->columns),
                             uint32_t(geoid->rows), undulation);
}

}  // namespace

std::vector<uint8_t> encode_manifest(const PackDescription& d, std::span<const catalog::EpochSet> epoch_sets) {
  FlatBufferBuilder builder;
  uint32_t next_block = 0;
  std::vector<Offset<schema::Layer>> layers_with_data;
  for (const PackLayer& layer : d.layers)
    if (has_level(layer)) layers_with_data.push_back(encode_layer(builder, layer, next_block));
  const auto layers = builder.CreateVector(layers_with_data);
  const auto sources = encode_all(builder, d.sources, encode_source);
  const auto parameters = encode_all(builder, d.parameters, encode_parameter);
  const auto epochs = d.epochs.empty() ? 0 : encode_all(builder, d.epochs, encode_epoch);
  const auto sets = epoch_sets.empty() ? 0 : encode_all(builder, epoch_sets, encode_epoch_set);
  const auto geoid = encode_geoid(builder, d.geoid);
  const auto program = text_or_none(builder, d.builder);
  const auto grid = schema::CreateGrid(builder, uint8_t(d.zone.number), d.zone.north);
  const schema::Bounds bounds(d.bounds.west_m, d.bounds.south_m, d.bounds.east_m, d.bounds.north_m);
  schema::FinishManifestBuffer(
      builder,
      schema::CreateManifest(builder, grid, &bounds, layers, sources, geoid, d.plane_height_m,
                             float(d.georegistration_error_m.value_or(-1)), program, parameters, epochs, sets));
  return {builder.GetBufferPointer(), builder.GetBufferPointer() + builder.GetSize()};
}

}  // namespace landfix::exporter
