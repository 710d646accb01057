// Landmarks of images as users of `landfix` meet them, and what training reads.
#include "tests/tools/command.h"

#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogrsf_frmts.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "builder/error.h"
#include "builder/training/object_training.h"
#include "tools/synth/world.h"

namespace landfix {
namespace {

using landmarks::KnownScene;
using landmarks::Region;
using nlohmann::json;
using tests::run_landfix;
using tiles::LandmarkClass;

constexpr int kDone = 0, kUsage = 2, kBadInput = 3, kIo = 7;

// A village of 400 m by 400 m on disk, written once by each process.
class VillageFolder {
 public:
  VillageFolder() : path_(testing::TempDir() + "landfix_village_" + std::to_string(getpid())) {
    synth::WorldOptions options;
    options.west_m = 500850;
    options.south_m = 5401400;
    options.size_m = 400;
    options.gsd_m = 1;
    synth::write_world(options, path_);
  }
  ~VillageFolder() { std::filesystem::remove_all(path_); }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

const std::string& village() {
  static const VillageFolder kFolder;
  return kFolder.path();
}

TEST(LandmarksCommand, WritesPointsOutlinesAndAPicture) {
  const tests::Outcome done = run_landfix(village(), "landmarks ortho.tif -o found.gpkg --picture found.png");
  ASSERT_EQ(done.code, kDone) << done.out;
  EXPECT_NE(done.out.find("buildings"), std::string::npos) << done.out;
  GDALAllRegister();
  const GDALDatasetUniquePtr file(GDALDataset::Open((village() + "/found.gpkg").c_str(), GDAL_OF_VECTOR));
  ASSERT_TRUE(file);
  OGRLayer* points = file->GetLayerByName("landmarks");
  OGRLayer* outlines = file->GetLayerByName("outlines");
  ASSERT_TRUE(points && outlines);
  EXPECT_GT(points->GetFeatureCount(), 20);
  EXPECT_EQ(points->GetFeatureCount(), outlines->GetFeatureCount());
  for (const auto& feature : *points) {
    EXPECT_GE(feature->GetFieldAsDouble("confidence"), 0.3);
    EXPECT_GE(feature->GetFieldAsDouble("length_m"), feature->GetFieldAsDouble("width_m"));
  }
  const cv::Mat picture = cv::imread(village() + "/found.png", cv::IMREAD_UNCHANGED);
  EXPECT_EQ(picture.size(), cv::Size(800, 800));
}

TEST(LandmarksCommand, SaysWhatIsWrong) {
  tests::expect_refusal(run_landfix(village(), "landmarks ortho.tif -o found.shp"), kUsage, {"found.shp", ".gpkg"});
  tests::expect_refusal(run_landfix(village(), "landmarks nothing.tif"), kIo, {"nothing.tif"});
  tests::expect_refusal(run_landfix(village(), "landmarks ortho.tif --model none.model"), kIo, {"none.model"});
  tests::expect_refusal(run_landfix(village(), "landmarks ortho.tif --model buildings.geojson"), kBadInput,
                        {"buildings.geojson", "expected a model of objects", "train-objects"});
  tests::expect_refusal(run_landfix(village(), "eval landmarks --image ortho.tif"), kUsage, {"--points"});
}

TEST(EvalLandmarks, AgainstTheTruthOfAWorld) {
  const tests::Outcome done =
      run_landfix(village(), "eval landmarks --image ortho.tif --truth buildings.geojson --distance-m 3 --json");
  ASSERT_EQ(done.code, kDone) << done.out;
  const json report = json::parse(done.out)["landmarks"];
  bool seen = false;
  for (const json& row : report["by_distance"]) {
    if (row["distance_m"] != 3) continue;
    seen = true;
    EXPECT_GE(row["recall"].get<double>(), 0.85);
    EXPECT_GE(row["precision"].get<double>(), 0.8);
  }
  EXPECT_TRUE(seen);
}

TEST(EvalLandmarks, ListsIntersectionsOneByOne) {
  std::ofstream(village() + "/points.geojson") << R"({"type":"FeatureCollection",
    "crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::32633"}},"features":[
    {"type":"Feature","properties":{"id":7,"kind":"building","sure":true},"geometry":{"type":"Point","coordinates":[500950,5401600]}},
    {"type":"Feature","properties":{"id":8,"kind":"intersection","sure":false},"geometry":{"type":"Point","coordinates":[500860,5401410]}}]})";
  const tests::Outcome done = run_landfix(village(), "eval landmarks --image ortho.tif --points points.geojson");
  ASSERT_EQ(done.code, kDone) << done.out;
  EXPECT_NE(done.out.find("intersection 8 (unsure): "), std::string::npos) << done.out;
  EXPECT_EQ(done.out.find("intersection 7"), std::string::npos) << done.out;
}

