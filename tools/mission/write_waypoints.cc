// Writes "QGC WPL" 110.
#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "builder/error.h"
#include "tools/mission/waypoint_lines.h"
#include "tools/mission/write_formats.h"

namespace landfix::mission {
namespace {

std::string waypoint(size_t index, const Place& place) {
  return fmt::format("{}\t0\t{}\t{}\t0\t0\t0\t0\t{:.9f}\t{:.9f}\t{:.3f}\t1", index,
                     static_cast<int>(frame_for(place.altitude)), static_cast<int>(kWaypointCommand),
                     place.position.latitude_deg, place.position.longitude_deg, place.altitude.m);
}

long whole(std::string_view field) {
  double value = 0;  // "3.00000000" too
  std::from_chars(field.data(), field.data() + field.size(), value);
  return std::lround(value);
}

bool is_jump(const WaypointLine& line) { return whole(line.fields[3]) == kJumpCommand; }

std::string why_fixed(const WaypointLines& file, size_t item) {
  const long command = whole(file.lines[item].fields[3]);
  if (item == 0 && file.header == "QGC WPL 110") return "it is home";
  if (command != kWaypointCommand && command != kSplineCommand) return "it is no plain waypoint";
  for (const WaypointLine& line : file.lines) {
    if (is_jump(line) && whole(line.fields[4]) == static_cast<long>(item)) return "a jump leads to it";
  }
  return "";
}

/// Where each item comes to stand; of those that are taken away, where it would.
std::vector<size_t> new_indices(size_t items, const std::vector<Replacement>& sorted) {
  std::vector<size_t> indices(items + 1);
  size_t index = 0;
  auto next = sorted.begin();
  size_t gone_until = 0;
  for (size_t item = 0; item <= items; ++item) {
    for (; next != sorted.end() && next->first == item; ++next) {
      index += next->path.size();
      gone_until = next->end;
    }
    indices[item] = index;
    if (item >= gone_until) ++index;
  }
  return indices;
}

/// The line with another number of its own and, for a jump, of its target; all other bytes as they were.
std::string renumbered(const WaypointLine& line, size_t index, const std::vector<size_t>& indices) {
  std::string text = std::to_string(index);
  const char* rest = line.fields[0].data() + line.fields[0].size();
  const std::string_view target = line.fields[4];
  const size_t before = is_jump(line) ? static_cast<size_t>(whole(target)) : 0, after = indices[before];
  if (after != before) {
    text.append(rest, target.data()) += std::to_string(after);
    rest = target.data() + target.size();
  }
  return text.append(rest, line.text.data() + line.text.size());
}

}  // namespace

std::string new_waypoints(const std::vector<Place>& path, const NewFile& about) {
  if (!about.home || about.home->altitude.reference != AltitudeReference::kSeaLevel) {
    throw Error(ExitCode::kUsage, "waypoints: expected home with its altitude above sea level, found none");
  }
  const auto& [position, altitude] = *about.home;
  size_t index = 1;
  std::string text = fmt::format("QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t{:.9f}\t{:.9f}\t{:.3f}\t1\n",
                                 position.latitude_deg, position.longitude_deg, altitude.m);
  if (about.speed_mps) {
    text += fmt::format("{}\t0\t{}\t{}\t1\t{:.3f}\t-1\t0\t0\t0\t0\t1\n", index++, static_cast<int>(kMissionFrame),
                        static_cast<int>(kChangeSpeedCommand), *about.speed_mps);
  }
  for (const Place& place : path) text += waypoint(index++, place) + "\n";
  return text;
}

std::string changed_waypoints(const Mission& source, const std::vector<Replacement>& replacements) {
  const WaypointLines file = split_waypoint_lines(source.text);
  const auto sorted =
      checked(replacements, file.lines.size(), source.file, [&](size_t item) { return why_fixed(file, item); });
  if (!sorted.empty() && sorted.front().first == 0) {
    throw Error(ExitCode::kUsage, source.file + ": item 0 is home; nothing can come before it");
  }
  const std::vector<size_t> indices = new_indices(file.lines.size(), sorted);
  std::string text = std::string(file.header) + std::string(file.line_end);
  size_t index = 0, gone_until = 0;
  auto next = sorted.begin();
  for (size_t item = 0; item <= file.lines.size(); ++item) {
    for (; next != sorted.end() && next->first == item; ++next) {
      for (const Place& place : next->path) text += waypoint(index++, place) + std::string(file.line_end);
      gone_until = next->end;
    }
    if (item == file.lines.size() || item < gone_until) continue;
    text += renumbered(file.lines[item], index, indices) + std::string(file.line_end);
    ++index;
  }
  return text;
}

}  // namespace landfix::mission
