// What is wrong with a file is said: which file, where in it, what was expected and found, and what to do.
#include <filesystem>

#include "tests/mission/files.h"

namespace landfix::mission {
namespace {

std::string times(const std::string& text, size_t count) {
  std::string all;
  for (size_t i = 0; i < count; ++i) all += text;
  return all;
}

const std::string kItem = "2\t0\t3\t16\t0\t0\t0\t0\t47.11000000\t8.11000000\t60.000000\t1\n";

TEST(BadFile, CannotBeRead) {
  for (const std::string& path : {testing::TempDir() + "no such mission.plan", testing::TempDir()}) {
    try {
      read_mission(path);
      FAIL() << path;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ExitCode::kIo);
      EXPECT_TRUE(says(e.what(), path));
      EXPECT_TRUE(says(e.what(), "check name and permissions"));
    }
  }
}

TEST(BadFile, OfNoKnownKind) {
  EXPECT_REFUSED("", "found an empty file");
  EXPECT_REFUSED(" \n\t", "found an empty file");
  EXPECT_REFUSED("latitude,longitude\n47,8\n", "found text of another kind");
  EXPECT_REFUSED("<html><body/></html>", "found XML with <html>");
  EXPECT_REFUSED("{\"a\": 1}", "found JSON of another kind");
  EXPECT_REFUSED("{\"fileType\": \"Mission\"}", "save it as a plan");
  EXPECT_REFUSED(std::string("PK\x03\x04") + times("x", 30), "unpack it");
  EXPECT_REFUSED(std::string("{\"\0\": 1}", 8), "no UTF-8 text");
  EXPECT_REFUSED("{\"fileType\": \"\xFF\xFE\"}", "expected JSON");
}

/// 16 MiB are read, a byte more is not; an endless file is not read to its end.
TEST(BadFile, TooLarge) {
  EXPECT_REFUSED(std::string((16 << 20) + 1, ' '), "at most 16777216 bytes, found 16777217");
  EXPECT_REFUSED(std::string(16 << 20, ' '), "found an empty file");
  if (std::filesystem::exists("/dev/zero")) {
    EXPECT_THROW(read_mission("/dev/zero"), Error);
  }
}

TEST(BadFile, NothingToFly) {
  EXPECT_REFUSED("QGC WPL 110\n", "expected at least one place to fly to, found none");
  EXPECT_REFUSED("QGC WPL 110\n0 1 0 16 0 0 0 0 47 8 400 1\n", "found none");
  EXPECT_REFUSED("<gpx/>", "found none");
  EXPECT_REFUSED("<kml><Placemark><LineString/></Placemark></kml>", "found none");
  EXPECT_REFUSED(R"({"type": "FeatureCollection", "features": []})", "found none");
  EXPECT_REFUSED(R"({"fileType": "Plan", "version": 1,
                     "mission": {"items": [], "plannedHomePosition": [0, 0, 0], "version": 2}})",
                 "found none");
  EXPECT_REFUSED("<kml><Polygon/></kml>", "found none: 1 polygons");
}

TEST(BadPlan, Truncated) {
  EXPECT_REFUSED(kPlanText.substr(0, kPlanText.size() / 2), "cut off or damaged");
  EXPECT_REFUSED(kGeoJsonText.substr(0, kGeoJsonText.size() / 2), "cut off or damaged");
}

TEST(BadPlan, Versions) {
  EXPECT_REFUSED(edited(kPlanText, "\"version\": 1\n}", "\"version\": 2\n}"), "expected version 1, found 2");
  EXPECT_REFUSED(edited(kPlanText, "\"vehicleType\": 1,\n        \"version\": 2", "\"version\": 3"),
                 "mission: expected version 2, found 3; it is newer than this program");
  EXPECT_REFUSED(
      edited(kPlanText, "\"version\": 1}],\n        \"version\": 2", "\"version\": 1}],\n        \"version\": 9"),
      "geoFence: expected version 2, found 9");
  EXPECT_REFUSED(edited(kPlanText, "30]], \"version\": 2", "30]], \"version\": 3"),
                 "rallyPoints: expected version 2, found 3");
}

TEST(BadPlan, VersionsOfComplexItems) {
  const std::string newer = "it is newer than this program", older = "open it in a current QGroundControl";
  EXPECT_REFUSED(edited(kPlanText, "\"version\": 5", "\"version\": 6"),
                 "items[4]: expected version 5, found 6; " + newer);
  EXPECT_REFUSED(edited(kPlanText, "\"version\": 5", "\"version\": 3"),
                 "items[4]: expected version 5, found 3; " + older);
  EXPECT_REFUSED(edited(kPlanText, "[47.12, 8.13]], \"version\": 2", "[47.12, 8.13]], \"version\": 3"),
                 "items[4].TransectStyleComplexItem: expected version 2, found 3; " + newer);
  EXPECT_REFUSED(
      edited(kPlanText, "\"ComplexItem\",\n             \"version\": 2", "\"ComplexItem\",\n \"version\": 1"),
      "items[5]: expected version 2, found 1; " + older);
  EXPECT_REFUSED(edited(kPlanText, "\"useLoiterToAlt\": true, \"version\": 2", "\"version\": 3"),
                 "items[8]: expected version 2, found 3; " + newer);
  EXPECT_REFUSED(edited(kPlanText, "fwLanding", "vtolLanding"), "items[8]: expected version 1, found 2; " + newer);
}