TEST(EvalLandmarks, FindsItsOwnAgain) {
  const tests::Outcome done = run_landfix(village(), "eval landmarks --image ortho.tif --again ortho.tif --json");
  ASSERT_EQ(done.code, kDone) << done.out;
  const json again = json::parse(done.out)["again"];
  EXPECT_GT(again["landmarks"]["first"], 10);
  for (const char* what : {"landmarks", "intersections"}) {
    EXPECT_EQ(again[what]["first"], again[what]["both"]) << what;
    EXPECT_EQ(again[what]["second"], again[what]["both"]) << what;
  }
}

const KnownScene& known_village() {
  static const KnownScene kScene = landmarks::read_known_world(village());
  return kScene;
}

// A building of the truth as a region.
Region building(const KnownScene& scene, int id) {
  const cv::Mat mask = scene.objects[size_t(LandmarkClass::kBuilding)] == id;
  Region r;
  r.box = cv::boundingRect(mask);
  r.mask = mask(r.box) / 255;
  r.area_px = cv::countNonZero(r.mask);
  return r;
}

int inner_building(const KnownScene& scene) {
  for (int id = 1; id < 200; ++id) {
    const cv::Rect box = building(scene, id).box;
    if (box.area() > 60 && (box & cv::Rect(30, 30, 340, 340)) == box) return id;
  }
  return 0;
}

TEST(KnownWorld, KnowsItsCovers) {
  const KnownScene& scene = known_village();
  EXPECT_EQ(scene.image.pixels.size(), cv::Size(400, 400));
  for (const int bit : {0, 1, 2, 4}) EXPECT_GT(cv::countNonZero(scene.allowed == (1 << bit)), 200) << "cover " << bit;
}

TEST(KnownWorld, JudgesRegions) {
  const KnownScene& scene = known_village();
  const int id = inner_building(scene);
  ASSERT_GT(id, 0);
  Region r = building(scene, id);
  EXPECT_EQ(landmarks::is_whole(scene, r), std::optional(true));
  r.box.x += 5;  // too far off its middle
  EXPECT_EQ(landmarks::is_whole(scene, r), std::optional(false));
  r = building(scene, id);
  r.mask.rowRange(r.mask.rows / 3, r.mask.rows).setTo(0);  // a third of it
  r.area_px = cv::countNonZero(r.mask);
  EXPECT_EQ(landmarks::is_whole(scene, r), std::optional(false));
}

TEST(KnownWorld, VariesTheSameWayForTheSameSeed) {
  const KnownScene a = varied(known_village(), 200, 5), b = varied(known_village(), 200, 5),
                   c = varied(known_village(), 200, 6);
  ASSERT_EQ(a.image.pixels.size(), cv::Size(200, 200));
  EXPECT_EQ(cv::norm(a.image.pixels, b.image.pixels, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(a.image.pixels, c.image.pixels, cv::NORM_INF), 0);
}

TEST(KnownSpots, JudgeRegions) {
  KnownScene scene;
  scene.image.pixels = cv::Mat(100, 100, CV_8UC3, cv::Scalar(0));
  scene.spotted = {0, 0, 100, 100};
  scene.spots = {{{30, 30}, 120, 12, 10, true}, {{70, 70}, 120, 12, 10, false}};
  const auto at = [](int x, int y, int width, int height) {
    Region r;
    r.box = {x, y, width, height};
    r.mask = cv::Mat::ones(height, width, CV_8U);
    r.area_px = width * height;
    return r;
  };
  EXPECT_EQ(landmarks::is_whole(scene, at(24, 25, 12, 10)), std::optional(true));
  EXPECT_EQ(landmarks::is_whole(scene, at(64, 65, 12, 10)), std::nullopt);          // unsure
  EXPECT_EQ(landmarks::is_whole(scene, at(45, 5, 12, 10)), std::optional(false));   // nothing there
  EXPECT_EQ(landmarks::is_whole(scene, at(24, 25, 40, 10)), std::optional(false));  // far too large
  EXPECT_EQ(landmarks::is_whole(scene, at(95, 95, 12, 10)), std::nullopt);          // beyond the square
}

TEST(TrainObjects, WantsTwoScenes) {
  const std::vector<KnownScene> one = {known_village()};
  EXPECT_THROW(landmarks::train_objects(one, {}), Error);
  tests::expect_refusal(run_landfix(village(), "train-objects nowhere -o x.model"), kIo, {"nowhere"});
}

}  // namespace
}  // namespace landfix
