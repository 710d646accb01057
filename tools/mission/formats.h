// One function per file format, called by read.cc: each fills a Mission whose file, format and text are set, and throws
// Error (kBadInput) as read.h says.
#pragma once

#include "tools/mission/mission.h"

namespace landfix::mission {

void read_plan(Mission& mission);
void read_waypoints(Mission& mission);
void read_gpx(Mission& mission);
void read_geojson(Mission& mission);
void read_kml(Mission& mission);

}  // namespace landfix::mission
