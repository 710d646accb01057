// Missions drawn for the tests, one per format, and what refuses them.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "builder/error.h"
#include "tools/mission/read.h"

namespace landfix::mission {

/// Near 47.1 N, 8.1 E: take-off, a speed, two waypoints (the second, item 3, by height above ground), a survey, a
/// corridor without items, a structure, a jump (twice, to item 2), and a landing; fences, rally points, keys of other
/// programs.
inline const std::string kPlanText = R"plan({
    "fileType": "Plan",
    "geoFence": {
        "breachReturn": [47.1, 8.1, 50],
        "circles": [{"circle": {"center": [47.12, 8.12], "radius": 250.5}, "inclusion": false, "version": 1}],
        "polygons": [{"inclusion": true, "polygon": [[47.0, 8.0], [47.0, 8.2], [47.2, 8.2], [47.2, 8.0]],
                      "version": 1}],
        "version": 2
    },
    "groundStation": "QGroundControl",
    "mission": {
        "cruiseSpeed": 15,
        "firmwareType": 12,
        "globalPlanAltitudeMode": 0,
        "hoverSpeed": 5,
        "items": [
            {"AMSLAltAboveTerrain": null, "Altitude": 50, "AltitudeMode": 1, "autoContinue": true, "command": 22,
             "doJumpId": 1, "frame": 3, "params": [15, 0, 0, null, null, null, 50], "type": "SimpleItem"},
            {"autoContinue": true, "command": 178, "doJumpId": 2, "frame": 2, "params": [1, 12, -1, 0, 0, 0, 0],
             "type": "SimpleItem", "vendorNote": "keep me"},
            {"AMSLAltAboveTerrain": null, "Altitude": 60, "AltitudeMode": 1, "autoContinue": true, "command": 16,
             "doJumpId": 3, "frame": 3, "params": [4, 0, 0, null, 47.1, 8.11, 60], "type": "SimpleItem"},
            {"AMSLAltAboveTerrain": null, "Altitude": 80, "AltitudeMode": 3, "autoContinue": true, "command": 16,
             "doJumpId": 4, "frame": 0, "params": [0, 0, 0, null, 47.1, 8.12, null], "type": "SimpleItem"},
            {"TransectStyleComplexItem": {
                "CameraCalc": {"CameraName": "Manual (no camera specs)", "DistanceMode": 4, "DistanceToSurface": 70,
                               "version": 2},
                "CameraShots": 9, "CameraTriggerInTurnAround": true, "HoverAndCapture": false,
                "Items": [
                    {"autoContinue": true, "command": 16, "doJumpId": 6, "frame": 10,
                     "params": [0, 0, 0, null, 47.11, 8.10, 70], "type": "SimpleItem"},
                    {"autoContinue": true, "command": 206, "doJumpId": 7, "frame": 2,
                     "params": [25, 0, 1, 0, 0, 0, 0], "type": "SimpleItem"},
                    {"autoContinue": true, "command": 16, "doJumpId": 8, "frame": 10,
                     "params": [0, 0, 0, null, 47.11, 8.13, 70], "type": "SimpleItem"},
                    {"autoContinue": true, "command": 16, "doJumpId": 9, "frame": 10,
                     "params": [0, 0, 0, null, 47.12, 8.13, 71], "type": "SimpleItem"}],
                "Refly90Degrees": false, "TurnAroundDistance": 10,
                "VisualTransectPoints": [[47.11, 8.10], [47.11, 8.13], [47.12, 8.13]], "version": 2},
             "angle": 0, "complexItemType": "survey", "entryLocation": 0, "flyAlternateTransects": false,
             "polygon": [[47.11, 8.1], [47.11, 8.13], [47.12, 8.13]], "splitConcavePolygons": false,
             "type": "ComplexItem", "version": 5},
            {"CorridorWidth": 50, "EntryPoint": 0, "TransectStyleComplexItem": {
                "CameraCalc": {"DistanceMode": 2, "DistanceToSurface": 640.5, "version": 2}, "Items": [],
                "VisualTransectPoints": [[47.13, 8.13], [47.14, 8.13]], "version": 2},
             "complexItemType": "CorridorScan", "polyline": [[47.13, 8.13], [47.14, 8.13]], "type": "ComplexItem",
             "version": 2},
            {"EntranceAlt": 60, "complexItemType": "StructureScan", "polygon": [[47.14, 8.14]], "type": "ComplexItem",
             "version": 3},
            {"autoContinue": true, "command": 177, "doJumpId": 10, "frame": 2, "params": [3, 2, 0, 0, 0, 0, 0],
             "type": "SimpleItem"},
            {"altitudesAreRelative": true, "complexItemType": "fwLandingPattern", "landCoordinate": [47.1, 8.1, 0],
             "landingApproachCoordinate": [47.105, 8.105, 40], "loiterClockwise": false, "loiterRadius": 75,
             "stopTakingPhotos": true, "type": "ComplexItem", "useLoiterToAlt": true, "version": 2}
        ],
        "plannedHomePosition": [47.1, 8.1, 431.25],
        "vehicleType": 1,
        "version": 2
    },
    "rallyPoints": {"points": [[47.11, 8.11, 30]], "version": 2},
    "vendor": {"small": 1e-05, "large": 12345678901234567, "text": "gr\u00fcn"},
    "version": 1
}
)plan";

