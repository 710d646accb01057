#include "tools/common/manifest_json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "builder/hex.h"
#include "tools/common/map_features.h"
#include "tools/common/open_pack.h"

namespace landfix::tools {
namespace {

using nlohmann::ordered_json;

ordered_json text_or_null(const char* text) { return *text ? ordered_json(text) : ordered_json(nullptr); }

ordered_json bounds_json(const Pack& pack, const lf_info& info) {
  ordered_json b{
      {"west_m", info.west_m}, {"south_m", info.south_m}, {"east_m", info.east_m}, {"north_m", info.north_m}};
  double west = 180, south = 90, east = -180, north = -90;
  for (const double e : {info.west_m, info.east_m})
    for (const double n : {info.south_m, info.north_m}) {
      const auto p = pack.geodetic_from_grid(e, n);
      if (!p) continue;
      const double longitude = p->longitude_rad * 180 / std::numbers::pi,
                   latitude = p->latitude_rad * 180 / std::numbers::pi;
      west = std::min(west, longitude), east = std::max(east, longitude);
      south = std::min(south, latitude), north = std::max(north, latitude);
    }
  b["west_deg"] = west, b["south_deg"] = south, b["east_deg"] = east, b["north_deg"] = north;
  return b;
}

const char* name_of(uint8_t pixel_type) {
  switch (pixel_type) {
    case LF_U8:
      return "u8";
    case LF_I16:
      return "i16";
    case LF_BIT:
      return "bit";
    case LF_LANDMARKS:
      return "landmarks";
    case LF_ROADS:
      return "roads";
  }
  return "unknown";
}

// What a vector layer holds; null where it is damaged.
ordered_json features_json(const Pack& pack, const lf_layer_info& layer) try {
  const FeatureCounts counts = count_features(pack, layer, "");
  if (layer.pixel_type == LF_ROADS)
    return {{"roads_km", std::round(counts.roads_km * 1000) / 1000}, {"intersections", counts.intersections}};
  ordered_json out = ordered_json::object();
  for (size_t c = 0; c < kLandmarkStyles.size(); ++c) out[kLandmarkStyles[c].name] = counts.of_class[c];
  return out;
} catch (const Error&) {
  return nullptr;
}

ordered_json layer_json(const Pack& pack, uint32_t index) {
  const lf_layer_info layer = *pack.layer(index);
  ordered_json levels = ordered_json::array();
  for (uint32_t i = 0; i < layer.level_count; ++i) {
    const lf_level_info level = *pack.level(index, i);
    levels.push_back({{"level", level.level}, {"gsd_m", level.gsd_m}, {"tiles", level.tile_count}});
  }
  ordered_json out{
      {"name", layer.name},         {"description", layer.description}, {"pixel_type", name_of(layer.pixel_type)},
      {"channels", layer.channels}, {"nodata", layer.nodata},           {"levels", levels}};
  if (layer.pixel_type == LF_LANDMARKS || layer.pixel_type == LF_ROADS) out["features"] = features_json(pack, layer);
  return out;
}

ordered_json source_json(const Pack& pack, uint32_t index) {
  constexpr const char* kRoles[] = {"image", "elevation", "vector"};
  const lf_source_info s = *pack.source(index);
  return {{"name", s.name},
          {"role", s.role < 3 ? kRoles[s.role] : "unknown"},
          {"capture_date", text_or_null(s.capture_date)},
          {"gsd_m", s.gsd_m},
          {"crs", text_or_null(s.crs)},
          {"vertical_datum", text_or_null(s.vertical_datum)},
          {"licence", text_or_null(s.licence)},
          {"attribution", text_or_null(s.attribution)},
          {"sha256", hex(s.sha256)}};
}

// The images of a date by their place in the list of sources.
ordered_json epoch_json(const Pack& pack, uint32_t index) {
  const lf_epoch_info e = *pack.epoch(index);
  return {{"date", text_or_null(e.date)}, {"sources", std::vector<uint16_t>(e.sources, e.sources + e.source_count)}};
}

}  // namespace

tiles::Zone zone_of(const Pack& pack) {
  const lf_info info = pack.info();
  return {info.zone, info.north != 0};
}

std::string zone_name(const tiles::Zone& zone) {
  if (zone.number == 0) return zone.north ? "UPS north" : "UPS south";
  return std::to_string(zone.number) + (zone.north ? "N" : "S");
}

ordered_json manifest_json(const Pack& pack) {
  const lf_info info = pack.info();
  const tiles::Zone zone = zone_of(pack);
  ordered_json layers = ordered_json::array(), sources = ordered_json::array(), epochs = ordered_json::array(),
               parameters = ordered_json::object();
  for (uint32_t i = 0; i < info.layer_count; ++i) layers.push_back(layer_json(pack, i));
  for (uint32_t i = 0; i < info.source_count; ++i) sources.push_back(source_json(pack, i));
  for (uint32_t i = 0; i < info.epoch_count; ++i) epochs.push_back(epoch_json(pack, i));
  for (uint32_t i = 0; i < info.parameter_count; ++i) {
    const char *name, *value;
    check(lf_get_parameter(pack.c_pack(), i, &name, &value), "parameter");
    parameters[name] = value;
  }
  return {{"format", std::to_string(info.version_major) + "." + std::to_string(info.version_minor)},
          {"builder", info.builder},
          {"file_length", info.file_length},
          {"root", hex(info.root)},
          {"public_key", info.is_signed ? ordered_json(hex(info.public_key)) : ordered_json(nullptr)},
          {"zone", zone_name(zone)},
          {"epsg", tiles::epsg_code(zone)},
          {"bounds", bounds_json(pack, info)},
          {"has_heights", info.has_heights != 0},
          {"plane_height_m", info.plane_height_m},
          {"georegistration_error_m",
           info.georegistration_error_m < 0 ? ordered_json(nullptr) : ordered_json(info.georegistration_error_m)},
          {"layers", layers},
          {"sources", sources},
          {"epochs", epochs},
          {"parameters", parameters}};
}

}  // namespace landfix::tools
