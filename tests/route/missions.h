// Missions drawn for the tests, with places given on the grid.
#pragma once

#include <fmt/format.h>

#include <string>

#include "tests/route/fields.h"
#include "tools/mission/read.h"

namespace landfix::route {

/// "latitude, longitude" of a place (metres from the corner), as plans have it.
inline std::string degrees_at(double x_m, double y_m) {
  const auto place = tiles::geodetic_from_grid(kZone, kEast + x_m, kNorth + y_m);
  return fmt::format("{:.10f}, {:.10f}", place->latitude_rad * 180 / M_PI, place->longitude_rad * 180 / M_PI);
}

/// A MAVLink item of a plan: frame 0 sea level, 3 home, 10 terrain.
inline std::string item(int id, int command, int frame, const std::string& params, const std::string& place,
                        double altitude_m) {
  return fmt::format(R"({{"type": "SimpleItem", "autoContinue": true, "command": {}, "doJumpId": {}, "frame": {},
                          "params": [{}, {}, {}]}})",
                     command, id, frame, params, place, altitude_m);
}

/// Home at (1000, 1000), 450 m above the ellipsoid by 400 m above sea level.
inline mission::Mission plan(const std::string& items, const std::string& polygons = "") {
  return mission::parse_mission(fmt::format(R"({{"fileType": "Plan", "version": 1, "groundStation": "test",
                       "geoFence": {{"circles": [], "polygons": [{}], "version": 2}},
                       "rallyPoints": {{"points": [], "version": 2}},
                       "mission": {{"version": 2, "firmwareType": 12, "vehicleType": 1, "cruiseSpeed": 20,
                                    "hoverSpeed": 5, "plannedHomePosition": [{}, 400], "items": [{}]}}}})",
                                            polygons, degrees_at(1000, 1000), items),
                                "test.plan");
}

}  // namespace landfix::route
