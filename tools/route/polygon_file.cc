#include "tools/route/polygon_file.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "builder/error.h"
#include "tools/mission/json.h"

namespace landfix::route {
namespace {

using mission::JsonNode;

constexpr size_t kFewestPositions = 4;  ///< of a ring, whose last is its first

Polygon ring_of(const JsonNode& ring, const tiles::Zone& zone) {
  if (ring.size() < kFewestPositions) ring.refuse("a ring of at least four positions");
  Polygon polygon;
  for (size_t i = 0; i + 1 < ring.size(); ++i) {
    constexpr double kRadians = M_PI / 180;
    const JsonNode position = ring.at(i);
    const auto place =
        tiles::grid_from_geodetic(zone, {position.at(1).number() * kRadians, position.at(0).number() * kRadians});
    if (!place) {
      throw Error(ExitCode::kNoData,
                  fmt::format("{}: {}: expected a place in reach of the map's zone {}; choose the map of "
                              "this area",
                              ring.file(), position.path(), zone.number));
    }
    polygon.push_back({place->east_m, place->north_m});
  }
  return polygon;
}

void collect(const JsonNode& node, const tiles::Zone& zone, std::vector<Polygon>& found) {
  const std::string type = node.at("type").text();
  if (type == "FeatureCollection" || type == "GeometryCollection") {
    const JsonNode list = node.at(type == "FeatureCollection" ? "features" : "geometries");
    for (size_t i = 0; i < list.size(); ++i) collect(list.at(i), zone, found);
  } else if (type == "Feature") {
    if (const auto geometry = node.find("geometry")) collect(*geometry, zone, found);
  } else if (type == "Polygon") {
    found.push_back(ring_of(node.at("coordinates").at(0), zone));
  } else if (type == "MultiPolygon") {
    const JsonNode list = node.at("coordinates");
    for (size_t i = 0; i < list.size(); ++i) found.push_back(ring_of(list.at(i).at(0), zone));
  }
}

}  // namespace

std::vector<Polygon> parse_polygons(const std::string& text, const std::string& name, const tiles::Zone& zone) {
  const mission::JsonDocument document(text, name);
  std::vector<Polygon> found;
  collect(document.root(), zone, found);
  if (found.empty()) throw Error(ExitCode::kBadInput, name + ": expected polygons, found none");
  return found;
}

std::vector<Polygon> read_polygons(const std::string& path, const tiles::Zone& zone) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  text << file.rdbuf();
  if (!file || text.str().empty())
    throw Error(ExitCode::kIo, path + ": expected a GeoJSON file with polygons, found nothing to read; check the name");
  return parse_polygons(text.str(), path, zone);
}

}  // namespace landfix::route
