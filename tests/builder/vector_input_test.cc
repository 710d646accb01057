// Files of known vector data as they come: formats and CRS, tags of OpenStreetMap, and all that can be wrong with them.
#include <limits>

#include "builder/landmarks/road_network.h"
#include "tests/builder/known_fixture.h"
#include "tiles/geodesy.h"

namespace landfix::landmarks {
namespace {

using ingest::expect_error;

/// A point of the map in degrees, east then north; computed without GDAL.
std::pair<double, double> degrees(double x, double y) {
  const auto at = tiles::geodetic_from_grid(ingest::kZone32, kWest + x, kSouth + y);
  return {at->longitude_rad / ingest::kDegree, at->latitude_rad / ingest::kDegree};
}

std::string wkt_in_degrees(const Points& ring) {
  std::vector<std::string> out;
  for (const auto& [x, y] : ring) out.push_back(fmt::format("{} {}", degrees(x, y).first, degrees(x, y).second));
  out.push_back(out.front());
  return fmt::format("POLYGON (({}))", fmt::join(out, ","));
}

std::string wkt(const char* type, const std::string& coordinates) { return fmt::format("{} {}", type, coordinates); }

std::string ring(const Points& points) {
  std::vector<std::string> out;
  for (const auto& [x, y] : points) out.push_back(fmt::format("{} {}", kWest + x, kSouth + y));
  out.push_back(out.front());
  return fmt::format("(({}))", fmt::join(out, ","));
}

void expect_house_at(const Known& known, double x, double y, const std::string& what) {
  ASSERT_EQ(known.landmarks.size(), 1u) << what;
  EXPECT_NEAR(known.landmarks[0].east_m, kWest + x, 0.02) << what;
  EXPECT_NEAR(known.landmarks[0].north_m, kSouth + y, 0.02) << what;
  EXPECT_NEAR(known.landmarks[0].length_m, 40, 0.02) << what;
  EXPECT_TRUE(known.warnings.empty()) << what << ": " << fmt::format("{}", fmt::join(known.warnings, "; "));
}

void expect_warning(const Known& known, const std::string& words) {
  ASSERT_EQ(known.warnings.size(), 1u) << words;
  EXPECT_NE(known.warnings[0].find(words), std::string::npos) << known.warnings[0];
}

class VectorInputTest : public KnownTest {
 protected:
  std::string bytes_of(const std::string& file) const {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
};

const Points kHouse = box(200, 300, 40, 20);

TEST_F(VectorInputTest, DegreesAreEastThenNorthInEveryFormat) {
  const std::string house = wkt_in_degrees(kHouse);
  for (const auto& [name, driver] : {std::pair("a.gpkg", "GPKG"),
                                     {"a.shp", "ESRI Shapefile"},
                                     {"a.fgb", "FlatGeobuf"},
                                     {"a.gml", "GML"},
                                     {"a.geojson", "GeoJSON"}})
    expect_house_at(read(layer(name, driver, "EPSG:4326", {house}), Kind::kBuilding), 220, 310, name);
}

TEST_F(VectorInputTest, GeoJsonWithoutCrsIsInDegrees) {
  std::string text;
  Points closed = kHouse;
  closed.push_back(kHouse.front());
  for (const auto& [x, y] : closed)
    text += fmt::format("{}[{},{}]", text.empty() ? "" : ",", degrees(x, y).first, degrees(x, y).second);
  const std::string where = "[[" + text + "]]";
  const std::string path = write_text("rfc7946.geojson", R"({"type":"FeatureCollection","features":[)" +
                                                             feature("Polygon", where, R"("building":"yes")") + "]}");
  expect_house_at(read(path), 220, 310, "rfc7946");
}

TEST_F(VectorInputTest, AnotherZoneAndANationalGridAreProjected) {
  OGRSpatialReference grid, national;
  grid.SetFromUserInput("EPSG:32632");
  for (const char* crs : {"EPSG:32633", "EPSG:3035", "EPSG:3857"}) {
    national.SetFromUserInput(crs);
    national.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    const std::unique_ptr<OGRCoordinateTransformation> to(OGRCreateCoordinateTransformation(&grid, &national));
    std::vector<std::string> out;
    Points closed = kHouse;
    closed.push_back(kHouse.front());
    for (const auto& [x, y] : closed) {
      double east = kWest + x, north = kSouth + y;
      ASSERT_TRUE(to->Transform(1, &east, &north));
      out.push_back(fmt::format("{} {}", east, north));
    }
    const std::string name = fmt::format("{}.gpkg", std::string(crs).substr(5));
    const std::string path = layer(name, "GPKG", crs, {fmt::format("POLYGON (({}))", fmt::join(out, ","))});
    expect_house_at(read(path), 220, 310, crs);
  }
}

// A crossing, a bridge over one of its roads, a house, a lake as a relation, and what is none of ours.
TEST_F(VectorInputTest, OpenStreetMapFilesAreRead) {
  std::string nodes;
  int id = 0;
  const auto node = [&](double x, double y, const std::string& tags = "") {
    nodes += fmt::format(R"(<node id="{}" version="1" lat="{:.9f}" lon="{:.9f}">{}</node>)", ++id, degrees(x, y).second,
                         degrees(x, y).first, tags);
    return id;
  };
  const auto tag = [](const char* k, const char* v) { return fmt::format(R"(<tag k="{}" v="{}"/>)", k, v); };
  std::string ways;
  int way_id = 0;
  const auto way = [&](const std::vector<int>& refs, const std::string& tags) {
    ways += fmt::format(R"(<way id="{}" version="1">)", ++way_id);
    for (const int ref : refs) ways += fmt::format(R"(<nd ref="{}"/>)", ref);
    ways += tags + "</way>";
    return way_id;
  };
  const int crossing = node(500, 500);
  way({node(400, 500), crossing, node(600, 500)}, tag("highway", "residential") + tag("width", "8"));
  way({node(500, 400), crossing, node(500, 600)}, tag("highway", "track"));
  way({node(450, 400), node(450, 600)}, tag("highway", "primary") + tag("bridge", "yes") + tag("layer", "1"));
  way({node(10, 10), node(90, 10)}, tag("railway", "rail"));
  const int corner = node(200, 300);
  way({corner, node(240, 300), node(240, 320), node(200, 320), corner}, tag("building", "yes"));
  const int shore = node(700, 700);
  const int outer = way({shore, node(800, 700), node(800, 800), node(700, 800), shore}, "");
  node(30, 30, tag("barrier", "gate"));
  node(40, 40, tag("natural", "tree") + tag("diameter_crown", "9"));
  const std::string relation =
      fmt::format(R"(<relation id="1" version="1"><member type="way" ref="{}" role="outer"/>{}{}</relation>)", outer,
                  tag("type", "multipolygon"), tag("natural", "water"));
  const std::string path = write_text(
      "town.osm", R"(<?xml version="1.0" encoding="UTF-8"?><osm version="0.6">)" + nodes + ways + relation + "</osm>");
  const Known known = read(path);
  EXPECT_EQ(text_of(known.landmarks), "1 buildings, 1 trees, 1 water areas");
  EXPECT_EQ(text_of({known.roads}), "0.6 km, 1 intersections");
  ASSERT_EQ(known.roads.edges.size(), 5u) << "four arms and the bridge";
  EXPECT_EQ(std::ranges::count(known.roads.edges, 8.0, &tiles::RoadEdge::width_m), 2) << "of GDAL's other_tags";
  for (const tiles::Landmark& m : known.landmarks) EXPECT_TRUE(m.cls != tiles::LandmarkClass::kTree || m.length_m == 9);
  expect_warning(known, "features are left out");
  EXPECT_EQ(known.sources[0].crs, "EPSG:4326");
  const Known gate = read(write_text(
      "gate.osm", fmt::format(R"(<?xml version="1.0"?><osm version="0.6"><node id="1" lat="{:.9f}" lon="{:.9f}">)",
                              degrees(30, 30).second, degrees(30, 30).first) +
                      tag("barrier", "gate") + "</node></osm>"));
  expect_warning(gate, "1 features are left out");  // and nobody asks what kind of landmark a gate is
  // Cut anywhere it is not a file any more.
  const std::string whole = bytes_of(path);
  for (const size_t length : {whole.size() / 3, whole.size() - 3})
    expect_error(ExitCode::kBadInput, {"cut.osm"}, [&] { read(write_text("cut.osm", whole.substr(0, length))); });
  const Known nothing = read(write_text("none.osm", R"(<?xml version="1.0"?><osm version="0.6"></osm>)"));
  expect_warning(nothing, "holds no features");
  expect_error(ExitCode::kBadInput, {"away.osm", "outside of the map", "7.8 km", "x 9"}, [&] {
    read_known({{write_text("away.osm", whole), {}, {}}}, ingest::kZone32,
               {kWest + 8600, kSouth, kWest + 9600, kSouth + 1000});
  });
}

TEST_F(VectorInputTest, ALayerOfAnotherPlaceIsRefusedWithItsDistance) {
  const std::string house = polygon(box(0, 0, 30, 10), R"("building":"yes")");
  // The same numbers in the next zone: 6 degrees of longitude at 47 degrees north are 456 km.
  expect_error(ExitCode::kBadInput, {"wholly outside", "456 km", "EPSG:32633", "x 500000", "ogr2ogr -a_srs"},
               [&] { read(file({house}, "wrong", 32633)); });
  const std::string away = layer("away.gpkg", "GPKG", "EPSG:32632", {wkt("POLYGON", ring(box(3500, 0, 40, 20)))});
  expect_error(ExitCode::kBadInput, {"2.5 km"}, [&] { read(away); });
  const std::string metres = R"({"type":"FeatureCollection","features":[)" + house + "]}";
  expect_error(ExitCode::kBadInput, {"outside", "where no grid reaches", "EPSG:4326"},
               [&] { read(write_text("metres_as_degrees.geojson", metres)); });
}

TEST_F(VectorInputTest, ALayerOfThisPlaceMayHaveNothingOnTheMap) {
  const std::string around =
      layer("around.gpkg", "GPKG", "EPSG:32632",
            {wkt("POLYGON", ring(box(-500, -500, 40, 20))), wkt("POLYGON", ring(box(1500, 1500, 40, 20)))});
  const Known known = read(around);
  EXPECT_TRUE(known.landmarks.empty());
  expect_warning(known, "nothing of it lies on the map");
}

TEST_F(VectorInputTest, EmptyLayersAreWarnedOf) {
  expect_warning(read(file({}, "buildings")), "no features");
  for (const auto& [name, driver] : {std::pair("e.gpkg", "GPKG"), {"e.shp", "ESRI Shapefile"}})
    expect_warning(read(layer(name, driver, "EPSG:4326", {})), "no features");
}

TEST_F(VectorInputTest, ALayerWithoutCrsIsRefused) {
  for (const auto& [name, driver] : {std::pair("n.shp", "ESRI Shapefile"), {"n.gpkg", "GPKG"}})
    expect_error(ExitCode::kBadInput, {"coordinate reference system is missing", "-a_srs"},
                 [&] { read(layer(name, driver, "", {wkt("POLYGON", ring(kHouse))})); });
}

TEST_F(VectorInputTest, WhatIsNoFileOrLayerOrKindIsRefused) {
  expect_error(ExitCode::kBadInput, {"not a vector file"}, [&] { read(write_text("a.gpkg", "nonsense")); });
  expect_error(ExitCode::kIo, {"no such file"}, [&] { read(path("none.gpkg")); });
  const std::string house = polygon(kHouse, R"("building":"yes")");
  expect_error(ExitCode::kBadInput, {"no layer \"x\"", "osm"}, [&] { read(file({house}), {}, "x"); });
  expect_error(ExitCode::kUsage, {"\"house\"", "building, field"}, [&] { parse_input("no.gpkg=house"); });
}

// Whatever is lost: an error that names the file, or fewer features; never a crash. Most lengths must be errors.
TEST_F(VectorInputTest, TruncatedFilesAreRefused) {
  std::vector<std::string> houses;
  for (int i = 0; i < 300; ++i) houses.push_back(wkt("POLYGON", ring(box(30 * (i % 30), 30 * (i / 30), 20, 10))));
  for (const auto& [name, driver] :
       {std::pair("t.gpkg", "GPKG"), {"t.geojson", "GeoJSON"}, {"t.fgb", "FlatGeobuf"}, {"t.shp", "ESRI Shapefile"}}) {
    const std::string whole_path = layer(name, driver, "EPSG:32632", houses);
    EXPECT_EQ(read(whole_path, Kind::kBuilding).landmarks.size(), 300u) << name;
    const std::string whole = bytes_of(whole_path);
    for (const double share : {0.02, 0.3, 0.6, 0.9, 0.99}) {
      write_text(name, whole.substr(0, size_t(share * double(whole.size()))));
      expect_error(ExitCode::kBadInput, {name}, [&] { read(whole_path, Kind::kBuilding); });
    }
  }
}

TEST_F(VectorInputTest, CollectionsArePartsAndEmptyGeometriesNothing) {
  const std::string path = layer(
      "mixed.gpkg", "GPKG", "EPSG:32632",
      {"GEOMETRYCOLLECTION (" + wkt("POLYGON", ring(kHouse)) + ", GEOMETRYCOLLECTION (" +
           wkt("MULTIPOLYGON", "(" + ring(box(400, 300, 20, 10)) + "," + ring(box(500, 300, 20, 10)) + ")") + "))",
       "POLYGON EMPTY", "GEOMETRYCOLLECTION EMPTY", "MULTIPOLYGON EMPTY",
       fmt::format("CURVEPOLYGON (CIRCULARSTRING ({0} {1}, {2} {1}, {0} {1}))", kWest + 600, kSouth + 600,
                   kWest + 620)});
  const Known known = read(path);
  ASSERT_EQ(known.landmarks.size(), 4u);
  EXPECT_NEAR(known.landmarks[3].east_m, kWest + 610, 0.05) << "a round one, through its arcs";
  EXPECT_NEAR(known.landmarks[3].length_m, 20, 0.1);
}

TEST_F(VectorInputTest, RingsThatCrossThemselvesStayWhereTheyAre) {
  // A bow tie whose halves nearly cancel: the centroid of its signed area would lie kilometres away.
  const Points bow = {{300, 300}, {340, 320}, {340, 300}, {300, 320.001}};
  for (const Kind kind : {Kind::kBuilding, Kind::kField}) {
    const Known known =
        read(layer(fmt::format("bow{}.gpkg", int(kind)), "GPKG", "EPSG:32632", {wkt("POLYGON", ring(bow))}), kind);
    ASSERT_EQ(known.landmarks.size(), 1u);
    EXPECT_NEAR(known.landmarks[0].east_m, kWest + 320, 0.1);
    EXPECT_NEAR(known.landmarks[0].north_m, kSouth + 310, 0.1);
    EXPECT_NEAR(known.landmarks[0].length_m, 40, 0.1);
  }
  const Points flat = {{300, 300}, {310, 300}, {320, 300}};
  EXPECT_EQ(read(layer("flat.gpkg", "GPKG", "EPSG:32632", {wkt("POLYGON", ring(flat))})).landmarks.size(), 1u);
}

TEST_F(VectorInputTest, CoordinatesThatAreNoPlaceAreLeftOut) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, infinite, 1e300, -1e9}) {
    const std::string name = fmt::format("bad_{}.gpkg", bad);
    const std::string path = layer(name, "GPKG", "EPSG:32632", {wkt("POLYGON", ring(kHouse))});
    {
      const GDALDatasetUniquePtr file(GDALDataset::Open(path.c_str(), GDAL_OF_VECTOR | GDAL_OF_UPDATE));
      OGRFeature spike(file->GetLayer(0)->GetLayerDefn());
      OGRLinearRing outline;
      outline.addPoint(kWest + 100, kSouth + 100);
      outline.addPoint(bad, kSouth + 100);
      outline.addPoint(kWest + 130, kSouth + 130);
      outline.closeRings();
      OGRPolygon polygon;
      polygon.addRing(&outline);
      spike.SetGeometry(&polygon);
      ASSERT_EQ(file->GetLayer(0)->CreateFeature(&spike), OGRERR_NONE);
    }
    const Known known = read(path);
    ASSERT_EQ(known.landmarks.size(), 1u) << bad;
    EXPECT_NEAR(known.landmarks[0].east_m, kWest + 220, 0.02);
    for (const std::string& warning : known.warnings)
      EXPECT_NE(warning.find("1 features without usable geometry"), std::string::npos) << warning;
  }
  const Known road = read(file({line({{100, 100}, {200, 100}, {1e12, 100}}), line({{100, 300}, {200, 300}})}));
  EXPECT_EQ(text_of({road.roads}), "0.1 km, 0 intersections") << "the other one alone";
  expect_warning(road, "1 features without usable geometry");
}

