// `landfix train`, `eval landmarks` and `classify` as users meet them, on a small procedural world.
#include <gdal_priv.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/tools/command.h"
#include "tests/tools/eval_world.h"

namespace landfix::eval {
namespace {

using nlohmann::json;
using tests::Outcome;
constexpr int kDone = 0, kUsage = 2, kBadInput = 3, kIo = 7;

class LandmarkCommand : public EvalTest {
 protected:
  Outcome run(const std::string& arguments) const { return tests::run_landfix(path(""), arguments); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path(name)) << text;
    return path(name);
  }
  /// Squares of 40 m over the image of summer(), whose grid is its CRS.
  std::string chips(const std::string& label) const {
    return write("chips.csv", "id,x,y,size_m,label\na," + std::to_string(kWestM + 100) + "," +
                                  std::to_string(kNorthM - 100) + ",40," + label + "\n");
  }
};

TEST_F(LandmarkCommand, TheModelOfTheTreeClassifiesAnImage) {
  save("summer.tif", summer());
  const Outcome outcome = run("classify summer.tif -o classes.tif --picture classes.png --confidence sure.tif --json");
  ASSERT_EQ(outcome.code, kDone) << outcome.out;
  const json areas = json::parse(outcome.out).at("square_km");
  double total = 0;
  for (const auto& [name, area] : areas.items()) total += area.get<double>();
  EXPECT_NEAR(total, 0.64, 0.03);  // 800 m x 800 m
  const GDALDatasetUniquePtr file(GDALDataset::Open(path("classes.tif").c_str()));
  ASSERT_TRUE(file);
  EXPECT_EQ(file->GetRasterXSize(), 200);  // windows 4 m apart
  const GDALColorTable* colours = file->GetRasterBand(1)->GetColorTable();
  ASSERT_NE(colours, nullptr);
  EXPECT_EQ(colours->GetColorEntry(0)->c1, 225);  // buildings are red
  EXPECT_TRUE(std::filesystem::exists(path("classes.png")));
}

// A file whose bands lie the other way round, and which does not say so.
TEST_F(LandmarkCommand, BandsAreWhatTheCommandLineSays) {
  save("right.tif", summer());
  features::GridImage turned = summer();
  cv::cvtColor(summer().pixels, turned.pixels, cv::COLOR_RGB2BGR);
  save("turned.tif", turned);
  for (const std::string command : {"landmarks", "roads", "classify"}) {
    const std::string right = run(command + " right.tif").out;
    EXPECT_EQ(run(command + " turned.tif --bands blue,green,red").out, right) << command;
    EXPECT_NE(run(command + " turned.tif").out, right) << command;
    tests::expect_refusal(run(command + " turned.tif --bands blue,green"), kUsage, {"turned.tif", "3 bands"});
  }
  tests::expect_refusal(run("classify photo.jpg --bands red,green,blue"), kUsage, {"--bands", "photographs"});
}

TEST_F(LandmarkCommand, AskedAboutChipsItPrintsTheirConfusion) {
  save("summer.tif", summer());
  chips("field");
  const Outcome outcome = run("eval landmarks --image summer.tif --chips chips.csv --json");
  ASSERT_EQ(outcome.code, kDone) << outcome.out;
  const json result = json::parse(outcome.out);
  EXPECT_EQ(result.at("labels").size(), 6u);
  EXPECT_EQ(result.at("overall").at("of"), 1);
  EXPECT_LT(result.at("overall").at("low"), result.at("overall").at("high"));
}

TEST_F(LandmarkCommand, BadInputIsRefusedWithWhatToDo) {
  save("summer.tif", summer());
  chips("house");
  tests::expect_refusal(run("eval landmarks --image summer.tif --chips chips.csv"), kBadInput, {"line 2", "'house'"});
  chips("tree");
  tests::expect_refusal(run("train --chips chips.csv=summer.tif -o out.model"), kBadInput, {"at least two classes"});
  EXPECT_FALSE(std::filesystem::exists(path("out.model")));
  tests::expect_refusal(run("train -o out.model"), kUsage, {"--chips", "--synthetic"});
  tests::expect_refusal(run("train --vectors a.gpkg -o out.model"), kUsage, {"--image"});
  write("bad.model", "not a model");
  tests::expect_refusal(run("classify summer.tif --model bad.model"), kBadInput, {"bad.model", "landfix train"});
  tests::expect_refusal(run("classify summer.tif --model none.model"), kIo, {"none.model"});
  tests::expect_refusal(run("classify summer.tif --step-m 3"), kUsage, {"2, 4, 6"});
  features::GridImage tiny = summer();
  tiny.pixels = tiny.pixels(cv::Rect(0, 0, 3, 3)).clone();
  save("tiny.tif", tiny);
  tests::expect_refusal(run("classify tiny.tif"), kBadInput, {"tiny.tif", "24 m"});
  tests::expect_refusal(run("classify summer.tif -o classes.png"), kUsage, {".tif"});
}

}  // namespace
}  // namespace landfix::eval