TEST(BadPlan, TypesAndMissingKeys) {
  EXPECT_REFUSED(edited(kPlanText, "\"command\": 178", "\"command\": \"178\""),
                 "mission.items[1].command: expected a whole number, found \"178\"");
  EXPECT_REFUSED(edited(kPlanText, "\"command\": 178", "\"command\": 178.5"), "expected a whole number, found 178.5");
  EXPECT_REFUSED(edited(kPlanText, "\"command\": 178", "\"command\": 1e300"), "expected a whole number");
  EXPECT_REFUSED(edited(kPlanText, "\"command\": 178, ", ""), "mission.items[1]: expected \"command\", found none");
  EXPECT_REFUSED(edited(kPlanText, "[4, 0, 0, null, 47.1, 8.11, 60]", "[4, 0, 0, null, 47.1, 8.11]"),
                 "mission.items[2].params: expected 7 parameters, found 6");
  EXPECT_REFUSED(edited(kPlanText, "[4, 0, 0, null, 47.1, 8.11, 60]", "{}"),
                 "params: expected a list, found an object");
  EXPECT_REFUSED(edited(kPlanText, "[4, 0, 0, null, 47.1, 8.11, 60]", "[4, 0, 0, true, 47.1, 8.11, 60]"),
                 "params[3]: expected a number or null, found true");
  EXPECT_REFUSED(edited(kPlanText, "\"type\": \"SimpleItem\", \"vendorNote\"", "\"type\": \"Wish\", \"vendorNote\""),
                 "expected an item of type SimpleItem or ComplexItem, found \"Wish\"");
  EXPECT_REFUSED(edited(kPlanText, "\"inclusion\": false", "\"inclusion\": 0"),
                 "inclusion: expected true or false, found 0");
  EXPECT_REFUSED(edited(kPlanText, "[47.1, 8.1, 431.25]", "[47.1]"),
                 "plannedHomePosition: expected at least 2 values, found 1");
  EXPECT_REFUSED(edited(kPlanText, "\"fileType\": \"Plan\"", "\"fileType\": 7"), "fileType: expected a text, found 7");
  EXPECT_REFUSED(edited(kPlanText, "250.5", "-1"), "expected a radius above 0");
  EXPECT_REFUSED(edited(kPlanText, "[47.0, 8.0], [47.0, 8.2], ", ""), "expected at least 3 corners, found 2");
  EXPECT_REFUSED("{\"fileType\": \"Plan\", \"version\": 1, \"mission\": []}", "mission: expected an object");
}

TEST(BadPlan, Positions) {
  const std::string at = "47.1, 8.11, 60]";
  EXPECT_REFUSED(edited(kPlanText, at, "null, null, 60]"),
                 "mission.items[2]: expected a latitude and longitude in degrees, found nan");
  EXPECT_REFUSED(edited(kPlanText, at, "null, 8.11, 60]"), "mission.items[2]");
  EXPECT_REFUSED(edited(kPlanText, at, "0, 0, 60]"), "found 0, 0");
  EXPECT_REFUSED(edited(kPlanText, at, "97.1, 8.11, 60]"), "found 97.1, 8.11");
  EXPECT_REFUSED(edited(kPlanText, at, "47.1, 188.11, 60]"), "found 47.1, 188.11");
  EXPECT_REFUSED(edited(kPlanText, at, "471000000, 81100000, 60]"), "in degrees");
  EXPECT_REFUSED(edited(kPlanText, "\"frame\": 3, \"params\": [4", "\"frame\": 2, \"params\": [4"),
                 "expected a position in a global frame (0, 3, 5, 6, 10 or 11), found command 16 in frame 2");
  EXPECT_REFUSED(edited(kPlanText, "\"frame\": 3, \"params\": [4", "\"frame\": 1, \"params\": [4"), "in frame 1");
  EXPECT_REFUSED(edited(kPlanText, "\"center\": [47.12, 8.12]", "\"center\": [47.12, null]"),
                 "geoFence.circles[0].circle.center");
  EXPECT_REFUSED(edited(kPlanText, "[[47.11, 8.11, 30]]", "[[147.11, 8.11, 30]]"), "rallyPoints.points[0]");
}

