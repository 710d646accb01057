// The lines of a "QGC WPL" file, for reading it and for writing it back unchanged but in places.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace landfix::mission {

constexpr size_t kWaypointFields = 12;

struct WaypointLine {
  std::string_view text;  ///< without its end
  std::vector<std::string_view> fields;
  size_t number = 0;  ///< in the file, from 1
};

struct WaypointLines {
  std::string_view header;
  std::string_view line_end;  ///< "\n" or "\r\n", by the first line
  std::vector<WaypointLine> lines;
};

/// Splits at tabs and blanks; empty lines are left out. The result points into `text`.
WaypointLines split_waypoint_lines(std::string_view text);

}  // namespace landfix::mission
