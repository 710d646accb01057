// GeoJSON (RFC 7946): the line, else the points, in their order. Altitudes are above the ellipsoid (section 3.1.1)
// unless the property "altitude_reference" says otherwise.
#include <fmt/format.h>

#include <cmath>

#include "tools/mission/formats.h"
#include "tools/mission/json.h"
#include "tools/mission/lines.h"
#include "tools/mission/route.h"

namespace landfix::mission {
namespace {

struct Walk {
  LooseEnds found;
  size_t item = 0;
  size_t polygons = 0;
  std::string name;
  AltitudeReference reference = AltitudeReference::kEllipsoid;
  std::optional<Speed> speed;
};

AltitudeReference named_reference(const JsonNode& node) {
  using enum AltitudeReference;
  for (const AltitudeReference reference : {kEllipsoid, kSeaLevel, kHome, kTerrain}) {
    if (node.text() == to_string(reference)) return reference;
  }
  node.refuse("ellipsoid, sea_level, home or terrain");
}

Place place_of(const JsonNode& tuple, AltitudeReference reference) {
  Place place{checked_position(tuple.file(), tuple.path(), tuple.at(1).number(), tuple.at(0).number()), {}};
  if (tuple.size() > 2) place.altitude = {tuple.at(2).number(), reference};
  return place;
}

void append(const JsonNode& tuples, const Walk& walk, Line& line) {
  for (size_t i = 0; i < tuples.size(); ++i) line.places.push_back(place_of(tuples.at(i), walk.reference));
}

void visit_geometry(const JsonNode& geometry, Walk& walk) {
  const std::string& type = geometry.at("type").text();
  Line line{walk.name, {}, walk.item, walk.speed};
  if (type == "GeometryCollection") {
    const JsonNode members = geometry.at("geometries");
    for (size_t i = 0; i < members.size(); ++i) visit_geometry(members.at(i), walk);
    return;
  }
  const JsonNode coordinates = geometry.at("coordinates");
  if (type == "LineString") {
    append(coordinates, walk, line);
    walk.found.lines.push_back(line);
  } else if (type == "MultiLineString") {
    for (size_t i = 0; i < coordinates.size(); ++i) append(coordinates.at(i), walk, line);
    walk.found.lines.push_back(line);
  } else if (type == "Point") {
    line.places = {place_of(coordinates, walk.reference)};
    walk.found.points.push_back(line);
  } else if (type == "MultiPoint") {
    append(coordinates, walk, line);
    walk.found.points.push_back(line);
  } else if (type == "Polygon" || type == "MultiPolygon") {
    ++walk.polygons;
  } else {
    geometry.at("type").refuse("a type of RFC 7946");
  }
}

void visit_feature(const JsonNode& feature, Walk& walk) {
  walk.name.clear();
  walk.reference = AltitudeReference::kEllipsoid;
  walk.speed.reset();
  if (const auto properties = feature.find("properties")) {
    // The name is for people: another type is no reason to refuse the file.
    if (const auto name = properties->find("name"); name && name->is_text()) walk.name = name->text();
    if (const auto reference = properties->find("altitude_reference")) walk.reference = named_reference(*reference);
    if (const auto speed = properties->find("speed_mps")) {
      if (!(speed->number() > 0)) speed->refuse("a speed above 0");
      walk.speed = Speed{speed->number(), false};
    }
  }
  if (const auto geometry = feature.find("geometry")) visit_geometry(*geometry, walk);
}

/// Files of before RFC 7946 could be in any system; longitude and latitude on WGS84 has these names.
void refuse_other_crs(const JsonNode& root) {
  const auto crs = root.find("crs");
  const auto properties = crs ? crs->find("properties") : std::nullopt;
  const auto name = properties ? properties->find("name") : std::nullopt;
  if (!name) return;
  const std::string& text = name->text();
  if (text.find("CRS84") == std::string::npos && text.find("4326") == std::string::npos) {
    name->refuse("longitude and latitude on WGS84", "\"" + text.substr(0, 60) + "\"",
                 "reproject the file to EPSG:4326");
  }
}

}  // namespace

void read_geojson(const JsonNode& root, Mission& mission) {
  refuse_other_crs(root);
  Walk walk;
  const std::string& type = root.at("type").text();
  if (type == "FeatureCollection") {
    const JsonNode features = root.at("features");
    for (walk.item = 0; walk.item < features.size(); ++walk.item) visit_feature(features.at(walk.item), walk);
  } else if (type == "Feature") {
    visit_feature(root, walk);
  } else {
    visit_geometry(root, walk);
  }
  if (walk.polygons > 0)
    mission.notes.push_back({0, fmt::format("{} polygons are not part of the route", walk.polygons)});
  take_route(walk.found, "line", mission);
}

}  // namespace landfix::mission