/// Home, take-off where the vehicle stands, three waypoints in three frames, a jump back to item 2 once, a return.
inline const std::string kWaypointsText =
    "QGC WPL 110\n"
    "0\t1\t0\t16\t0\t0\t0\t0\t47.100000\t8.100000\t431.250000\t1\n"
    "1\t0\t3\t22\t0\t0\t0\t0\t0.000000\t0.000000\t50.000000\t1\n"
    "2\t0\t3\t16\t0\t0\t0\t0\t47.11000000\t8.11000000\t60.000000\t1\n"
    "3\t0\t0\t16\t2.5\t0\t0\t0\t47.12000000\t8.12000000\t500.000000\t1\n"
    "4\t0\t10\t82\t0\t0\t0\t0\t47.13000000\t8.13000000\t70.000000\t1\n"
    "5\t0\t3\t177\t2.00000000\t1\t0\t0\t0\t0\t0\t1\n"
    "6\t0\t3\t20\t0\t0\t0\t0\t0\t0\t0\t1\n";

inline const std::string kGpxText = R"(<?xml version="1.0" encoding="UTF-8"?>
<gpx version="1.1" creator="test" xmlns="http://www.topografix.com/GPX/1/1">
  <wpt lat="47.5" lon="8.5"><name>hut</name></wpt>
  <rte><name>round</name>
    <rtept lat="47.1" lon="8.1"><ele>500.5</ele></rtept>
    <rtept lat="47.2" lon="8.1"><ele>510</ele></rtept>
    <rtept lat="47.2" lon="8.2"/>
  </rte>
</gpx>
)";

inline const std::string kKmlText = R"(<?xml version="1.0" encoding="UTF-8"?>
<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2"><Document>
  <Placemark><name>camp</name><Point><coordinates>8.3,47.3,0</coordinates></Point></Placemark>
  <Folder><Placemark><name>path</name><LineString><altitudeMode>absolute</altitudeMode>
    <coordinates>
      8.1,47.1,500.5 8.1,47.2,510
      8.2,47.2,520
    </coordinates></LineString></Placemark></Folder>
</Document></kml>
)";

inline const std::string kGeoJsonText = R"({"type": "FeatureCollection", "features": [
  {"type": "Feature", "properties": null, "geometry": {"type": "Point", "coordinates": [8.3, 47.3]}},
  {"type": "Feature", "properties": {"name": "path", "speed_mps": 14}, "geometry":
    {"type": "LineString", "coordinates": [[8.1, 47.1, 500.5], [8.1, 47.2, 510], [8.2, 47.2, 520]]}}]}
)";

/// `text` with the first `from` replaced; fails where there is none, so that no test edits nothing.
inline std::string edited(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// What the refusal of a text says, "" where it is read.
inline std::string refusal(const std::string& text) {
  try {
    parse_mission(text, "mission file");
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kBadInput) << e.what();
    return e.what();
  }
  return "";
}

inline testing::AssertionResult says(const std::string& message, const std::string& part) {
  if (message.find(part) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "expected \"" << part << "\" in: " << message;
}

inline Place place(double latitude_deg, double longitude_deg, double m, AltitudeReference reference) {
  return {{latitude_deg, longitude_deg}, {m, reference}};
}

}  // namespace landfix::mission

/// The refusal of a text names the file and says this.
#define EXPECT_REFUSED(text, part)                                   \
  do {                                                               \
    const std::string message_ = ::landfix::mission::refusal(text);  \
    EXPECT_TRUE(::landfix::mission::says(message_, "mission file")); \
    EXPECT_TRUE(::landfix::mission::says(message_, part));           \
  } while (false)
