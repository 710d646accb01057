// Bare lines: GPX, KML and GeoJSON. Order and altitudes, and which line is taken.
#include "tests/mission/files.h"

namespace landfix::mission {
namespace {

using enum AltitudeReference;

std::vector<Place> places(const std::string& text) {
  std::vector<Place> found;
  for (const Waypoint& waypoint : parse_mission(text, "mission file").waypoints) found.push_back(waypoint.place);
  return found;
}

std::vector<Place> square(AltitudeReference reference) {
  return {place(47.1, 8.1, 500.5, reference), place(47.2, 8.1, 510, reference), place(47.2, 8.2, 520, reference)};
}

const std::string kGpxOpen = "<gpx version=\"1.1\">", kGpxClose = "</gpx>";

TEST(Gpx, RouteWithItsElevations) {
  const Mission mission = parse_mission(kGpxText, "mission file");
  EXPECT_EQ(mission.format, Format::kGpx);
  EXPECT_EQ(places(kGpxText), (std::vector<Place>{place(47.1, 8.1, 500.5, kSeaLevel), place(47.2, 8.1, 510, kSeaLevel),
                                                  place(47.2, 8.2, 0, kNone)}));
  EXPECT_EQ(mission.waypoints[2].part, 2u);
  ASSERT_EQ(mission.notes.size(), 1u);
  EXPECT_TRUE(says(mission.notes[0].text, "1 points beside the route"));
}

TEST(Gpx, TrackOfSegments) {
  const std::string track =
      "<trk><trkseg><trkpt lat='1' lon='2'/><trkpt lat='1' lon='3'/></trkseg>"
      "<trkseg><trkpt lat='1' lon='4'><ele>5</ele></trkpt></trkseg></trk>";
  EXPECT_EQ(places(kGpxOpen + track + kGpxClose),
            (std::vector<Place>{place(1, 2, 0, kNone), place(1, 3, 0, kNone), place(1, 4, 5, kSeaLevel)}));
  // Beside a route it is not flown.
  const std::string route = "<rte><rtept lat='7' lon='8'/></rte>";
  EXPECT_EQ(places(kGpxOpen + track + route + kGpxClose), (std::vector<Place>{place(7, 8, 0, kNone)}));
}

TEST(Gpx, WaypointsInTheirOrder) {
  const Mission mission =
      parse_mission(kGpxOpen + "<wpt lat='1' lon='2'/><wpt lat='-1' lon='-2'/>" + kGpxClose, "mission file");
  ASSERT_EQ(mission.waypoints.size(), 2u);
  EXPECT_EQ(mission.waypoints[1].place.position, (Position{-1, -2}));
  EXPECT_EQ(mission.waypoints[1].item, 1u);
}

TEST(Kml, LineAboveSeaLevel) {
  EXPECT_EQ(places(kKmlText), square(kSeaLevel));
  EXPECT_EQ(parse_mission(kKmlText, "mission file").waypoints[0].item, 1u);  // the second placemark
}

TEST(Kml, AltitudeModes) {
  EXPECT_EQ(places(edited(kKmlText, ">absolute<", ">relativeToGround<")), square(kTerrain));
  // Clamped to the ground, which is also what no mode means: altitudes are to be ignored (KML 2.3, 9.20).
  for (const std::string& mode : {std::string("<altitudeMode>clampToGround</altitudeMode>"), std::string()}) {
    for (const Place& found : places(edited(kKmlText, "<altitudeMode>absolute</altitudeMode>", mode))) {
      EXPECT_EQ(found.altitude, Altitude{});
    }
  }
}

TEST(Kml, Track) {
  const std::string text =
      "<k:kml xmlns:k='http://www.opengis.net/kml/2.2' "
      "xmlns:gx='http://www.google.com/kml/ext/2.2'><k:Placemark><gx:Track>"
      "<k:altitudeMode>absolute</k:altitudeMode><k:when>2020-01-01T00:00:00Z</k:when>"
      "<gx:coord>8.1 47.1 500.5</gx:coord><gx:coord>8.1 47.2 510</gx:coord><gx:coord>8.2 47.2 520</gx:coord>"
      "</gx:Track></k:Placemark></k:kml>";
  EXPECT_EQ(places(text), square(kSeaLevel));
}

TEST(Kml, PointsInTheirOrder) {
  const std::string text =
      "<kml><Placemark><Point><coordinates>8,47</coordinates></Point></Placemark>"
      "<Placemark><Point><coordinates>9,48</coordinates></Point></Placemark></kml>";
  EXPECT_EQ(places(text), (std::vector<Place>{place(47, 8, 0, kNone), place(48, 9, 0, kNone)}));
}

TEST(GeoJson, LineAboveEllipsoid) {
  const Mission mission = parse_mission(kGeoJsonText, "mission file");
  EXPECT_EQ(places(kGeoJsonText), square(kEllipsoid));
  EXPECT_EQ(mission.waypoints[0].item, 1u);  // the second feature
  ASSERT_TRUE(mission.waypoints[0].speed);
  EXPECT_EQ(mission.waypoints[0].speed->mps, 14);
  EXPECT_FALSE(mission.waypoints[1].speed);
}

TEST(GeoJson, AltitudeReferenceAsAProperty) {
  EXPECT_EQ(places(edited(kGeoJsonText, "\"speed_mps\": 14", "\"altitude_reference\": \"terrain\"")), square(kTerrain));
}

TEST(GeoJson, BareGeometriesAndPoints) {
  EXPECT_EQ(places(R"({"type": "LineString", "coordinates": [[8, 47], [9, 48]]})"),
            (std::vector<Place>{place(47, 8, 0, kNone), place(48, 9, 0, kNone)}));
  EXPECT_EQ(places(R"({"type": "GeometryCollection", "geometries": [{"type": "Point", "coordinates": [8, 47]},
                       {"type": "MultiPoint", "coordinates": [[9, 48], [7, 46]]}]})"),
            (std::vector<Place>{place(47, 8, 0, kNone), place(48, 9, 0, kNone), place(46, 7, 0, kNone)}));
}

/// Several lines are alternatives as likely as parts: none is taken, all are named.
TEST(Lines, SeveralAreRefused) {
  EXPECT_REFUSED(edited(kGpxText, "</rte>", "</rte><rte><name>other</name><rtept lat='1' lon='2'/></rte>"),
                 "expected one route, found 2 (\"round\", \"other\")");
  EXPECT_REFUSED(
      edited(kKmlText, "</LineString>", "</LineString><LineString><coordinates>1,2</coordinates></LineString>"),
      "expected one line, found 2");
  EXPECT_REFUSED(edited(kGeoJsonText, "\"Point\", \"coordinates\": [8.3, 47.3]",
                        "\"LineString\", \"coordinates\": [[8.3, 47.3], [8.4, 47.3]]"),
                 "expected one line, found 2");
}

}  // namespace
}  // namespace landfix::mission
