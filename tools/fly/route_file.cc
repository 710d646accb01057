#include "tools/fly/route_file.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "builder/error.h"

namespace landfix::fly {
namespace {

using Degrees = std::pair<double, double>;  // longitude, latitude

std::string contents_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) throw Error(ExitCode::kIo, file.string() + ": the route cannot be read; check name and permissions");
  return text.str();
}

/// The coordinates of the first LineString in a GeoJSON object of any kind; null where there is none.
nlohmann::json first_line_string(const nlohmann::json& object) {
  const std::string type = object.value("type", "");
  if (type == "LineString") return object.at("coordinates");
  if (type == "Feature") return first_line_string(object.at("geometry"));
  const char* members = type == "FeatureCollection"    ? "features"
                        : type == "GeometryCollection" ? "geometries"
                                                       : nullptr;
  if (!members) return nullptr;
  for (const auto& member : object.at(members)) {
    if (auto found = first_line_string(member); !found.is_null()) return found;
  }
  return nullptr;
}

std::vector<Degrees> from_geojson(const std::string& text, const std::string& name) {
  std::vector<Degrees> points;
  try {
    const nlohmann::json line = first_line_string(nlohmann::json::parse(text));
    for (const auto& point : line) points.emplace_back(point.at(0).get<double>(), point.at(1).get<double>());
  } catch (const nlohmann::json::exception& e) {
    throw Error(ExitCode::kBadInput, fmt::format("{}: expected GeoJSON with a LineString, found: {}", name, e.what()));
  }
  return points;
}

/// "lon,lat[,...]" without regard to the locale.
std::optional<Degrees> parse_line(const std::string& line) {
  const char *begin = line.data() + std::min(line.find_first_not_of(" \t"), line.size()),
             *end = line.data() + line.size();
  Degrees point;
  const auto longitude = std::from_chars(begin, end, point.first);
  if (longitude.ec != std::errc() || longitude.ptr == end || *longitude.ptr != ',') return std::nullopt;
  const char* second = longitude.ptr + 1;
  while (second != end && *second == ' ') ++second;
  if (std::from_chars(second, end, point.second).ec != std::errc()) return std::nullopt;
  return point;
}

std::vector<Degrees> from_csv(const std::string& text, const std::string& name) {
  std::vector<Degrees> points;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
    const auto point = parse_line(line);
    if (point) {
      points.push_back(*point);
    } else if (!points.empty() || number > 1) {
      throw Error(ExitCode::kBadInput,
                  fmt::format("{}:{}: expected \"longitude,latitude\" in degrees, found \"{}\"", name, number, line));
    }
  }
  return points;
}

}  // namespace

std::vector<Eigen::Vector2d> read_route(const std::filesystem::path& file, const tiles::Zone& zone) {
  const std::string name = file.string(), text = contents_of(file);
  const bool geojson = file.extension() == ".json" || file.extension() == ".geojson";
  std::vector<Eigen::Vector2d> points;
  for (const auto& [longitude, latitude] : geojson ? from_geojson(text, name) : from_csv(text, name)) {
    const auto place = tiles::grid_from_geodetic(zone, {latitude * M_PI / 180, longitude * M_PI / 180});
    if (!place) {
      throw Error(ExitCode::kBadInput,
                  fmt::format("{}: longitude {} latitude {} does not lie on the grid of the map's zone; the order is "
                              "longitude, latitude, in degrees",
                              name, longitude, latitude));
    }
    points.emplace_back(place->east_m, place->north_m);
  }
  if (points.size() < 2) {
    throw Error(ExitCode::kBadInput,
                fmt::format("{}: expected a route of at least two points, found {}", name, points.size()));
  }
  return points;
}

}  // namespace landfix::fly
