// Landmarks and roads as users of `landfix` meet them: counted, exported to files that GIS programs open, and drawn.
#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogrsf_frmts.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgcodecs.hpp>

#include "tests/pack/draw.h"
#include "tests/pack/patch.h"
#include "tests/tools/command.h"
#include "tiles/geodesy.h"

namespace landfix {
namespace {

using nlohmann::json;
using std::numbers::pi;

constexpr double kWest = 1952 * 256.0, kSouth = 19528 * 256.0;  // zone 32 north
constexpr int kDone = 0, kUsage = 2, kBadPack = 4, kNoData = 6, kIo = 7;

using tests::Outcome;

// 256 m of even gray with a house, a tree and a crossing of four in it.
tests::Drawing drawing() {
  tests::DrawnLayer gray;
  gray.levels = {{0, 1952, 19528, "x"}};
  gray.pixel = [](const tests::PixelOf&) { return 100; };
  tiles::Landmark house, tree;
  house.east_m = kWest + 60, house.north_m = kSouth + 180, house.length_m = 40, house.width_m = 20;
  house.orientation_rad = pi / 2, house.confidence = 1, house.distinctiveness_m = 300, house.source = 1;
  tree.cls = tiles::LandmarkClass::kTree, tree.east_m = kWest + 200, tree.north_m = kSouth + 200;
  tree.length_m = tree.width_m = 16, tree.confidence = 0.6, tree.epochs_seen = 2;
  tiles::RoadGraph roads;
  for (const auto& [x, y] : {std::pair(128, 100), {20, 100}, {240, 100}, {128, 20}, {128, 240}})
    roads.nodes.push_back({kWest + x, kSouth + y});
  for (uint32_t i = 1; i <= 4; ++i) roads.edges.push_back({0, i, 6, 0.8, 0, {}});
  tests::Drawing d{.layers = {gray}, .landmarks = std::vector{house, tree}, .roads = roads};
  exporter::PackSource known;
  known.role = exporter::SourceRole::kVector;
  known.source.name = "houses.gpkg";
  d.description.sources = {known};
  d.description.bounds = {kWest, kSouth, kWest + 256, kSouth + 256};
  return d;
}

class VectorCommand : public testing::Test {
 protected:
  VectorCommand() {
    tests::write_file(path("map.lfpack"), tests::draw(drawing()));
    GDALAllRegister();
  }
  std::string path(const std::string& name) const { return folder_.file(name); }
  Outcome run(const std::string& arguments) const { return tests::run_landfix(folder_.file(""), arguments); }
  json json_of(const std::string& arguments) const {
    const Outcome done = run(arguments);
    EXPECT_EQ(done.code, kDone) << done.out;
    return json::parse(done.out, nullptr, false);
  }
  void expect_refusal(const std::string& arguments, int code, const std::vector<std::string>& words) const {
    tests::expect_refusal(run(arguments), code, words);
  }
  bool exists(const std::string& name) const { return std::filesystem::exists(path(name)); }
  GDALDatasetUniquePtr open(const std::string& name) const {
    return GDALDatasetUniquePtr(GDALDataset::Open(path(name).c_str(), GDAL_OF_VECTOR));
  }
  GDALDatasetUniquePtr open_raster(const std::string& name) const {
    return GDALDatasetUniquePtr(GDALDataset::Open(path(name).c_str(), GDAL_OF_RASTER));
  }

