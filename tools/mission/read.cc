#include "tools/mission/read.h"

#include <fmt/format.h>

#include <fstream>
#include <sstream>

#include "builder/error.h"
#include "tools/mission/formats.h"
#include "tools/mission/json.h"
#include "tools/mission/xml.h"

namespace landfix::mission {
namespace {

// Fifty times what the longest surveys take; a limit for files that are something else.
constexpr size_t kMaxBytes = 16u << 20;

constexpr const char* kKnown = "a QGroundControl .plan, QGC WPL, GPX, GeoJSON or KML file";

[[noreturn]] void refuse(const std::string& name, const std::string& found, const std::string& advice) {
  throw Error(ExitCode::kBadInput, fmt::format("{}: expected {}, found {}; {}", name, kKnown, found, advice));
}

void read_json(Mission& mission) {
  const JsonDocument document(mission.text, mission.file);
  const JsonNode root = document.root();
  const auto file_type = root.find("fileType");
  if (file_type && file_type->text() == "Plan") {
    mission.format = Format::kPlan;
    read_plan(root, mission);
  } else if (file_type) {
    refuse(mission.file, fmt::format("a file of type \"{}\"", file_type->text().substr(0, 40)),
           "open it in QGroundControl and save it as a plan");
  } else if (root.find("type")) {
    mission.format = Format::kGeoJson;
    read_geojson(root, mission);
  } else {
    refuse(mission.file, "JSON of another kind", "open it in the program it comes from and export one of these");
  }
}

void read_xml(Mission& mission) {
  const XmlDocument document(mission.text, mission.file);
  const std::string root = local_name(document.root());
  if (root == "gpx") {
    mission.format = Format::kGpx;
    read_gpx(document.root(), mission);
  } else if (root == "kml") {
    mission.format = Format::kKml;
    read_kml(document.root(), mission);
  } else {
    refuse(mission.file, fmt::format("XML with <{}>", root.substr(0, 40)), "export one of these");
  }
}

void read_any(Mission& mission) {
  const std::string &text = mission.text, &name = mission.file;
  if (text.rfind("PK\x03\x04", 0) == 0) {
    refuse(name, "a zip archive", "a KMZ file holds a KML file: unpack it and give that");
  }
  if (text.find('\0') != std::string::npos) refuse(name, "bytes that are no UTF-8 text", "export it as text");
  const size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) refuse(name, "an empty file", "check where it was copied from");
  if (text[first] == '{') return read_json(mission);
  if (text[first] == '<') return read_xml(mission);
  if (text.compare(first, 7, "QGC WPL") != 0) refuse(name, "text of another kind", "check the name");
  mission.format = Format::kWaypoints;
  read_waypoints(mission);
}

void refuse_empty(const Mission& mission) {
  if (!mission.waypoints.empty()) return;
  throw Error(ExitCode::kBadInput,
              fmt::format("{}: expected at least one place to fly to, found none{}{}; add waypoints", mission.file,
                          mission.notes.empty() ? "" : ": ", mission.notes.empty() ? "" : mission.notes.front().text));
}

}  // namespace

Mission parse_mission(std::string text, const std::string& name) {
  constexpr const char* kByteOrderMark = "\xEF\xBB\xBF";
  if (text.size() > kMaxBytes) {
    throw Error(ExitCode::kBadInput, fmt::format("{}: expected a mission of at most {} bytes, found {}; split it", name,
                                                 kMaxBytes, text.size()));
  }
  if (text.rfind(kByteOrderMark, 0) == 0) text.erase(0, 3);
  Mission mission;
  mission.file = name;
  mission.text = std::move(text);
  read_any(mission);
  refuse_empty(mission);
  return mission;
}

Mission read_mission(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string text(kMaxBytes + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!in.eof() && in.fail()) {
    throw Error(ExitCode::kIo,
                fmt::format("{}: expected {}, but it cannot be read; check name and permissions", path, kKnown));
  }
  // One byte past the limit is enough to know that it is exceeded; a special file may never end.
  text.resize(static_cast<size_t>(in.gcount()));
  return parse_mission(std::move(text), path);
}

}  // namespace landfix::mission
