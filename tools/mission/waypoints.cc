// "QGC WPL": a header, then a line of twelve tab-separated fields for each item (mavlink.io/en/file_formats).
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>

#include "builder/error.h"
#include "tools/mission/formats.h"
#include "tools/mission/route.h"
#include "tools/mission/waypoint_lines.h"

namespace landfix::mission {
namespace {

[[noreturn]] void refuse(const Mission& mission, size_t line, const std::string& text) {
  throw Error(ExitCode::kBadInput, fmt::format("{}: line {}: {}", mission.file, line, text));
}

double number(const Mission& mission, const WaypointLine& line, size_t field) {
  const std::string_view text = line.fields[field];
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || std::isinf(value)) {
    refuse(
        mission, line.number,
        fmt::format("expected a number in field {}, found \"{}\"; the line is damaged", field + 1, text.substr(0, 40)));
  }
  return value;
}

int integer(const Mission& mission, const WaypointLine& line, size_t field) {
  const double value = number(mission, line, field);
  if (value != std::floor(value) || value < 0 || value > 65535) {
    refuse(mission, line.number,
           fmt::format("expected a whole number in field {}, found {}; the line is damaged", field + 1,
                       line.fields[field].substr(0, 40)));
  }
  return static_cast<int>(value);
}

MissionItem item_of(const Mission& mission, const WaypointLine& line, size_t index) {
  if (line.fields.size() != kWaypointFields) {
    refuse(mission, line.number,
           fmt::format("expected {} fields, found {}; the file is cut off or damaged: save it again", kWaypointFields,
                       line.fields.size()));
  }
  if (static_cast<size_t>(integer(mission, line, 0)) != index) {
    refuse(mission, line.number,
           fmt::format("expected item {}, found {}; a line is missing or was put in by hand: save "
                       "the file again",
                       index, line.fields[0]));
  }
  MissionItem item;
  item.frame = integer(mission, line, 2);
  item.command = integer(mission, line, 3);
  for (size_t i = 0; i < item.params.size(); ++i) item.params[i] = number(mission, line, 4 + i);
  item.item = index;
  item.where = fmt::format("line {}", line.number);
  return item;
}

}  // namespace

void read_waypoints(Mission& mission) {
  const WaypointLines file = split_waypoint_lines(mission.text);
  if (file.header != "QGC WPL 110" && file.header != "QGC WPL 120") {
    refuse(mission, 1,
           fmt::format("expected \"QGC WPL 110\" (or 120), found \"{}\"; save the file in that version",
                       file.header.substr(0, 40)));
  }
  Route route(mission);
  for (size_t index = 0; index < file.lines.size(); ++index) {
    const MissionItem item = item_of(mission, file.lines[index], index);
    // Version 110 has home in item 0 (as QGroundControl and Mission Planner read it), often as 0, 0 where unknown.
    if (index == 0 && file.header == "QGC WPL 110" && item.command == kWaypointCommand) {
      if (item.params[4] == 0 && item.params[5] == 0) continue;
      mission.home = Place{checked_position(mission.file, item.where, item.params[4], item.params[5]), {}};
      // Some programs put their first waypoint here, with its height above home.
      if (item.frame == kGlobalFrame) mission.home->altitude = {item.params[6], AltitudeReference::kSeaLevel};
      continue;
    }
    route.mark(static_cast<long>(index));
    route.add(item);
  }
  route.finish();
}

}  // namespace landfix::mission