TEST_F(VectorInputTest, FeaturesGivenTwiceAreThereOnce) {
  const std::string house = polygon(kHouse, R"("building":"yes")"), street = line({{100, 200}, {300, 200}});
  const Known known = read(file({house, house, street, house, street}));
  EXPECT_EQ(known.landmarks.size(), 1u);
  EXPECT_EQ(text_of({known.roads}), "0.2 km, 0 intersections");
}

TEST_F(VectorInputTest, LayersOfNoKindAreLeftOutBesideOthers) {
  const std::string path = layer("two.gpkg", "GPKG", "EPSG:32632", {wkt("POLYGON", ring(kHouse))});
  {
    const GDALDatasetUniquePtr file(GDALDataset::Open(path.c_str(), GDAL_OF_VECTOR | GDAL_OF_UPDATE));
    OGRLayer* parishes = file->CreateLayer("parishes", file->GetLayer(0)->GetSpatialRef(), wkbPolygon, nullptr);
    OGRFeature parish(parishes->GetLayerDefn());
    parish.SetGeometry(OGRFeatureUniquePtr(file->GetLayer(0)->GetNextFeature())->GetGeometryRef());
    ASSERT_EQ(parishes->CreateFeature(&parish), OGRERR_NONE);
  }
  const Known known = read(path);
  EXPECT_EQ(text_of(known.landmarks), "1 buildings");
  ASSERT_EQ(known.warnings.size(), 2u);
  EXPECT_NE(known.warnings[1].find("1 features are left out"), std::string::npos) << known.warnings[1];
  EXPECT_NE(known.warnings[0].find("\"parishes\""), std::string::npos) << known.warnings[0];
  expect_error(ExitCode::kBadInput, {"\"parishes\"", "=KIND"}, [&] { read(path, {}, "parishes"); });
}

}  // namespace
}  // namespace landfix::landmarks
