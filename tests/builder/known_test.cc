// Known vector data drawn as GeoJSON: what becomes of buildings, fields, trees and roads.
#include "builder/landmarks/known.h"

#include "builder/landmarks/preference.h"
#include "tests/builder/known_fixture.h"

namespace landfix::landmarks {
namespace {

TEST_F(KnownTest, BuildingsAreTheirRectangle) {
  const double c = std::sqrt(0.75), s = 0.5;  // 40 x 20 m around (200, 300), its length 30 degrees north of east
  Points corners;
  for (const auto& [u, v] : Points{{-20, -10}, {20, -10}, {20, 10}, {-20, 10}})
    corners.emplace_back(200 + u * c - v * s, 300 + u * s + v * c);
  const Known known = read(file({polygon(corners, R"("building":"yes")")}));
  ASSERT_EQ(known.landmarks.size(), 1u);
  const tiles::Landmark& m = known.landmarks[0];
  EXPECT_EQ(m.cls, tiles::LandmarkClass::kBuilding);
  EXPECT_NEAR(m.east_m, kWest + 200, 0.01);
  EXPECT_NEAR(m.north_m, kSouth + 300, 0.01);
  EXPECT_NEAR(m.length_m, 40, 0.01);
  EXPECT_NEAR(m.width_m, 20, 0.01);
  EXPECT_NEAR(m.orientation_rad, 60 * ingest::kDegree, 1e-3);  // clockwise from north
  EXPECT_EQ(m.confidence, 1);
  EXPECT_EQ(m.epochs_seen, 0);
  EXPECT_EQ(m.source, 1);
  EXPECT_TRUE(known.has_landmarks);
  EXPECT_FALSE(known.has_roads);
}

TEST_F(KnownTest, TagsSayTheKindAndOthersAreLeftOut) {
  const Known known = read(file(
      {polygon(box(0, 0, 100, 100), R"("landuse":"farmland")"), polygon(box(200, 0, 100, 50), R"("natural":"water")"),
       polygon(box(400, 0, 20, 20), R"("amenity":"parking")"),
       polygon(box(500, 0, 20, 20), R"("landuse":"residential")"),
       feature("Point", fmt::format("[{},{}]", kWest + 9, kSouth + 700), R"("natural":"tree")"),
       line({{0, 500}, {100, 500}}, R"("highway":"footway")")}));
  EXPECT_EQ(text_of(known.landmarks), "1 fields, 1 trees, 1 water areas, 1 paved areas");
  EXPECT_TRUE(std::isnan(known.landmarks[0].orientation_rad)) << "a square field has no direction";
  EXPECT_NEAR(known.landmarks[1].orientation_rad, std::numbers::pi / 2, 1e-3);
  ASSERT_EQ(known.warnings.size(), 1u);
  EXPECT_NE(known.warnings[0].find("2 features"), std::string::npos) << known.warnings[0];
}

TEST_F(KnownTest, PolygonsBelongToTheMapByTheirCentre) {
  const Known known = read(file(
      {polygon(box(-9, 100, 20, 10), R"("building":"yes")"), polygon(box(-11, 300, 20, 10), R"("building":"yes")")}));
  ASSERT_EQ(known.landmarks.size(), 1u);
  EXPECT_NEAR(known.landmarks[0].east_m, kWest + 1, 0.01);
  EXPECT_NEAR(known.landmarks[0].length_m, 20, 0.01) << "whole, though half of it lies outside";
}

TEST_F(KnownTest, RoadsMeetWhereTheyShareAVertex) {
  const std::string east = line({{100, 200}, {200, 200}, {300, 200}});
  EXPECT_EQ(intersections(roads({east, line({{200, 100}, {200, 200}, {200, 300}})}).roads), 1u);
  EXPECT_EQ(intersections(roads({east, line({{200, 100}, {200, 200}})}).roads), 1u) << "a T";
  EXPECT_EQ(intersections(roads({east, line({{200, 100}, {200, 300}})}).roads), 0u) << "crossed without a vertex";
  const std::string bridge = line({{200, 100}, {200, 200}, {200, 300}}, R"("highway":"primary","bridge":"yes")");
  EXPECT_EQ(intersections(roads({east, bridge}).roads), 0u) << "a bridge whose vertex lies over the other's";
}

TEST_F(KnownTest, EndsThatMissALineByHalfAMetreAreJoinedToIt) {
  const std::string east = line({{100, 200}, {300, 200}});  // no vertex where the others end
  EXPECT_EQ(intersections(roads({east, line({{200, 100}, {200, 199.6}})}).roads), 1u) << "a T, 0.4 m short";
  EXPECT_EQ(intersections(roads({east, line({{200, 100}, {200, 200.4}})}).roads), 1u) << "0.4 m beyond";
  EXPECT_EQ(intersections(roads({line({{200, 199.6}, {200, 100}}), east}).roads), 1u) << "in any order and direction";
  EXPECT_EQ(intersections(roads({east, line({{200, 100}, {200, 199.3}})}).roads), 0u) << "0.7 m short";
  EXPECT_EQ(intersections(roads({east, line({{200, 100}, {200, 200}})}).roads), 1u) << "on the line itself";
  EXPECT_EQ(intersections(roads({east, line({{100.3, 200.2}, {100, 100}}), line({{99.8, 199.9}, {0, 200}})}).roads), 1u)
      << "three ends";
  const Known crossing = roads({east, line({{200, 100}, {200, 199.7}}), line({{200.2, 300}, {200.2, 200.2}})});
  std::vector<tiles::RoadIntersection> found;
  ASSERT_TRUE(tiles::intersections_of(crossing.roads, found));
  ASSERT_EQ(found.size(), 1u) << "from both sides: one crossing";
  EXPECT_EQ(found[0].arms.size(), 4u);
  EXPECT_NEAR(found[0].north_m, kSouth + 200, 0.13) << "on the line that goes on, to the lattice";
}

TEST_F(KnownTest, BridgesMeetOnlyWhatTheyLeadTo) {
  const std::string below = line({{100, 200}, {200, 200}, {300, 200}});
  const auto bridge = [](const Points& points) { return line(points, R"("highway":"residential","bridge":"yes")"); };
  const auto above = [](const Points& points) { return line(points, R"("highway":"residential","layer":"1")"); };
  const std::string deck = bridge({{200, 150}, {200, 250}}), up = line({{200, 50}, {200, 150}}),
                    down = line({{200, 250}, {200, 350}});
  const Known over = roads({below, up, deck, down});
  EXPECT_EQ(intersections(over.roads), 0u);
  EXPECT_EQ(over.roads.edges.size(), 2u) << "the ramps and the bridge are one road";
  EXPECT_EQ(intersections(roads({below, bridge({{200, 150}, {200, 200}}), bridge({{200, 200}, {200, 250}})}).roads), 0u)
      << "two pieces of a bridge that meet over a vertex below";
  EXPECT_EQ(intersections(roads({line({{100, 200}, {200, 200}}), line({{200, 200}, {300, 200}}),
                                 above({{200, 150}, {200, 200}, {200, 250}})})
                              .roads),
            0u)
      << "two pieces of the road that meet below a vertex of the bridge";
  EXPECT_EQ(intersections(roads({below, bridge({{200, 100}, {200, 200}})}).roads), 1u) << "it ends in the road";
  EXPECT_EQ(intersections(roads({below, bridge({{200, 100}, {200, 199.7}})}).roads), 0u)
      << "an end near a road of another layer is not taken for its own";
  EXPECT_EQ(intersections(roads({up, line({{100, 150}, {200, 150}}), bridge({{200.3, 150}, {200, 250}})}).roads), 1u)
      << "but ends meet ends";
  const std::string tunnel = line({{200, 100}, {200, 200}, {200, 300}}, R"("highway":"primary","tunnel":"yes")");
  EXPECT_EQ(intersections(roads({below, tunnel}).roads), 0u);
}

TEST_F(KnownTest, RoadsAreCutDissolvedAndSimplified) {
  // Two ways of one road, given twice, 0.3 m off the straight in between; 100 m of it lie outside.
  const std::string first = line({{-100, 200}, {100, 200}}), second = line({{100, 200}, {150, 200.3}, {200, 200}});
  const Known known = roads({first, second, second});
  ASSERT_EQ(known.roads.edges.size(), 1u);
  EXPECT_TRUE(known.roads.edges[0].vertices.empty());
  EXPECT_NEAR(tiles::length_of(known.roads, known.roads.edges[0]), 200, 0.5);
  EXPECT_EQ(known.roads.edges[0].width_m, 6);
  EXPECT_EQ(text_of({known.roads}), "0.2 km, 0 intersections");
}

TEST_F(KnownTest, WidthsComeFromTags) {
  EXPECT_EQ(road_width_m({{"width", "7.5 m"}, {"lanes", "2"}}), 7.5);
  EXPECT_EQ(road_width_m({{"lanes", "2"}, {"highway", "track"}}), 6.5);
  EXPECT_EQ(road_width_m({{"highway", "track"}, {"width", "20'"}}), 3);
  EXPECT_EQ(road_width_m({}), 6);
}

TEST_F(KnownTest, OtherTagsOfOpenStreetMapFilesAreRead) {
  ingest::Tags tags{{"highway", "service"}};
  ingest::add_hstore(R"("width"=>"4","name"=>"Am \"Alten\" Markt","highway"=>"track","broken"=>")", tags);
  EXPECT_EQ(tags, (ingest::Tags{{"highway", "service"}, {"width", "4"}, {"name", R"(Am "Alten" Markt)"}}));
}

TEST_F(KnownTest, NamesOfLayersSayTheKind) {
  const std::string untagged = polygon(box(0, 0, 30, 10), R"("id":7)");
  EXPECT_EQ(text_of(read(file({untagged}, "gis_Buildings_2019")).landmarks), "1 buildings");
  EXPECT_EQ(text_of(read(file({untagged}, "plan"), Kind::kWater).landmarks), "1 water areas");
  ingest::expect_error(ExitCode::kBadInput, {"railroads", "building, field, tree, water, paved, road"},
                       [&] { read(file({untagged}, "railroads")); });
}

TEST_F(KnownTest, WhatTwoFilesTellOfIsTakenFromTheFirst) {
  const auto house = [](double west, double south, double width) {
    return polygon(box(west, south, width, 10), R"("building":"yes")");
  };
  // The second has the first house 3 m off, one beside it, and a field around both.
  const std::string one = file({house(100, 100, 20), house(100, 100, 20)}, "one"),
                    two = file({house(103, 102, 22), house(130, 100, 20),
                                polygon(box(50, 50, 200, 200), R"("landuse":"farmland")")},
                               "two");
  const Known known = read_known({{one, {}, {}}, {two, {}, {}}}, ingest::kZone32, kMap);
  EXPECT_EQ(text_of(known.landmarks), "2 buildings, 1 fields");
  EXPECT_EQ(known.landmarks[0].source, 1);
  EXPECT_NEAR(known.landmarks[0].east_m, kWest + 110, 0.01);
  EXPECT_EQ(known.landmarks[1].source, 2);
  EXPECT_NEAR(known.landmarks[1].east_m, kWest + 140, 0.01);
}

TEST_F(KnownTest, PreferenceGoesByTheTurnedRectangle) {
  tiles::Landmark barn;
  barn.east_m = kWest, barn.north_m = kSouth, barn.length_m = 40, barn.width_m = 10;
  barn.orientation_rad = std::numbers::pi / 2;  // along the easting
  std::vector<tiles::Landmark> more(3, barn);
  more[0].east_m += 19, more[1].north_m += 6, more[2].cls = tiles::LandmarkClass::kPaved;
  std::vector<tiles::Landmark> all = {barn};
  add_new(all, more);
  ASSERT_EQ(all.size(), 3u) << "one lies 19 m along the barn: in it";
  EXPECT_EQ(all[1].north_m, kSouth + 6) << "6 m across: beside it";
  EXPECT_EQ(all[2].cls, tiles::LandmarkClass::kPaved);
}

TEST_F(KnownTest, ParsesFileLayerAndKind) {
  const VectorInput all = parse_input("town.gpkg:footprints=building");
  EXPECT_EQ(all.path, "town.gpkg");
  EXPECT_EQ(all.layer, "footprints");
  EXPECT_EQ(all.kind, Kind::kBuilding);
  EXPECT_FALSE(parse_input("town.gpkg").kind);
}

}  // namespace
}  // namespace landfix::landmarks
