// `landfix route` as a user runs it: every format in and out, and what is wrong with missions and requirements.
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "builder/error.h"
#include "tests/mission/files.h"
#include "tests/route/missions.h"
#include "tests/route/packs.h"
#include "tests/tools/command.h"

namespace landfix::route {
namespace {

using nlohmann::json;
using tests::expect_refusal;
using tests::Outcome;

/// 6 by 6 km of good ground with a lake of 1.2 by 2.4 km in it; nothing known around.
class RouteCommand : public NavigablePack {
 protected:
  void SetUp() override {
    NavigablePack::SetUp();
    draw([](double x, double y) {
      tiles::Navigability n = place(0.95);
      n.false_probability = 0.001;
      if (x > 2400 && x < 3600 && y > 1000 && y < 3400) {
        n = place(0.005);
        n.reasons = 1u << unsigned(tiles::Reason::kWater);
      }
      return n;
    });
  }

  /// Another map instead.
  void draw(const std::function<tiles::Navigability(double, double)>& what) {
    description_.layers.clear();
    add({120, 160}, [&](double x, double y) {
      return x < 0 || y < 0 || x > 6000 || y > 6000 ? std::nullopt : std::optional(what(x, y));
    });
    written();
  }

  Outcome run(const std::string& arguments) const {
    return tests::run_landfix(folder_, "route " + arguments + " --map map.lfpack");
  }
  json json_of(const std::string& arguments) const {
    const Outcome outcome = run(arguments + " --json");
    EXPECT_EQ(outcome.code, 0) << outcome.out;
    return json::parse(outcome.out.substr(outcome.out.find('{')), nullptr, false);
  }
  std::string bytes_of(const std::string& name) const {
    std::ifstream in(folder_ + "/" + name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ + "/" + name, std::ios::binary) << text;
  }
  /// A line across the map, 120 m above ground; or from there to there.
  void write_line(double from_x = 500, double to_x = 5500, double altitude_m = 120) const {
    write("line.geojson", fmt::format(R"({{"type": "Feature", "properties": {{"altitude_reference": "terrain"}},
                           "geometry": {{"type": "LineString", "coordinates": [{}, {}]}}}})",
                                      position(from_x, 2000, altitude_m), position(to_x, 2000, altitude_m)));
  }
  static std::string lonlat(double x_m, double y_m) {
    const auto p = tiles::geodetic_from_grid(kZone, kEast + x_m, kNorth + y_m);
    return fmt::format("{:.8f},{:.8f}", p->longitude_rad * 180 / M_PI, p->latitude_rad * 180 / M_PI);
  }
  static std::string position(double x_m, double y_m, double altitude_m) {
    return fmt::format("[{}, {}]", lonlat(x_m, y_m), altitude_m);
  }
};

// The straight way crosses 1200 m of water: the longest gap, and the requirement is missed there. The report is
// written.
TEST_F(RouteCommand, ScoresALine) {
  write_line();
  const json score = json_of("score line.geojson --html line.html");
  EXPECT_NEAR(score["length_m"].get<double>(), 5000, 5);
  EXPECT_NEAR(score["longest_gap"]["length_m"].get<double>(), 1200, 80);
  EXPECT_EQ(score["worst_stretch"]["reason"], "water");
  EXPECT_FALSE(score["met"].get<bool>());
  EXPECT_GT(bytes_of("line.html").size(), 20'000u);
  const Outcome table = run("score line.geojson");
  EXPECT_NE(table.out.find("required 10 m at 95 %: not met"), std::string::npos) << table.out;
}

// What is suggested goes around the lake; each format that it is written in is read back as the same route.
TEST_F(RouteCommand, SuggestsAndWritesWhatItReads) {
  const std::string places = "--from=" + lonlat(500, 2000) + " --to=" + lonlat(5500, 2000);
  for (const char* file : {"way.plan", "way.waypoints", "way.gpx", "way.geojson"}) {
    SCOPED_TRACE(file);
    const json suggested = json_of("suggest " + places + " --agl 120 -o " + file)["alternatives"][1]["score"];
    EXPECT_TRUE(suggested["met"].get<bool>());
    EXPECT_LT(suggested["length_m"].get<double>(), 5700);
    const json score = json_of(std::string("score ") + file);
    EXPECT_NEAR(score["length_m"].get<double>(), suggested["length_m"].get<double>(), 2);
    EXPECT_TRUE(score["met"].get<bool>());
  }
}

// A plan with a survey, a fence across the northern way and a rally point: the detour is put before the second
// waypoint, and everything else is as it was.
TEST_F(RouteCommand, KeepsAMissionsItems) {
  const std::string survey = fmt::format(
      R"({{"type": "ComplexItem", "complexItemType": "survey", "version": 5, "polygon": [[{0}], [{1}], [{2}]], "TransectStyleComplexItem":
          {{"version": 2, "CameraCalc": {{"DistanceToSurface": 120}}, "VisualTransectPoints": [[{0}], [{1}], [{2}]],
            "Items": [{3}, {4}]}}}})",
      degrees_at(5000, 3000), degrees_at(5000, 4000), degrees_at(5500, 4000),
      item(3, 16, 10, "0, 0, 0, null", degrees_at(5000, 3000), 120),
      item(4, 16, 10, "0, 0, 0, null", degrees_at(5000, 4000), 120));
  const std::string fence =
      fmt::format(R"({{"inclusion": false, "version": 1, "polygon": [[{}], [{}], [{}], [{}]]}})",
                  degrees_at(2900, 3300), degrees_at(3100, 3300), degrees_at(3100, 5990), degrees_at(2900, 5990));
  const std::string before = plan(item(1, 16, 10, "0, 0, 0, null", degrees_at(500, 2200), 120) + ", " +
                                      item(2, 16, 10, "0, 0, 0, null", degrees_at(5500, 2200), 120) + ", " + survey,
                                  fence)
                                 .text;
  write("before.plan", before);
  const json suggestion = json_of("suggest before.plan -o after.plan");
  EXPECT_TRUE(suggestion["met"].get<bool>());
  const json was = json::parse(before), is = json::parse(bytes_of("after.plan"));
  EXPECT_EQ(is["geoFence"], was["geoFence"]);
  EXPECT_EQ(is["rallyPoints"], was["rallyPoints"]);
  const json &items = is["mission"]["items"], &items_before = was["mission"]["items"];
  ASSERT_GT(items.size(), 3u);
  EXPECT_EQ(items.front(), items_before.front());
  EXPECT_EQ(items.back(), items_before.back());
  double south = 90;
  for (size_t i = 1; i + 2 < items.size(); ++i) south = std::min(south, items[i]["params"][4].get<double>());
  EXPECT_LT(south, std::stod(degrees_at(3000, 1000)));  // around the southern end
}

