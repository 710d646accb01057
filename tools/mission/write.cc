#include "tools/mission/write.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "builder/error.h"
#include "tools/mission/json.h"
#include "tools/mission/write_formats.h"

namespace landfix::mission {
namespace {

[[noreturn]] void refuse(const std::string& text) { throw Error(ExitCode::kUsage, text); }

std::string escaped(const std::string& text) {
  const std::unique_ptr<char, decltype(&VSIFree)> xml(CPLEscapeString(text.c_str(), -1, CPLES_XML), VSIFree);
  return xml.get();
}

std::string new_gpx(const std::vector<Place>& path, const NewFile& about) {
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<gpx version=\"1.1\" creator=\"landfix\" xmlns=\"http://www.topografix.com/GPX/1/1\">\n"
      "  <rte>\n    <name>{}</name>\n",
      escaped(about.name));
  for (const Place& place : path) {
    const Altitude& altitude = place.altitude;
    if (altitude.reference != AltitudeReference::kSeaLevel && altitude.reference != AltitudeReference::kNone) {
      refuse(fmt::format("GPX: expected altitudes above sea level, found {}; convert them first",
                         to_string(altitude.reference)));
    }
    text += fmt::format("    <rtept lat=\"{:.9f}\" lon=\"{:.9f}\">", place.position.latitude_deg,
                        place.position.longitude_deg);
    if (altitude.reference == AltitudeReference::kSeaLevel) text += fmt::format("<ele>{:.3f}</ele>", altitude.m);
    text += "</rtept>\n";
  }
  return text + "  </rte>\n</gpx>\n";
}

std::string new_geojson(const std::vector<Place>& path, const NewFile& about) {
  Json coordinates = Json::array();
  const AltitudeReference reference = path.front().altitude.reference;
  for (const Place& place : path) {
    if (place.altitude.reference != reference) {
      refuse(fmt::format("GeoJSON: expected one altitude reference, found {} and {}; convert them first",
                         to_string(reference), to_string(place.altitude.reference)));
    }
    Json tuple = {place.position.longitude_deg, place.position.latitude_deg};
    if (reference != AltitudeReference::kNone) tuple.push_back(place.altitude.m);
    coordinates.push_back(tuple);
  }
  // A line has two points or more (RFC 7946, 3.1.4).
  Json geometry = {{"type", "LineString"}, {"coordinates", coordinates}};
  if (path.size() == 1) geometry = {{"type", "Point"}, {"coordinates", coordinates[0]}};
  Json properties = {{"name", about.name}};
  if (reference != AltitudeReference::kNone) properties["altitude_reference"] = to_string(reference);
  if (about.speed_mps) properties["speed_mps"] = *about.speed_mps;
  const Json feature = {{"type", "Feature"}, {"properties", properties}, {"geometry", geometry}};
  const Json collection = {{"type", "FeatureCollection"}, {"features", Json::array({feature})}};
  return collection.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

Frame frame_for(const Altitude& altitude) {
  switch (altitude.reference) {
    case AltitudeReference::kSeaLevel:
      return kGlobalFrame;
    case AltitudeReference::kHome:
      return kHomeFrame;
    case AltitudeReference::kTerrain:
      return kTerrainFrame;
    case AltitudeReference::kEllipsoid:
    case AltitudeReference::kNone:
      break;
  }
  refuse(fmt::format("mission items: expected altitudes above sea level, home or terrain, found {}; convert them first",
                     to_string(altitude.reference)));
}

std::vector<Replacement> checked(std::vector<Replacement> replacements, size_t items, const std::string& file,
                                 const std::function<std::string(size_t)>& fixed) {
  std::stable_sort(replacements.begin(), replacements.end(),
                   [](const Replacement& a, const Replacement& b) { return a.first < b.first; });
  size_t free_from = 0;
  for (const Replacement& replacement : replacements) {
    const auto& [first, end, path] = replacement;
    if (first > end || end > items || first < free_from) {
      refuse(fmt::format("{}: expected replacements that lie apart within {} items, found {} to {}", file, items, first,
                         end));
    }
    for (size_t item = first; item < end; ++item) {
      const std::string why = fixed(item);
      if (!why.empty()) refuse(fmt::format("{}: item {} cannot be replaced: {}", file, item, why));
    }
    free_from = end;
  }
  return replacements;
}

std::string new_mission(Format format, const std::vector<Place>& path, const NewFile& about) {
  if (path.empty()) refuse("mission: expected a path of at least one place, found none");
  switch (format) {
    case Format::kPlan:
      return new_plan(path, about);
    case Format::kWaypoints:
      return new_waypoints(path, about);
    case Format::kGpx:
      return new_gpx(path, about);
    case Format::kGeoJson:
      return new_geojson(path, about);
    case Format::kKml:
      break;
  }
  refuse("mission: KML is read but not written; write .plan, .waypoints, .gpx or .geojson");
}

std::string changed_mission(const Mission& source, const std::vector<Replacement>& replacements) {
  if (source.format == Format::kPlan) return changed_plan(source, replacements);
  if (source.format == Format::kWaypoints) return changed_waypoints(source, replacements);
  refuse(source.file + ": holds a bare line, in which no items can be replaced; write a new file");
}

Format format_for(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension().string();
  if (extension == ".plan") return Format::kPlan;
  if (extension == ".waypoints" || extension == ".txt") return Format::kWaypoints;
  if (extension == ".gpx") return Format::kGpx;
  if (extension == ".geojson" || extension == ".json") return Format::kGeoJson;
  if (extension == ".kml") return Format::kKml;
  refuse(fmt::format("{}: expected a name that ends in .plan, .waypoints, .gpx or .geojson, found \"{}\"", path,
                     extension));
}

}  // namespace landfix::mission