/// Neither items nor a polyline: the pattern is not made up.
TEST(BadPlan, SurveyWithoutTransects) {
  EXPECT_REFUSED(
      edited(kPlanText, "\"VisualTransectPoints\": [[47.13, 8.13], [47.14, 8.13]]", "\"VisualTransectPoints\": []"),
      "mission.items[5]: expected transects (Items or VisualTransectPoints), found none");
  EXPECT_REFUSED(edited(kPlanText, "\"TransectStyleComplexItem\": {", "\"grid\": {"),
                 "mission.items[4]: expected \"TransectStyleComplexItem\", found none");
}

TEST(BadPlan, NestedTooDeep) {
  EXPECT_REFUSED("{\"a\": " + times("[", 100000) + times("]", 100000) + "}", "at most 64 levels");
  EXPECT_REFUSED(times("{\"type\":\"GeometryCollection\",\"geometries\":[", 40) + times("]}", 40), "at most 64 levels");
}

TEST(BadPlan, NumbersOutOfRange) { EXPECT_REFUSED(edited(kPlanText, "431.25", "1e999"), "expected JSON, found"); }

TEST(BadJump, Targets) {
  EXPECT_REFUSED(edited(kPlanText, "[3, 2, 0, 0, 0, 0, 0]", "[77, 2, 0, 0, 0, 0, 0]"),
                 "mission.items[7]: expected a jump to an item of this mission, found item 77");
  EXPECT_REFUSED(edited(kPlanText, "[3, 2, 0, 0, 0, 0, 0]", "[3, -2, 0, 0, 0, 0, 0]"), "found 3, -2 times");
  EXPECT_REFUSED(edited(kPlanText, "[3, 2, 0, 0, 0, 0, 0]", "[3, null, 0, 0, 0, 0, 0]"),
                 "expected a jump to the number of an item");
  EXPECT_REFUSED(edited(kPlanText, "[3, 2, 0, 0, 0, 0, 0]", "[3.5, 2, 0, 0, 0, 0, 0]"), "found 3.5");
  // Ids of items within a survey are not those of the plan.
  EXPECT_REFUSED(edited(kPlanText, "[3, 2, 0, 0, 0, 0, 0]", "[8, 2, 0, 0, 0, 0, 0]"), "found item 8");
}

/// To itself, and two to each other.
TEST(BadJump, Circles) {
  EXPECT_REFUSED(edited(kPlanText, "[3, 2, 0, 0, 0, 0, 0]", "[10, 2, 0, 0, 0, 0, 0]"), "found jumps in a circle");
  EXPECT_REFUSED(
      "QGC WPL 110\n0 1 0 16 0 0 0 0 47 8 400 1\n1 0 3 16 0 0 0 0 47.1 8 50 1\n"
      "2 0 2 177 3 -1 0 0 0 0 0 1\n3 0 2 177 2 -1 0 0 0 0 0 1\n",
      "line 4: expected jumps that lead to a waypoint, found jumps in a circle");
}

TEST(BadWaypoints, Header) {
  EXPECT_REFUSED(edited(kWaypointsText, "110", "100"), "expected \"QGC WPL 110\" (or 120), found \"QGC WPL 100\"");
  EXPECT_REFUSED(edited(kWaypointsText, "110", ""), "found \"QGC WPL\"");
}

TEST(BadWaypoints, Lines) {
  EXPECT_REFUSED(kWaypointsText.substr(0, kWaypointsText.size() - 6),
                 "line 8: expected 12 fields, found 9; the file is cut off");
  EXPECT_REFUSED(edited(kWaypointsText, kItem, ""), "line 4: expected item 2, found 3; a line is missing");
  EXPECT_REFUSED(edited(kWaypointsText, "47.110", "47,110"),
                 "line 4: expected a number in field 9, found \"47,11000000\"");
  EXPECT_REFUSED(edited(kWaypointsText, "47.110", "inf"), "expected a number in field 9");
  EXPECT_REFUSED(edited(kWaypointsText, "47.11000000", "nan"), "line 4: expected a latitude");
  EXPECT_REFUSED(edited(kWaypointsText, "47.11000000\t8.11000000", "0\t0"),
                 "line 4: expected a latitude and longitude in degrees, found 0, 0");
  EXPECT_REFUSED(edited(kWaypointsText, "2\t0\t3\t16", "2\t0\t3\t16.5"),
                 "expected a whole number in field 4, found 16.5");
  EXPECT_REFUSED(edited(kWaypointsText, "2\t0\t3\t16", "2\t0\t-3\t16"), "expected a whole number in field 3");
}

