#include "tools/mission/waypoint_lines.h"

#include <algorithm>

namespace landfix::mission {
namespace {

std::vector<std::string_view> fields_of(std::string_view line) {
  constexpr const char* kBlanks = " \t";
  std::vector<std::string_view> fields;
  for (size_t begin = line.find_first_not_of(kBlanks); begin != std::string_view::npos;) {
    const size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
    fields.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBlanks, end);
  }
  return fields;
}

std::string_view without_blanks_at_end(std::string_view line) {
  const size_t last = line.find_last_not_of(" \t\r");
  return line.substr(0, last == std::string_view::npos ? 0 : last + 1);
}

}  // namespace

WaypointLines split_waypoint_lines(std::string_view text) {
  WaypointLines file;
  file.line_end = "\n";
  size_t number = 0;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = without_blanks_at_end(text.substr(begin, end - begin));
    ++number;
    if (file.header.empty()) {
      file.header = line;
      if (end > begin && end < text.size() && text[end - 1] == '\r') file.line_end = "\r\n";
    } else if (!line.empty()) {
      file.lines.push_back({line, fields_of(line), number});
    }
    begin = end + 1;
  }
  return file;
}

}  // namespace landfix::mission
