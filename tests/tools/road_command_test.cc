// `landfix roads`, `train-roads` and `eval roads` as a user runs them, on a procedural world.
#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogrsf_frmts.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/tools/command.h"

namespace landfix {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using tests::Outcome;

constexpr int kUsage = 2, kBadInput = 3, kIo = 7;

class RoadCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::temp_directory_path() / ("landfix_roads_" + std::to_string(getpid()));
    fs::create_directories(folder_);
    const Outcome drawn = run("synth -o world --seed 31 --size-m 700 --gsd 1");
    ASSERT_EQ(drawn.code, 0) << drawn.out;
    const Outcome small = run("synth -o small --seed 32 --size-m 250 --gsd 1");
    ASSERT_EQ(small.code, 0) << small.out;
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }

  static Outcome run(const std::string& arguments) { return tests::run_landfix(folder_.string(), arguments); }
  static std::string bytes_of(const std::string& name) {
    std::ifstream in(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  static void write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
  }

  static inline fs::path folder_;
};

TEST_F(RoadCommand, RoadsAreFoundDrawnAndWritten) {
  const Outcome outcome = run("roads world/ortho.tif -o roads.gpkg --picture roads.png");
  ASSERT_EQ(outcome.code, 0) << outcome.out;
  EXPECT_NE(outcome.out.find("km of roads in"), std::string::npos) << outcome.out;
  EXPECT_GT(fs::file_size(folder_ / "roads.png"), 100000u);
  GDALAllRegister();
  const GDALDatasetUniquePtr file(GDALDataset::Open((folder_ / "roads.gpkg").c_str(), GDAL_OF_VECTOR));
  ASSERT_NE(file, nullptr);
  OGRLayer* roads = file->GetLayerByName("roads");
  ASSERT_NE(roads, nullptr);
  EXPECT_GT(roads->GetFeatureCount(), 3);
  for (const auto& feature : *roads) {
    EXPECT_GT(feature->GetFieldAsDouble("confidence"), 0.2);
    EXPECT_GT(feature->GetFieldAsDouble("width_m"), 2);
  }
  EXPECT_GT(file->GetLayerByName("intersections")->GetFeatureCount(), 0);
}

TEST_F(RoadCommand, TheRoadsDoNotDependOnThreads) {
  ASSERT_EQ(run("roads world/ortho.tif -o one.gpkg --threads 1 > one.txt").code, 0);
  ASSERT_EQ(run("roads world/ortho.tif -o two.gpkg --threads 2 > two.txt").code, 0);
  EXPECT_EQ(bytes_of("one.txt"), bytes_of("two.txt"));
  const json a =
      json::parse(run("eval roads --image world/ortho.tif --truth world/roads.geojson --threads 1 --json").out);
  const json b =
      json::parse(run("eval roads --image world/ortho.tif --truth world/roads.geojson --threads 2 --json").out);
  EXPECT_EQ(a, b);
}

TEST_F(RoadCommand, EvaluationReportsWhatWasFound) {
  const Outcome outcome =
      run("eval roads --image world/ortho.tif --truth world/roads.geojson --intersections world/intersections.geojson "
          "--json");
  ASSERT_EQ(outcome.code, 0) << outcome.out;
  const json report = json::parse(outcome.out);
  // A world that the model was not trained on; the aims are 0.85 and 0.95.
  EXPECT_GT(report["completeness"].get<double>(), 0.85);
  EXPECT_GT(report["correctness"].get<double>(), 0.9);
  EXPECT_GT(report["intersections"]["true"].get<int>(), 2);
  EXPECT_GE(report["intersections"]["matched"].get<int>(), report["intersections"]["true"].get<int>() * 2 / 3);
  // Within a tenth of a metre nearly nothing agrees.
  const Outcome strict =
      run("eval roads --image world/ortho.tif --truth world/roads.geojson --line-m 0.02 --node-m 0.02 --json");
  EXPECT_LT(json::parse(strict.out)["completeness"].get<double>(), 0.3);
}

TEST_F(RoadCommand, TrainingGivesTheSameModelEachTime) {
  for (const char* name : {"a.model", "b.model"}) {
    const Outcome outcome = run(std::string("train-roads small --variations 0 -o ") + name);
    ASSERT_EQ(outcome.code, 0) << outcome.out;
  }
  EXPECT_EQ(bytes_of("a.model"), bytes_of("b.model"));
  const Outcome used = run("roads small/ortho.tif --model a.model");
  EXPECT_EQ(used.code, 0) << used.out;
}

TEST_F(RoadCommand, DrawnLinesTeachToo) {
  // The truth itself as what was drawn, in a window over the whole world.
  std::string lines = bytes_of("small/roads.geojson");
  const json roads = json::parse(lines);
  double west = 180, east = -180, south = 90, north = -90;
  for (const json& f : roads["features"]) {
    for (const json& p : f["geometry"]["coordinates"]) {
      west = std::min(west, p[0].get<double>());
      east = std::max(east, p[0].get<double>());
      south = std::min(south, p[1].get<double>());
      north = std::max(north, p[1].get<double>());
    }
  }
  json with_window = roads;
  with_window["features"].push_back(
      {{"type", "Feature"},
       {"properties", json::object()},
       {"geometry",
        {{"type", "Polygon"},
         {"coordinates", {{{west, south}, {east, south}, {east, north}, {west, north}, {west, south}}}}}}});
  write("drawn.geojson", with_window.dump());
  const Outcome outcome = run("train-roads small --variations 0 --drawn small/ortho.tif=drawn.geojson -o drawn.model");
  EXPECT_EQ(outcome.code, 0) << outcome.out;
  const Outcome plain = run("train-roads small --variations 0 -o plain.model");
  EXPECT_NE(bytes_of("drawn.model"), bytes_of("plain.model"));
  tests::expect_refusal(run("train-roads small --drawn small/ortho.tif -o x.model"), kUsage, {"IMAGE=LINES"});
  tests::expect_refusal(run("train-roads small --variations 0 --drawn small/ortho.tif=small/roads.geojson -o x.model"),
                        kBadInput, {"roads.geojson", "polygons"});
  EXPECT_FALSE(fs::exists(folder_ / "x.model"));
}

TEST_F(RoadCommand, SaysWhatIsWrong) {
  tests::expect_refusal(run("roads missing.tif"), kIo, {"missing.tif"});
  tests::expect_refusal(run("roads world/ortho.tif -o roads.shp"), kUsage, {".gpkg"});
  tests::expect_refusal(run("roads world/ortho.tif --model missing.model"), kIo, {"missing.model"});
  write("bad.model", "this is no model of roads");
  tests::expect_refusal(run("roads world/ortho.tif --model bad.model"), kBadInput,
                        {"bad.model", "not a model of trees"});
  tests::expect_refusal(run("eval roads --image world/ortho.tif --truth missing.geojson"), kIo, {"missing.geojson"});
  tests::expect_refusal(run("eval roads --image world/ortho.tif --truth world/trees.geojson"), kBadInput,
                        {"trees.geojson", "lines"});
  tests::expect_refusal(run("train-roads nowhere -o x.model"), kIo, {"nowhere"});
}

}  // namespace
}  // namespace landfix