// From 60 m the view is half of the map's, a fix four times less likely; 120 m are better.
TEST_F(RouteCommand, ComparesAltitudes) {
  write_line(500, 2200);
  const json altitudes = json_of("altitude line.geojson --heights 30,120");
  EXPECT_EQ(altitudes["best_agl_m"], 120);
  EXPECT_LT(altitudes["altitudes"][0]["mean_fix_probability"].get<double>(), 0.1);
}

TEST_F(RouteCommand, RefusesMissionsThatCannotBeFlown) {
  write_line(7000, 9000);
  expect_refusal(run("score line.geojson"), int(ExitCode::kNoData),
                 {"line.geojson", "expected a route over ground that the map knows", "choose"});
  write_line(500, 5500, -20);
  expect_refusal(run("score line.geojson"), int(ExitCode::kBadInput),
                 {"line.geojson: point 2", "20 m below", "fly higher"});
  write("bare.gpx", mission::edited(mission::kGpxText, " lat=\"47.2\" lon=\"8.2\"", ""));
  expect_refusal(run("score bare.gpx"), int(ExitCode::kBadInput), {"bare.gpx", "rtept 2"});
  const std::string text = plan(item(1, 16, 10, "0, 0, 0, null", degrees_at(500, 2200), 120) + ", " +
                                item(2, 16, 10, "0, 0, 0, null", degrees_at(900, 2200), 120))
                               .text;
  write("nowhere.plan", mission::edited(text, degrees_at(900, 2200), "null, null"));
  expect_refusal(run("score nowhere.plan"), int(ExitCode::kBadInput),
                 {"nowhere.plan", "items[1]", "give the item a position"});
  write("cut.plan", text.substr(0, text.size() / 2));
  expect_refusal(run("score cut.plan"), int(ExitCode::kBadInput), {"cut.plan", "cut"});
  expect_refusal(run("score none.plan"), int(ExitCode::kIo), {"none.plan"});
  write("low.gpx", mission::kGpxText);
  expect_refusal(run("score low.gpx --require 10m"), int(ExitCode::kUsage), {"10m@95%"});
  expect_refusal(run("score low.gpx --date tomorrow"), int(ExitCode::kUsage), {"--date", "tomorrow"});
  expect_refusal(run("score low.gpx --corridor nan"), int(ExitCode::kUsage), {"--corridor", "nan"});
}

