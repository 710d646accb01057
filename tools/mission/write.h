// Writes paths as missions that ground stations open (docs/missions.md). All functions return the text of a file;
// saving it is tools/common/files.h's write_text.
#pragma once

#include <string>
#include <vector>

#include "tools/mission/mission.h"

namespace landfix::mission {

/// What a new file says besides its path.
struct NewFile {
  std::string name = "route";
  std::optional<Place> home;        ///< altitude above sea level; .plan and WPL need it
  std::optional<double> speed_mps;  ///< over ground; commanded before the first waypoint (GeoJSON: a property)
  int firmware_type = 12;           ///< .plan: MAV_AUTOPILOT; 12 is PX4, 3 ArduPilot
  int vehicle_type = 2;             ///< .plan: MAV_TYPE; 1 fixed wing, 2 quadrotor
};

/// A file that holds this path and nothing else, each place a waypoint to pass. Altitudes keep their reference, which
/// the format must have: .plan and WPL sea level, home and terrain; GPX sea level or none; GeoJSON any, one for the
/// whole path. Throws Error (kUsage) for others, for KML, an empty path or a missing home.
std::string new_mission(Format format, const std::vector<Place>& path, const NewFile& about);

/// Waypoints in place of the items [first, end) of a file, or before item `first` where there are none.
struct Replacement {
  size_t first = 0, end = 0;
  std::vector<Place> path;
};

/// The file that a .plan or WPL mission was read from, with replacements. All else keeps its value: other items,
/// complex items, fences, rally points, keys of no meaning here; WPL keeps its bytes but for the numbers of items and
/// the targets of jumps, which move along. Replacements may be in any order and must not overlap. Throws Error (kUsage)
/// where they do, lie outside, touch home, or would take away anything but plain waypoints that no jump leads to.
std::string changed_mission(const Mission& source, const std::vector<Replacement>& replacements);

/// The format that the extension of a file's name stands for (.plan, .waypoints or .txt, .gpx, .geojson or .json,
/// .kml). Throws Error (kUsage) for another.
Format format_for(const std::string& path);

}  // namespace landfix::mission
