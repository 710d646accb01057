#include "tools/mission/lines.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "builder/error.h"
#include "tools/mission/route.h"

namespace landfix::mission {
namespace {

std::string names_of(const std::vector<Line>& lines) {
  constexpr size_t kShown = 5;
  std::string names;
  for (size_t i = 0; i < lines.size() && i < kShown; ++i) {
    names += fmt::format("{}\"{}\"", i ? ", " : "", lines[i].name.substr(0, 40));
  }
  return lines.size() > kShown ? names + ", …" : names;
}

}  // namespace

void take_route(const LooseEnds& found, const std::string& kind, Mission& mission) {
  if (found.lines.size() > 1) {
    throw Error(ExitCode::kBadInput, fmt::format("{}: expected one {}, found {} ({}); keep the one that is to be flown",
                                                 mission.file, kind, found.lines.size(), names_of(found.lines)));
  }
  if (!found.lines.empty() && !found.points.empty()) {
    mission.notes.push_back(
        {0, fmt::format("{} points beside the {} are not part of the route", found.points.size(), kind)});
  }
  Route route(mission);
  for (const Line& line : found.lines.empty() ? found.points : found.lines) {
    const size_t first = mission.waypoints.size();
    for (size_t part = 0; part < line.places.size(); ++part) route.add(line.places[part], line.item, part);
    if (line.speed && mission.waypoints.size() > first) mission.waypoints[first].speed = line.speed;
  }
}

double number_of(const std::string& text, const std::string& file, const std::string& where) {
  constexpr const char* kBlanks = " \t\r\n";
  const size_t first = text.find_first_not_of(kBlanks), last = text.find_last_not_of(kBlanks);
  const char* const begin = text.data() + (first == std::string::npos ? 0 : first);
  const char* const end = text.data() + (last == std::string::npos ? 0 : last + 1);
  double value = 0;
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) {
    throw Error(ExitCode::kBadInput, fmt::format("{}: {}: expected a number, found \"{}\"; the file is damaged", file,
                                                 where, text.substr(0, 40)));
  }
  return value;
}

}  // namespace landfix::mission
