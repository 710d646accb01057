// KML 2.2 with Google's extensions: the line (LineString, LinearRing, gx:Track), else the points, in their order.
#include <fmt/format.h>

#include <sstream>

#include "builder/error.h"
#include "tools/mission/formats.h"
#include "tools/mission/lines.h"
#include "tools/mission/route.h"
#include "tools/mission/xml.h"

namespace landfix::mission {
namespace {

constexpr int kMaxDepth = 64;

struct Walk {
  Mission& mission;
  LooseEnds found;
  size_t placemarks = 0;
  size_t polygons = 0;
  std::string name;  ///< of the placemark
};

/// The OGC's KML 2.3, 9.20: absolute is above sea level; without a mode, altitudes are to be ignored.
AltitudeReference reference_of(const CPLXMLNode* geometry) {
  const std::string mode = child_text(geometry, "altitudeMode").value_or("clampToGround");
  if (mode == "absolute") return AltitudeReference::kSeaLevel;
  if (mode == "relativeToGround") return AltitudeReference::kTerrain;
  return AltitudeReference::kNone;
}

/// Two or three numbers with this character between them.
Place place_of(const std::string& tuple, char separator, AltitudeReference reference, const std::string& where,
               const std::string& file) {
  std::istringstream fields(tuple);
  std::string field;
  std::vector<double> numbers;
  while (std::getline(fields, field, separator)) numbers.push_back(number_of(field, file, where));
  if (numbers.size() < 2 || numbers.size() > 3) {
    throw Error(ExitCode::kBadInput,
                fmt::format("{}: {}: expected longitude, latitude and perhaps altitude, found \"{}\"; "
                            "the file is damaged: export it again",
                            file, where, tuple.substr(0, 40)));
  }
  Place place{checked_position(file, where, numbers[1], numbers[0]), {}};
  if (numbers.size() == 3 && reference != AltitudeReference::kNone) place.altitude = {numbers[2], reference};
  return place;
}

std::string where_of(const Walk& walk, size_t point) {
  return fmt::format("placemark {} \"{}\", point {}", walk.placemarks, walk.name.substr(0, 40), point);
}

/// <coordinates>: tuples with commas, separated by white space.
std::vector<Place> coordinates_of(const CPLXMLNode* geometry, const Walk& walk) {
  std::vector<Place> places;
  std::istringstream tuples(child_text(geometry, "coordinates").value_or(""));
  const AltitudeReference reference = reference_of(geometry);
  for (std::string tuple; tuples >> tuple;) {
    places.push_back(place_of(tuple, ',', reference, where_of(walk, places.size()), walk.mission.file));
  }
  return places;
}

/// <gx:Track>: one <gx:coord> with blanks for each point.
std::vector<Place> track_of(const CPLXMLNode* track, const Walk& walk) {
  std::vector<Place> places;
  const AltitudeReference reference = reference_of(track);
  for (const CPLXMLNode* child = first_element(track); child; child = next_element(child)) {
    if (local_name(child) != "coord") continue;
    places.push_back(place_of(text_of(child), ' ', reference, where_of(walk, places.size()), walk.mission.file));
  }
  return places;
}

void visit(const CPLXMLNode* parent, int depth, Walk& walk) {
  if (depth > kMaxDepth) {
    throw Error(ExitCode::kBadInput,
                fmt::format("{}: expected at most {} levels of folders, found more; export it again", walk.mission.file,
                            kMaxDepth));
  }
  for (const CPLXMLNode* child = first_element(parent); child; child = next_element(child)) {
    const std::string name = local_name(child);
    if (name == "Placemark") {
      walk.name = child_text(child, "name").value_or("");
      visit(child, depth + 1, walk);
      ++walk.placemarks;
    } else if (name == "LineString" || name == "LinearRing") {
      walk.found.lines.push_back({walk.name, coordinates_of(child, walk), walk.placemarks, {}});
    } else if (name == "Track") {
      walk.found.lines.push_back({walk.name, track_of(child, walk), walk.placemarks, {}});
    } else if (name == "Point") {
      walk.found.points.push_back({walk.name, coordinates_of(child, walk), walk.placemarks, {}});
    } else if (name == "Polygon") {
      ++walk.polygons;
    } else if (name == "Document" || name == "Folder" || name == "MultiGeometry" || name == "MultiTrack") {
      visit(child, depth + 1, walk);
    }
  }
}

}  // namespace

void read_kml(const CPLXMLNode* root, Mission& mission) {
  Walk walk{mission, {}, 0, 0, ""};
  visit(root, 0, walk);
  if (walk.polygons > 0)
    mission.notes.push_back({0, fmt::format("{} polygons are not part of the route", walk.polygons)});
  take_route(walk.found, "line", mission);
}

}  // namespace landfix::mission