 private:
  tests::TemporaryFolder folder_;
};

TEST_F(VectorCommand, InfoCountsThem) {
  const json info = json_of("info --json map.lfpack");
  std::map<std::string, json> layers;
  for (const json& layer : info["layers"]) layers[layer["name"]] = layer;
  EXPECT_EQ(layers["landmarks"]["features"],
            json({{"building", 1}, {"field", 0}, {"tree", 1}, {"water", 0}, {"paved", 0}}));
  EXPECT_EQ(layers["roads"]["features"]["intersections"], 1);
  EXPECT_NEAR(layers["roads"]["features"]["roads_km"].get<double>(), 0.44, 1e-9) << "220 m each way";
  EXPECT_FALSE(layers["gray"].contains("features"));
  const std::string text = run("info map.lfpack").out;
  EXPECT_NE(text.find("building 1, field 0, tree 1"), std::string::npos) << text;
  EXPECT_NE(text.find("0.4 km, 1 intersections"), std::string::npos) << text;
}

TEST_F(VectorCommand, GeoPackageIsOnTheGridWithItsStyle) {
  EXPECT_EQ(json_of("export map.lfpack --layer landmarks -o out.gpkg --json")["features"], 2);
  const GDALDatasetUniquePtr file = open("out.gpkg");
  ASSERT_TRUE(file);
  OGRLayer* layer = file->GetLayerByName("landmarks");
  ASSERT_TRUE(layer);
  EXPECT_STREQ(layer->GetSpatialRef()->GetAuthorityCode(nullptr), "32632");
  ASSERT_EQ(layer->GetFeatureCount(), 2);
  int houses = 0;
  for (const auto& feature : *layer) {
    const OGRPoint& point = *feature->GetGeometryRef()->toPoint();
    EXPECT_EQ(point.getX(), feature->GetFieldAsDouble("east_m"));
    if (std::string(feature->GetFieldAsString("class")) == "building") {
      ++houses;
      EXPECT_EQ(point.getX(), kWest + 60);
      EXPECT_NEAR(feature->GetFieldAsDouble("length_m"), 40.317, 1e-9);
      EXPECT_EQ(feature->GetFieldAsDouble("orientation_deg"), 90);
      EXPECT_EQ(feature->GetFieldAsDouble("distinctiveness_m"), 256);
      EXPECT_STREQ(feature->GetFieldAsString("source"), "houses.gpkg");
    } else {
      EXPECT_TRUE(feature->IsFieldNull(feature->GetFieldIndex("orientation_deg"))) << "a tree has none";
      EXPECT_EQ(feature->GetFieldAsInteger("epochs_seen"), 2);
      EXPECT_STREQ(feature->GetFieldAsString("source"), "images");
    }
  }
  EXPECT_EQ(houses, 1);
  // Where QGIS looks for it.
  OGRLayer* styles = file->GetLayerByName("layer_styles");
  ASSERT_TRUE(styles);
  ASSERT_EQ(styles->GetFeatureCount(), 1);
  const OGRFeatureUniquePtr style(styles->GetNextFeature());
  EXPECT_STREQ(style->GetFieldAsString("f_table_name"), "landmarks");
  EXPECT_STREQ(style->GetFieldAsString("f_geometry_column"), layer->GetGeometryColumn());
  EXPECT_EQ(style->GetFieldAsInteger("useAsDefault"), 1);
  const std::string qml = style->GetFieldAsString("styleQML");
  EXPECT_NE(qml.find("categorizedSymbol\" attr=\"class\""), std::string::npos);
  for (const char* name : {"building", "field", "tree", "water", "paved"})
    EXPECT_NE(qml.find("value=\"" + std::string(name) + "\""), std::string::npos) << name;
}

TEST_F(VectorCommand, GeoJsonIsInDegreesWithItsStyleBeside) {
  EXPECT_EQ(json_of("export map.lfpack --layer intersections -o out.geojson --json")["features"], 1);
  const json file = json::parse(std::ifstream(path("out.geojson")));
  ASSERT_EQ(file["features"].size(), 1u);
  EXPECT_FALSE(file.contains("crs")) << "RFC 7946 knows degrees alone";
  const json& cross = file["features"][0];
  const auto place = tiles::geodetic_from_grid({32, true}, kWest + 128, kSouth + 100);
  EXPECT_NEAR(cross["geometry"]["coordinates"][0].get<double>(), place->longitude_rad * 180 / pi, 2e-8);
  EXPECT_NEAR(cross["geometry"]["coordinates"][1].get<double>(), place->latitude_rad * 180 / pi, 2e-8);
  EXPECT_EQ(cross["properties"]["degree"], 4);
  EXPECT_EQ(cross["properties"]["bearings_deg"], "0.0 90.0 180.0 270.0");
  EXPECT_EQ(cross["properties"]["widths_m"], "6.3 6.3 6.3 6.3") << "6 m to the nearest size level";
  EXPECT_TRUE(exists("out.qml"));
}

TEST_F(VectorCommand, RoadsAreLines) {
  EXPECT_EQ(json_of("export map.lfpack --layer roads -o roads.gpkg --json")["features"], 4);
  EXPECT_EQ(json_of("export map.lfpack --layer roads -o roads.geojson --json")["features"], 4);
  const GDALDatasetUniquePtr file = open("roads.gpkg");
  OGRLayer* layer = file->GetLayerByName("roads");
  ASSERT_TRUE(layer);
  double length = 0;
  for (const auto& feature : *layer) {
    EXPECT_EQ(wkbFlatten(feature->GetGeometryRef()->getGeometryType()), wkbLineString);
    EXPECT_EQ(feature->GetGeometryRef()->toLineString()->get_Length(), feature->GetFieldAsDouble("length_m"));
    length += feature->GetFieldAsDouble("length_m");
  }
  EXPECT_EQ(length, 440);
}

TEST_F(VectorCommand, ExportGivesTheSameBytesAgain) {
  for (const std::string extension : {"gpkg", "geojson"}) {
    ASSERT_EQ(run("export map.lfpack --layer landmarks -o a." + extension).code, kDone);
    ASSERT_EQ(run("export map.lfpack --layer landmarks -o b." + extension).code, kDone);
    EXPECT_TRUE(tests::read_file(path("a." + extension)) == tests::read_file(path("b." + extension))) << extension;
  }
}

TEST_F(VectorCommand, QueryDrawsThemWhereTheyAre) {
  const json answer =
      json_of("query map.lfpack --grid 499840,4999296 --sigma 42 --draw landmarks,roads -o out.png --json");
  EXPECT_EQ(answer["features"]["building"], 1);
  EXPECT_EQ(answer["features"]["roads"], 4);
  const cv::Mat picture = cv::imread(path("out.png"));
  ASSERT_FALSE(picture.empty());
  // Pixels of about this colour (blue, green, red) around a place in metres.
  const json& r = answer["region"];
  const int scale = picture.cols / r["width_px"].get<int>();
  EXPECT_GE(picture.cols, 900) << "enlarged to be read";
  EXPECT_GT(picture.rows, r["height_px"].get<int>() * scale) << "a legend stands below";
  const auto coloured = [&](double x, double y, double radius_m, const cv::Vec3b& wanted) {
    int count = 0;
    const double column = (kWest + x - r["west_m"].get<double>()) * scale,
                 row = (r["north_m"].get<double>() - kSouth - y) * scale;
    const int reach = int(radius_m * scale);
    for (int v = int(row) - reach; v <= int(row) + reach; ++v)
      for (int u = int(column) - reach; u <= int(column) + reach; ++u)
        count += cv::norm(picture.at<cv::Vec3b>(v, u), wanted) < 40;
    return count;
  };
  const cv::Vec3b red(50, 55, 225), green(75, 165, 40), cyan(230, 215, 0), gray(100, 100, 100);
  EXPECT_GT(coloured(40, 180, 2, red), 5) << "the house lies east-west: 20 m to its western end";
  EXPECT_EQ(coloured(60, 200, 4, red), 0) << "and 10 m to its northern";
  EXPECT_GT(coloured(60, 190, 2, red), 5);
  EXPECT_GT(coloured(208, 200, 2, green), 5) << "the tree's circle has a radius of 8 m";
  EXPECT_GT(coloured(60, 100, 2, cyan), 5) << "a road";
  EXPECT_EQ(coloured(180, 60, 10, cyan), 0);
  EXPECT_GT(coloured(180, 60, 2, gray), 100) << "the map below";
}

TEST_F(VectorCommand, WhatCannotBeIsRefused) {
  expect_refusal("export map.lfpack --layer landmarks -o out.shp", kUsage, {"out.shp", ".gpkg", ".geojson"});
  expect_refusal("export map.lfpack --layer houses -o out.gpkg", kUsage,
                 {"houses", "landmarks, roads or intersections"});
  expect_refusal("query map.lfpack --grid 499840,4999296 --layer roads", kUsage, {"no pixels", "--draw roads"});
  expect_refusal("query map.lfpack --grid 499840,4999296 --draw houses -o out.png", kUsage, {"houses", "landmarks"});
  expect_refusal("query map.lfpack --grid 499840,4999296 --draw roads -o out.tif", kUsage, {"--draw", ".png"});
  tests::Drawing plain = drawing();
  plain.landmarks.reset();
  tests::write_file(path("plain.lfpack"), tests::draw(plain));
  expect_refusal("export plain.lfpack --layer landmarks -o out.gpkg", kNoData, {"plain.lfpack", "landmarks"});
  EXPECT_FALSE(exists("out.gpkg"));
}

// A disk that is full after 512 bytes, less than either file takes.
TEST_F(VectorCommand, WhatCannotBeWrittenWholeIsNotWritten) {
  for (const std::string name : {"full.geojson", "full.gpkg"}) {
    const Outcome outcome = tests::run_landfix(path("") + " && trap '' XFSZ && ulimit -f 1",
                                               "export map.lfpack --layer landmarks -o " + name);
    tests::expect_refusal(outcome, kIo, {name, "cannot be written"});
    EXPECT_FALSE(exists(name));
  }
}

TEST_F(VectorCommand, ADamagedTileIsSaidAndNothingIsWritten) {
  tests::Patch patch(tests::read_file(path("map.lfpack")));
  for (const schema::BlockRecord& block : patch.blocks())
    for (schema::TileRecord& tile : patch.tiles(block))
      if (tile.codec == uint8_t(tiles::Codec::kVector)) patch.data(tile)[2] ^= 0x40;
  tests::write_file(path("bad.lfpack"), tests::rehashed(std::move(patch)));
  expect_refusal("export bad.lfpack --layer landmarks -o out.gpkg", kBadPack, {"bad.lfpack", "landmarks", "damaged"});
  EXPECT_FALSE(exists("out.gpkg"));
  const Outcome info = run("info bad.lfpack");
  EXPECT_EQ(info.code, kDone) << info.out;
  EXPECT_NE(info.out.find("landmarks    damaged"), std::string::npos) << info.out;
  EXPECT_EQ(run("verify bad.lfpack").code, kDone) << "the hashes are right";
  EXPECT_EQ(run("verify --deep bad.lfpack").code, kBadPack);
}

using Places = std::vector<std::pair<double, double>>;

Places places_in(GDALDataset& file, const char* east, const char* north,
                 const std::function<bool(double, double)>& take) {
  Places out;
  for (const auto& f : file.GetLayer(0))
    if (take(f->GetFieldAsDouble(east), f->GetFieldAsDouble(north)))
      out.emplace_back(f->GetFieldAsDouble(east), f->GetFieldAsDouble(north));
  return out;
}

// Each of one has its own in the other, at most so many metres away. How many are nearer than 0.2 m.
size_t expect_same_places(const Places& truth, Places found, double at_most_m) {
  size_t exact = 0;
  EXPECT_EQ(truth.size(), found.size());
  for (const auto& [east, north] : truth) {
    const auto away = [&](const auto& p) { return std::hypot(p.first - east, p.second - north); };
    const auto nearest = std::ranges::min_element(found, {}, away);
    if (nearest == found.end()) break;
    EXPECT_LT(away(*nearest), at_most_m) << east << " " << north;
    exact += away(*nearest) < 0.2;
    found.erase(nearest);
  }
  return exact;
}

// The truth of a drawn world goes in as vectors and comes out of the pack: positions to the lattice (0.125 m each way)
// and what the degrees of GeoJSON lose. Of 50 buildings that touch the map 44 have their centre on it.
TEST_F(VectorCommand, BuildTakesKnownLandmarksAndRoads) {
  ASSERT_EQ(run("synth -o world --seed 7 --size-m 1000 --gsd 2 --dem-gsd 10").code, kDone);
  const std::string build =
      "build world/ortho.tif --layers gray,landmarks,roads --vectors world/buildings.geojson --vectors "
      "world/roads.geojson ";
  const Outcome built = run(build + "-o one.lfpack --threads 1");
  ASSERT_EQ(built.code, kDone) << built.out;
  ASSERT_EQ(run(build + "-o two.lfpack --threads 2").code, kDone);
  EXPECT_EQ(run("verify --deep one.lfpack").code, kDone);
  EXPECT_EQ(json_of("verify --json one.lfpack")["root"], json_of("verify --json two.lfpack")["root"]);
  ASSERT_EQ(run("export one.lfpack --layer landmarks -o found.gpkg").code, kDone);
  const GDALDatasetUniquePtr image = open_raster("world/ortho.tif");
  double corner[6];
  ASSERT_EQ(image->GetGeoTransform(corner), CE_None);
  const auto on_map = [&](double east, double north) {
    return east >= corner[0] && east < corner[0] + 1000 && north < corner[3] && north >= corner[3] - 1000;
  };
  const auto everywhere = [](double, double) { return true; };
  const GDALDatasetUniquePtr truth = open("world/buildings.geojson"), found = open("found.gpkg");
  for (const auto& f : found->GetLayer(0)) {
    EXPECT_STREQ(f->GetFieldAsString("class"), "building");
    EXPECT_STREQ(f->GetFieldAsString("source"), "buildings.geojson");
    EXPECT_GE(f->GetFieldAsDouble("distinctiveness_m"), 8) << "no two houses are nearer to each other";
  }
  EXPECT_EQ(truth->GetLayer(0)->GetFeatureCount(), 50);
  const Places buildings = places_in(*truth, "easting_m", "northing_m", on_map);
  EXPECT_EQ(buildings.size(), 44u);
  size_t plain = 0;
  for (const auto& f : truth->GetLayer(0))
    plain += f->GetGeometryRef()->toPolygon()->getExteriorRing()->getNumPoints() == 5 &&
             on_map(f->GetFieldAsDouble("easting_m"), f->GetFieldAsDouble("northing_m"));
  EXPECT_GT(plain, 30u);
  EXPECT_GE(expect_same_places(buildings, places_in(*found, "east_m", "north_m", everywhere), 4), plain)
      << "a wing, up to 6 m long, moves the rectangle's centre off that of the house";
  EXPECT_NE(built.out.find("landmarks: 44 buildings"), std::string::npos) << built.out;
  ASSERT_EQ(run("export one.lfpack --layer intersections -o crossings.gpkg").code, kDone);
  const GDALDatasetUniquePtr crossings = open("world/intersections.geojson"), met = open("crossings.gpkg");
  const Places junctions = places_in(*crossings, "easting_m", "northing_m", everywhere);
  EXPECT_EQ(junctions.size(), 66u);
  EXPECT_EQ(expect_same_places(junctions, places_in(*met, "east_m", "north_m", everywhere), 0.2), 66u);
  const auto degrees = [](GDALDataset& file) {
    std::map<int, int> out;
    for (const auto& f : file.GetLayer(0)) ++out[f->GetFieldAsInteger("degree")];
    return out;
  };
  EXPECT_EQ(degrees(*crossings), degrees(*met));
}

}  // namespace
}  // namespace landfix
