// `landfix eval` as a user runs it: two seasons of a procedural world, one as the map and one as the camera.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/tools/command.h"
#include "tests/tools/eval_world.h"

namespace landfix::eval {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

using tests::Outcome;

class EvalCommand : public EvalTest {
 protected:
  void SetUp() override {
    EvalTest::SetUp();
    save("summer.tif", summer());
    save("autumn.tif", autumn());
    const Outcome built = run("build summer.tif --layers gray,orientation -o map.lfpack", "build.log");
    ASSERT_EQ(built.code, 0) << text("build.log");
  }

  Outcome run(const std::string& arguments, const std::string& errors = "") const {
    return tests::run_landfix(folder_.string(), arguments, errors);
  }
  std::string text(const std::string& name) const {
    std::ifstream in(path(name));
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void expect_refusal(const std::string& arguments, int code, const std::vector<std::string>& words) const {
    tests::expect_refusal(run(arguments), code, words);
  }
};

TEST_F(EvalCommand, RegisterReportsAllFigures) {
  const std::string common =
      "eval register --map map.lfpack --camera autumn.tif summer.tif --template-m 100 --search-m 60 --hit-m 3 "
      "--samples 15 "
      "--seeds 2 --matcher orientation --matcher gray ";
  const Outcome first = run(common + "--samples-csv samples.csv --picture places.png --json", "errors");
  ASSERT_EQ(first.code, 0) << text("errors");
  const json report = json::parse(first.out);
  EXPECT_EQ(report["map"], "map.lfpack");
  EXPECT_EQ(report["cameras"][0]["name"], "autumn.tif");
  EXPECT_EQ(report["cameras"][0]["bands"], 3);
  const json& orientation = report["matchers"][0];
  EXPECT_EQ(orientation["matcher"], "orientation");
  EXPECT_EQ(orientation["pooled"]["samples"], 60);
  EXPECT_GE(orientation["cameras"][0]["hit_rate"].get<double>(), 0.7);
  EXPECT_EQ(orientation["cameras"][1]["hit_rate"], 1.0) << "the image that the map was made of";
  for (const char* key :
       {"error_of_hits_m", "oracle", "gate", "reliability", "milliseconds", "interval_95", "over_seeds"})
    EXPECT_TRUE(orientation["pooled"].contains(key)) << key;
  const std::string csv = text("samples.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 2 * 2 * 30);
  EXPECT_EQ(text("places.png").substr(1, 3), "PNG");

  const Outcome again = run(common + "--threads 1 --json=again.json", "errors");
  ASSERT_EQ(again.code, 0) << text("errors");
  EXPECT_NE(again.out.find("orientation"), std::string::npos) << "the table stays where JSON goes to a file";
  json a = report["matchers"], b = json::parse(text("again.json"))["matchers"];
  for (json* side : {&a, &b})
    for (json& matcher : *side) {
      matcher["pooled"].erase("milliseconds");
      for (json& camera : matcher["cameras"]) camera.erase("milliseconds");
    }
  EXPECT_EQ(a, b) << "all but the times";
}

TEST_F(EvalCommand, RegisterSaysWhatIsWrong) {
  const std::string few = " --samples 2 --seeds 1";
  expect_refusal("eval", 2, {"subcommand"});
  expect_refusal("eval register --map map.lfpack" + few, 2, {"--camera"});
  expect_refusal("eval register --map map.lfpack --camera autumn.tif --matcher colour" + few, 2,
                 {"colour", "orientation"});
  expect_refusal("eval register --map map.lfpack --camera autumn.tif --template-m 5000" + few, 3, {"template", "5000"});
  expect_refusal("eval register --map map.lfpack --camera autumn.tif --template-m nan" + few, 2, {"--template-m"});
  expect_refusal("eval register --map map.lfpack --camera nowhere.tif" + few, 7, {"nowhere.tif"});
  expect_refusal("eval register --map autumn.tif --camera autumn.tif" + few, 4, {"autumn.tif"});
  features::GridImage elsewhere = autumn();
  elsewhere.west_m += 5000;
  save("elsewhere.tif", elsewhere);
  expect_refusal("eval register --map map.lfpack --camera elsewhere.tif" + few, 6, {"elsewhere.tif", "overlap"});
}

TEST_F(EvalCommand, NavigabilityIsComparedWithWhatHappens) {
  const Outcome built = run(
      "build summer.tif --date summer.tif=2020-07-01 --layers gray,orientation --navigability 100/60 -o judged.lfpack",
      "build.log");
  ASSERT_EQ(built.code, 0) << text("build.log");
  const std::string common =
      "eval navigability --map judged.lfpack --camera autumn.tif --template-m 100 --search-m 60 "
      "--hit-m 9.375 --samples 30 ";
  const Outcome first =
      run(common + "--camera-date 2024-07-01 --matcher all --samples-csv samples.csv --json", "errors");
  ASSERT_EQ(first.code, 0) << text("errors");
  EXPECT_EQ(text("errors").find("nearest"), std::string::npos) << text("errors");
  const json report = json::parse(first.out);
  EXPECT_EQ(report["cameras"][0]["date"], "2024-07-01");
  EXPECT_EQ(report["cameras"][0]["judged_for"]["template_m"], 100);
  const json& pooled = report["matchers"][0]["pooled"];
  EXPECT_EQ(report["matchers"][0]["matcher"], "auto");
  EXPECT_EQ(pooled["samples"], 30);
  EXPECT_GE(pooled["true_fixes"], 20) << "the world that EvalCommand.RegisterReportsAllFigures registers";
  EXPECT_NEAR(pooled["mean_age_years"].get<double>(), 4, 0.01);
  int counted = 0;
  for (const json& bin : pooled["calibration"]) counted += bin["count"].get<int>();
  EXPECT_EQ(counted, 30);
  for (const char* name : {"entropy", "standard_deviation", "edge_density", "fisher_information"})
    EXPECT_TRUE(pooled["auc_of"].contains(name)) << name;
  EXPECT_EQ(text("samples.csv").find("judged.lfpack,autumn.tif,auto,0,"), text("samples.csv").find('\n') + 1);

  // The places, and what happens at them, are those of `eval register`.
  const Outcome registered =
      run("eval register --map judged.lfpack --camera autumn.tif --template-m 100 --search-m 60 "
          "--hit-m 9.375 --samples 30 --seeds 1 --json",
          "errors");
  ASSERT_EQ(registered.code, 0) << text("errors");
  EXPECT_NEAR(json::parse(registered.out)["matchers"][0]["pooled"]["hit_rate"].get<double>(),
              pooled["true_fixes"].get<double>() / 30, 1e-9);

  // Without a date chances are as in the map: higher than for a map of four years.
  const Outcome undated = run(common + "--threads 1 --json=undated.json", "errors");
  ASSERT_EQ(undated.code, 0) << text("errors");
  EXPECT_NE(undated.out.find("AUC"), std::string::npos) << "the table stays where JSON goes to a file";
  const auto mean_stated = [](const json& figures) {
    double sum = 0;
    for (const json& bin : figures["calibration"])
      if (bin["count"] > 0) sum += bin["count"].get<double>() * bin["predicted"].get<double>();
    return sum / figures["samples"].get<double>();
  };
  const json without = json::parse(text("undated.json"));
  EXPECT_TRUE(without["cameras"][0]["date"].is_null());
  EXPECT_GT(mean_stated(without["matchers"][0]["pooled"]), mean_stated(pooled) + 0.01);
}

TEST_F(EvalCommand, NavigabilitySaysWhatIsWrong) {
  const std::string start = "eval navigability --map map.lfpack --camera autumn.tif --template-m 100 --search-m 60 ";
  expect_refusal(start, 6, {"map.lfpack", "--navigability"});
  expect_refusal(start + "--samples 3", 2, {"--samples 3", "20"});
  expect_refusal(start + "--camera-date 2018-13-01", 2, {"--camera-date 2018-13-01"});
  expect_refusal(start + "--map map.lfpack --map map.lfpack", 2, {"3 --map", "1 --camera"});
  expect_refusal(start + "--matcher colour", 2, {"colour"});
  expect_refusal("eval navigability --map map.lfpack", 2, {"--camera"});
  const Outcome built =
      run("build summer.tif --layers orientation --navigability 100/60 -o judged.lfpack", "build.log");
  ASSERT_EQ(built.code, 0) << text("build.log");
  features::GridImage elsewhere = autumn();
  elsewhere.west_m += 5000;
  save("elsewhere.tif", elsewhere);
  expect_refusal("eval navigability --map judged.lfpack --camera elsewhere.tif", 6, {"elsewhere.tif", "overlap"});
}

TEST_F(EvalCommand, PairsAndPhotos) {
  expect_refusal("eval pairs --a nowhere --b nowhere", 7, {"nowhere"});
  fs::create_directories(path("a"));
  features::GridImage part = summer();
  part.pixels = summer().pixels(cv::Rect(100, 100, 200, 200)).clone();
  part.valid.release();
  save("a/one.png", part);
  const Outcome pairs = run("eval pairs --a a --b a --template-px 100 --placements 2 --matcher gray --json", "errors");
  ASSERT_EQ(pairs.code, 0) << text("errors");
  EXPECT_EQ(json::parse(pairs.out)["matchers"][0]["pooled"]["hit_rate"], 1.0);

  const Outcome photos = run("eval photos --map map.lfpack a/one.png --picture photos.png --json", "errors");
  ASSERT_EQ(photos.code, 0) << text("errors");
  const json photo = json::parse(photos.out)["photos"][0];
  EXPECT_EQ(photo["fix"], false);
  EXPECT_EQ(photo["status"], "unusable") << "a PNG without tags";
  EXPECT_NE(photo["reason"].get<std::string>().find("GPSLatitude"), std::string::npos);
  EXPECT_EQ(text("photos.png").substr(1, 3), "PNG");
  expect_refusal("eval photos --map map.lfpack nowhere.jpg", 7, {"nowhere.jpg"});
}

// One line says what is wrong; the libraries that decode images keep quiet.
TEST_F(EvalCommand, PairsThatCannotBeDecodedAreSaidOnce) {
  save("whole.png", summer());
  const std::string png = text("whole.png"), tif = text("summer.tif");
  for (const auto& [name, bytes] : {std::pair<std::string, std::string>("text.jpg", "no image"),
                                    {"head.png", png.substr(0, 40)},
                                    {"half.tif", tif.substr(0, tif.size() / 2)}}) {
    const std::string folder = "bad_" + name.substr(0, 4);
    fs::create_directories(path(folder));
    std::ofstream(path(folder + "/" + name), std::ios::binary) << bytes;
    const Outcome outcome = run("eval pairs --a " + folder + " --b " + folder);
    EXPECT_EQ(outcome.code, 3) << outcome.out;
    EXPECT_EQ(outcome.out.rfind("landfix: " + folder + "/" + name + ": the image cannot be decoded", 0), 0u)
        << outcome.out;
    EXPECT_EQ(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 1) << outcome.out;
  }
}

TEST_F(EvalCommand, HelpSaysHowJsonMayBeGiven) {
  const auto expect_words = [&](const std::string& arguments, const std::vector<std::string>& words) {
    const Outcome help = run(arguments);
    EXPECT_EQ(help.code, 0);
    for (const std::string& word : words) EXPECT_NE(help.out.find(word), std::string::npos) << word << ": " << help.out;
    EXPECT_EQ(help.out.find("{-}"), std::string::npos) << help.out;
  };
  expect_words("eval --help", {"Examples:", "landfix eval register", "landfix eval pairs", "landfix eval photos"});
  for (const std::string command : {"register", "pairs", "photos"})
    expect_words("eval " + command + " --help", {"--json[=FILE] ", "Example", "landfix eval " + command});
  expect_refusal("eval pairs", 2, {"'landfix eval pairs --help'"});
}

}  // namespace
}  // namespace landfix::eval
