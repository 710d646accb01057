// One function per file format, called by read.cc with what it has parsed: each fills a Mission whose file, format and
// text are set, and throws Error (kBadInput) as read.h says.
#pragma once

#include <cpl_minixml.h>

#include "tools/mission/json.h"
#include "tools/mission/mission.h"

namespace landfix::mission {

void read_plan(const JsonNode& root, Mission& mission);
void read_waypoints(Mission& mission);
void read_gpx(const CPLXMLNode* root, Mission& mission);
void read_geojson(const JsonNode& root, Mission& mission);
void read_kml(const CPLXMLNode* root, Mission& mission);

}  // namespace landfix::mission