TEST(BadXml, Truncated) {
  EXPECT_REFUSED(kGpxText.substr(0, kGpxText.size() / 2), "cut off or damaged");
  EXPECT_REFUSED(kKmlText.substr(0, kKmlText.size() / 2), "cut off or damaged");
  EXPECT_REFUSED(kKmlText.substr(0, kKmlText.size() - 3), "cut off or damaged");
  EXPECT_REFUSED("<?xml version=\"1.0\"?>", "found: no element");
}

/// A "billion laughs" file, which would grow to gigabytes, and one that reads another file.
TEST(BadXml, Entities) {
  std::string bomb = "<?xml version=\"1.0\"?><!DOCTYPE gpx [<!ENTITY a \"ha\">";
  for (char c = 'b'; c < 'k'; ++c)
    bomb += std::string("<!ENTITY ") + c + " \"" + times(std::string("&") + char(c - 1) + ";", 10) + "\">";
  EXPECT_REFUSED(bomb + "]><gpx><wpt lat=\"1\" lon=\"2\"><name>&j;</name></wpt></gpx>", "found <!ENTITY");
  EXPECT_REFUSED("<!DOCTYPE gpx [<!ENTITY x SYSTEM \"file:///etc/passwd\">]><gpx>&x;</gpx>", "found <!ENTITY");
}

TEST(BadXml, NestedTooDeep) {
  EXPECT_REFUSED("<kml>" + times("<Folder>", 100) + times("</Folder>", 100) + "</kml>", "at most 64 levels");
  EXPECT_REFUSED("<kml>" + times("<a>", 1 << 20), "mission file");
}

TEST(BadXml, Values) {
  EXPECT_REFUSED(edited(kGpxText, "lat=\"47.1\"", "lat=\"north\""), "rtept 0 lat: expected a number, found \"north\"");
  EXPECT_REFUSED(edited(kGpxText, "lat=\"47.1\"", ""), "rtept 0 lat: expected a number, found \"\"");
  EXPECT_REFUSED(edited(kGpxText, "lat=\"47.1\"", "lat=\"97.1\""),
                 "rtept 0: expected a latitude and longitude in degrees, found 97.1, 8.1");
  EXPECT_REFUSED(edited(kGpxText, "<ele>510<", "<ele>nan<"), "rtept 1 ele: expected a number");
  EXPECT_REFUSED(edited(kGpxText, "lat=\"47.5\" lon=\"8.5\"", "lat=\"0\" lon=\"0\""), "wpt 0: expected a latitude");
  EXPECT_REFUSED(edited(kKmlText, "8.1,47.2,510", "8.1;47.2;510"), "placemark 1 \"path\", point 1: expected a number");
  EXPECT_REFUSED(edited(kKmlText, "8.1,47.2,510", "8.1"),
                 "expected longitude, latitude and perhaps altitude, found \"8.1\"");
  EXPECT_REFUSED(edited(kKmlText, "8.1,47.2,510", "8.1,147.2,510"), "point 1: expected a latitude");
}

TEST(BadGeoJson, Values) {
  EXPECT_REFUSED(edited(kGeoJsonText, "[8.1, 47.2, 510]", "[8.1]"),
                 "features[1].geometry.coordinates[1]: expected at least 2 values, found 1");
  EXPECT_REFUSED(edited(kGeoJsonText, "[8.1, 47.2, 510]", "[8.1, 147.2, 510]"),
                 "features[1].geometry.coordinates[1]: expected a latitude");
  EXPECT_REFUSED(edited(kGeoJsonText, "[8.1, 47.2, 510]", "[8.1, null, 510]"),
                 "coordinates[1][1]: expected a number, found null");
  EXPECT_REFUSED(edited(kGeoJsonText, "\"LineString\"", "\"Circle\""),
                 "geometry.type: expected a type of RFC 7946, found \"Circle\"");
  EXPECT_REFUSED(edited(kGeoJsonText, "\"speed_mps\": 14", "\"speed_mps\": -1"),
                 "speed_mps: expected a speed above 0, found -1");
  EXPECT_REFUSED(edited(kGeoJsonText, "\"speed_mps\": 14", "\"altitude_reference\": \"sky\""),
                 "expected ellipsoid, sea_level, home or terrain");
  EXPECT_REFUSED(edited(kGeoJsonText, "\"FeatureCollection\",",
                        R"("FeatureCollection", "crs": {"type": "name", "properties": {"name": "EPSG:25832"}},)"),
                 "reproject the file");
}

/// 100 000 waypoints are read, one more is not.
TEST(BadFile, TooManyWaypoints) {
  const auto line = [](size_t points) {
    return "{\"type\":\"LineString\",\"coordinates\":[" + times("[8,47],", points - 1) + "[8,47]]}";
  };
  EXPECT_EQ(refusal(line(100000)), "");
  EXPECT_REFUSED(line(100001), "expected at most 100000 waypoints");
}

}  // namespace
}  // namespace landfix::mission
