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