// Numbers that no aircraft flies are refused, not scored.
TEST_F(RouteCommand, RefusesHeightsAndSpeedsOfNoAircraft) {
  for (const double height_m : {1e300, 30'000.0}) {
    write_line(500, 5500, height_m);
    expect_refusal(run("score line.geojson"), int(ExitCode::kBadInput), {"line.geojson", "at most 20000 m"});
  }
  write_line();
  for (const char* speed : {"1e-300", "1e300"})
    expect_refusal(run(std::string("score line.geojson --speed ") + speed), int(ExitCode::kBadInput),
                   {"line.geojson", "expected a speed from 0.01 to 1000 m/s"});
  const std::string places = "suggest --from=" + lonlat(500, 2000) + " --to=" + lonlat(5500, 2000);
  expect_refusal(run(places + " --altitude 399"), int(ExitCode::kBadInput), {"--altitude 399", "400 m", "fly higher"});
  for (const char* band : {"200,100", "nan,100"})
    expect_refusal(run(places + " --band " + band), int(ExitCode::kUsage), {"--band", "lower height"});
  std::filesystem::create_directories(folder_ + "/folder");
  expect_refusal(run(places + " --no-fly folder"), int(ExitCode::kIo), {"folder", "nothing to read"});
}

// What stands where the report shall go stays: a folder, and a pipe, which a file of its name would destroy.
TEST_F(RouteCommand, ReplacesNothingButFiles) {
  write_line();
  std::filesystem::create_directories(folder_ + "/folder.html");
  ASSERT_EQ(mkfifo((folder_ + "/pipe.html").c_str(), 0600), 0);
  for (const char* name : {"folder.html", "pipe.html"}) {
    const auto before = std::filesystem::status(folder_ + "/" + name).type();
    const Outcome outcome = run(std::string("score line.geojson --html ") + name);
    expect_refusal(outcome, int(ExitCode::kIo), {name, "choose another name"});
    EXPECT_NE(outcome.out.find("not met"), std::string::npos) << "the score is not lost";
    EXPECT_EQ(std::filesystem::status(folder_ + "/" + name).type(), before);
  }
}

TEST_F(RouteCommand, SaysWhereTheGroundIsAssumed) {
  write_line();
  EXPECT_NE(run("score line.geojson").out.find("taken for a plane 400 m above the ellipsoid"), std::string::npos);
}

// Half on the map: scored, with the share that is not.
TEST_F(RouteCommand, ScoresRoutesThatLeaveTheMap) {
  write_line(4000, 8000);
  const Outcome outcome = run("score line.geojson");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(outcome.out.find("of the route lie where the map knows nothing"), std::string::npos) << outcome.out;
  expect_refusal(run("suggest --from=" + lonlat(500, 2000) + " --to=" + lonlat(12000, 2000)), int(ExitCode::kNoData),
                 {"expected places on the map", "choose others"});
}

// 1200 m of water from edge to edge: where, why, and what the best route reaches; the file is written all the same.
TEST_F(RouteCommand, SaysWhatCannotBeMet) {
  draw([](double x, double) {
    tiles::Navigability n = place(x > 2400 && x < 3600 ? 0.005 : 0.95);
    n.false_probability = 0;
    if (x > 2400 && x < 3600) n.reasons = 1u << unsigned(tiles::Reason::kWater);
    return n;
  });
  const Outcome outcome = run("suggest --from=" + lonlat(500, 2000) + " --to=" + lonlat(5500, 2000) + " -o way.plan");
  EXPECT_EQ(outcome.code, 0);
  for (const char* word : {"no route was found that keeps 10 m at 95 %", "water", "m after the start", "are reached"})
    EXPECT_NE(outcome.out.find(word), std::string::npos) << outcome.out;
  EXPECT_FALSE(bytes_of("way.plan").empty());
}

TEST_F(RouteCommand, RefusesAMapWithoutNavigablePlaces) {
  draw([](double, double) { return place(0.004); });
  expect_refusal(run("suggest --from=" + lonlat(500, 2000) + " --to=" + lonlat(5500, 2000)), int(ExitCode::kNoData),
                 {"expected places where an image gives a fix", "finer or newer imagery"});
}

// Flights over a world in another year: what is predicted of a straight way and what was flown stand side by side, the
// same for any number of threads; and a pair of places needs room.
TEST(EvalRoute, FliesWhatItPredicts) {
  const std::string folder = testing::TempDir() + "eval_route_" + std::to_string(::getpid());
  std::filesystem::create_directories(folder);
  const auto run = [&](const std::string& arguments) { return tests::run_landfix(folder, arguments, "errors"); };
  const std::string world = " --seed 5 --size-m 1100 --gsd 2 --dem-gsd 16 --relief-m 5";
  ASSERT_EQ(run("synth -o a --season summer --year 2018" + world).code, 0);
  ASSERT_EQ(run("synth -o b --season autumn --year 2019" + world).code, 0);
  ASSERT_EQ(run("synth -o c --season summer --year 2020" + world).code, 0);
  ASSERT_EQ(run("build a/ortho.tif b/ortho.tif --navigability 80/40 --layers orientation -o map.lfpack").code, 0);
  const std::string command =
      "eval route --map map.lfpack --scene c/ortho.tif --agl 80 --image-interval 2 --routes 1 --runs 2 --json "
      "--length-m ";
  const Outcome one = run(command + "600 --threads 1"), two = run(command + "600 --threads 2");
  ASSERT_EQ(one.code, 0) << one.out;
  EXPECT_EQ(one.out, two.out);
  const json straight = json::parse(one.out)["trials"][0]["straight"];
  EXPECT_NEAR(straight["length_m"].get<double>(), 600, 1e-6);
  EXPECT_GT(straight["flown_rms_m"].get<double>(), 0.3);  // no flight is as good as that,
  EXPECT_LT(straight["flown_rms_m"].get<double>(), 8);    // and dead reckoning, 15 m at the end, is worse than this
  EXPECT_LT(straight["predicted_rms_m"].get<double>(), 8);
  EXPECT_EQ(run(command + "5000").code, int(ExitCode::kNoData));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace landfix::route
