// GPX 1.0 and 1.1: the route, else the track, else the waypoints. Elevations are above sea level.
#include <fmt/format.h>

#include "tools/mission/formats.h"
#include "tools/mission/lines.h"
#include "tools/mission/route.h"
#include "tools/mission/xml.h"

namespace landfix::mission {
namespace {

Place place_of(const CPLXMLNode* point, const std::string& where, const std::string& file) {
  const auto coordinate = [&](const char* name) {
    return number_of(attribute(point, name).value_or(""), file, where + " " + name);
  };
  Place place{checked_position(file, where, coordinate("lat"), coordinate("lon")), {}};
  if (const auto elevation = child_text(point, "ele")) {
    place.altitude = {number_of(*elevation, file, where + " ele"), AltitudeReference::kSeaLevel};
  }
  return place;
}

/// The points of this name in an element, appended to a line.
void add_points(const CPLXMLNode* parent, const char* name, const std::string& file, Line& line) {
  for (const CPLXMLNode* child = first_element(parent); child; child = next_element(child)) {
    if (local_name(child) != name) continue;
    line.places.push_back(place_of(child, fmt::format("{} {}", name, line.places.size()), file));
  }
}

Line route_of(const CPLXMLNode* element, const std::string& file) {
  Line line{child_text(element, "name").value_or(""), {}, 0, {}};
  add_points(element, "rtept", file, line);
  return line;
}

Line track_of(const CPLXMLNode* element, const std::string& file) {
  Line line{child_text(element, "name").value_or(""), {}, 0, {}};
  for (const CPLXMLNode* child = first_element(element); child; child = next_element(child)) {
    if (local_name(child) == "trkseg") add_points(child, "trkpt", file, line);
  }
  return line;
}

}  // namespace

void read_gpx(const CPLXMLNode* root, Mission& mission) {
  LooseEnds routes, tracks;
  size_t waypoints = 0;
  for (const CPLXMLNode* child = first_element(root); child; child = next_element(child)) {
    const std::string name = local_name(child);
    if (name == "rte") routes.lines.push_back(route_of(child, mission.file));
    if (name == "trk") tracks.lines.push_back(track_of(child, mission.file));
    if (name == "wpt") {
      const Place place = place_of(child, fmt::format("wpt {}", waypoints), mission.file);
      routes.points.push_back({child_text(child, "name").value_or(""), {place}, waypoints++, {}});
    }
  }
  if (!routes.lines.empty() && !tracks.lines.empty()) {
    mission.notes.push_back({0, fmt::format("{} tracks beside the route are not part of it", tracks.lines.size())});
  }
  tracks.points = routes.points;
  const bool by_track = routes.lines.empty() && !tracks.lines.empty();
  take_route(by_track ? tracks : routes, by_track ? "track" : "route", mission);
}

}  // namespace landfix::mission
