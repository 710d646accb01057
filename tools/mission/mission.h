// A ground station's mission as a route: where it leads, how high, how fast, and which item of the file says so.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace landfix::mission {

enum class Format {
  kPlan,       ///< QGroundControl's .plan
  kWaypoints,  ///< "QGC WPL" (.waypoints), of Mission Planner and many others
  kGpx,
  kGeoJson,
  kKml,
};

/// What an altitude is counted from. Nothing here converts: that takes the heights of a map.
enum class AltitudeReference {
  kNone,       ///< the file gives no altitude
  kEllipsoid,  ///< WGS84
  kSeaLevel,   ///< the geoid
  kHome,       ///< the place of take-off
  kTerrain,    ///< the ground below
};

/// "ellipsoid", "sea_level", "home", "terrain", "none": as GeoJSON properties and messages have it.
const char* to_string(AltitudeReference reference);

struct Position {
  double latitude_deg = 0, longitude_deg = 0;
  bool operator==(const Position&) const = default;
};

struct Altitude {
  double m = 0;
  AltitudeReference reference = AltitudeReference::kNone;
  bool operator==(const Altitude&) const = default;
};

struct Place {
  Position position;
  Altitude altitude;
  bool operator==(const Place&) const = default;
};

enum class Action { kPass, kLoiter, kTakeoff, kLand, kReturn };

struct Speed {
  double mps = 0;
  bool through_air = false;  ///< airspeed, else ground speed
};

struct Waypoint {
  Place place;
  Action action = Action::kPass;
  bool implied = false;        ///< the item has no position of its own: that of the waypoint before, or home
  double hold_s = 0;           ///< time spent here; infinite for loitering without end
  double turns = 0;            ///< circles flown here
  double radius_m = 0;         ///< of these circles, positive clockwise; 0: as the vehicle is set up
  std::optional<Speed> speed;  ///< commanded for the leg that leads here, and from then on
  size_t item = 0;             ///< which item of the file: see Mission
  size_t part = 0;             ///< which point within the item, where it has several
};

/// "Go on from there instead", so many times.
struct Jump {
  static constexpr int kForever = -1;
  size_t at = 0;       ///< waypoints before it in the file
  size_t to = 0;       ///< waypoints before its target
  size_t to_jump = 0;  ///< jumps before its target
  int repeats = 0;
  size_t item = 0;
};

/// A region to stay in (inclusion) or out of: a polygon, or a circle where the polygon is empty.
struct Fence {
  bool inclusion = true;
  std::vector<Position> polygon;
  Position centre;
  double radius_m = 0;
};

/// Something in the file that the route does not show, and why; for reports.
struct Note {
  size_t item = 0;
  std::string text;
};

/// What a file says. `item` counts from 0: entries of mission.items (.plan), lines after the header (WPL), features
/// (GeoJSON), placemarks (KML), waypoints (GPX, where a route or track is item 0).
struct Mission {
  std::string file;  ///< name, for messages
  Format format = Format::kPlan;
  std::string text;  ///< the file's bytes: what is written back starts from them
  std::vector<Waypoint> waypoints;
  std::vector<Jump> jumps;
  std::vector<Fence> fences;
  std::vector<Place> rally_points;
  std::optional<Place> home;
  std::optional<double> cruise_speed_mps, hover_speed_mps;
  std::vector<Note> notes;
};

/// The order in which waypoints are flown.
struct Flight {
  std::vector<size_t> waypoints;  ///< indices into Mission::waypoints
  bool endless = false;           ///< a jump is taken for ever; it is followed once here, so that each leg occurs
};

/// Follows the jumps, each as often as it says (counters are not reset by outer loops, as autopilots do it). Ends at a
/// return or at loitering without end, as nothing after these is flown. Throws Error (kBadInput) where that makes more
/// than 100 000 waypoints.
Flight flown(const Mission& mission);

}  // namespace landfix::mission
