// Missions written: new ones, and plans and waypoint files changed in places while everything else stays as it was.
#include "tools/mission/write.h"

#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/mission/files.h"

namespace landfix::mission {
namespace {

using enum AltitudeReference;
using Json = nlohmann::ordered_json;

const std::vector<Place> kPath = {place(47.3, 8.3, 90.5, kHome), place(47.4, 8.4, 650, kSeaLevel),
                                  place(47.5, -8.5, 70, kTerrain)};
const std::vector<Place> kSeaPath = {place(47.3, 8.3, 590.5, kSeaLevel), place(47.4, 8.4, 650, kSeaLevel)};

NewFile about() {
  NewFile about;
  about.name = "over <hill> & dale";
  about.home = place(47.1, 8.1, 431.25, kSeaLevel);
  about.speed_mps = 14;
  return about;
}

std::string refusal_of(const std::function<void()>& write) {
  try {
    write();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kUsage) << e.what();
    return e.what();
  }
  return "";
}

std::vector<Place> places(const Mission& mission) {
  std::vector<Place> found;
  for (const Waypoint& waypoint : mission.waypoints) found.push_back(waypoint.place);
  return found;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

class NewMission : public testing::TestWithParam<Format> {};

/// What is written reads back as it was: places, speed, home.
TEST_P(NewMission, ReadsBack) {
  const bool items = GetParam() == Format::kPlan || GetParam() == Format::kWaypoints;
  const std::vector<Place>& path = items ? kPath : kSeaPath;
  const Mission mission = parse_mission(new_mission(GetParam(), path, about()), "written");
  EXPECT_EQ(mission.format, GetParam());
  EXPECT_EQ(places(mission), path);
  EXPECT_TRUE(mission.notes.empty());
  if (items) {
    EXPECT_EQ(mission.home, about().home);
  }
  if (GetParam() != Format::kGpx) {
    ASSERT_TRUE(mission.waypoints[0].speed);
    EXPECT_EQ(mission.waypoints[0].speed->mps, 14);
    EXPECT_FALSE(mission.waypoints[0].speed->through_air);
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, NewMission,
                         testing::Values(Format::kPlan, Format::kWaypoints, Format::kGpx, Format::kGeoJson));

/// The keys, and types of keys, without which QGroundControl refuses a plan.
TEST(NewPlan, HasWhatQGroundControlRequires) {
  const Json plan = Json::parse(new_mission(Format::kPlan, kPath, about()));
  EXPECT_EQ(plan["fileType"], "Plan");
  EXPECT_EQ(plan["version"], 1);
  EXPECT_EQ(plan["geoFence"], Json::parse(R"({"circles": [], "polygons": [], "version": 2})"));
  EXPECT_EQ(plan["rallyPoints"], Json::parse(R"({"points": [], "version": 2})"));
  const Json& mission = plan["mission"];
  EXPECT_EQ(mission["version"], 2);
  EXPECT_EQ(mission["firmwareType"], 12);
  EXPECT_EQ(mission["vehicleType"], 2);
  EXPECT_EQ(mission["plannedHomePosition"], Json({47.1, 8.1, 431.25}));
  ASSERT_EQ(mission["items"].size(), 4u);
  const std::vector<int> frames = {2, 3, 0, 10}, modes = {-1, 1, 2, 4};
  for (size_t i = 0; i < 4; ++i) {
    const Json& item = mission["items"][i];
    EXPECT_EQ(item["type"], "SimpleItem");
    EXPECT_EQ(item["doJumpId"], i + 1);
    EXPECT_EQ(item["frame"], frames[i]);
    EXPECT_EQ(item["params"].size(), 7u);
    EXPECT_TRUE(item["autoContinue"].is_boolean());
    EXPECT_EQ(item.value("AltitudeMode", -1), modes[i]);
  }
  EXPECT_TRUE(mission["items"][1]["AMSLAltAboveTerrain"].is_null());
  EXPECT_EQ(mission["items"][1]["Altitude"], 90.5);
}

TEST(NewWaypoints, AsMissionPlannerWritesThem) {
  const std::string text = new_mission(Format::kWaypoints, {kPath[0]}, about());
  EXPECT_EQ(text,
            "QGC WPL 110\n"
            "0\t1\t0\t16\t0\t0\t0\t0\t47.100000000\t8.100000000\t431.250\t1\n"
            "1\t0\t2\t178\t1\t14.000\t-1\t0\t0\t0\t0\t1\n"
            "2\t0\t3\t16\t0\t0\t0\t0\t47.300000000\t8.300000000\t90.500\t1\n");
}

TEST(NewMissionRefusals, WhatAFormatCannotSay) {
  const std::vector<Place> ellipsoid = {place(47, 8, 500, kEllipsoid)}, none = {place(47, 8, 0, kNone)};
  NewFile homeless = about();
  homeless.home.reset();
  const auto refused = [](Format format, const std::vector<Place>& path, const NewFile& file) {
    return refusal_of([&] { new_mission(format, path, file); });
  };
  for (const Format format : {Format::kPlan, Format::kWaypoints}) {
    EXPECT_TRUE(says(refused(format, ellipsoid, about()), "found ellipsoid"));
    EXPECT_TRUE(says(refused(format, none, about()), "found none"));
    EXPECT_TRUE(says(refused(format, kPath, homeless), "expected home"));
  }
  EXPECT_TRUE(says(refused(Format::kGpx, {kPath[0]}, about()), "found home"));
  EXPECT_TRUE(says(refused(Format::kGeoJson, kPath, about()), "found home and sea_level"));
  EXPECT_TRUE(says(refused(Format::kKml, kPath, about()), "not written"));
  EXPECT_TRUE(says(refused(Format::kPlan, {}, about()), "at least one place"));
  EXPECT_TRUE(says(refusal_of([] { format_for("route.csv"); }), "\".csv\""));
  EXPECT_EQ(format_for("a.b/route.geojson"), Format::kGeoJson);
}

/// Nothing replaced: the same values in the same order of keys, the plan of another program's keys included.
TEST(ChangedPlan, WithoutReplacementsIsTheSame) {
  const Mission source = parse_mission(kPlanText, "plan");
  EXPECT_EQ(Json::parse(changed_mission(source, {})).dump(), Json::parse(kPlanText).dump());
}

/// Two places for item 3, one before the landing (item 8), one at the end: 9 + 1 + 1 + 1 items, and all else as it was.
TEST(ChangedPlan, KeepsWhatIsNotReplaced) {
  const Mission source = parse_mission(kPlanText, "plan");
  const std::string text =
      changed_mission(source, {{8, 8, {kPath[2]}}, {3, 4, {kPath[0], kPath[1]}}, {9, 9, {kPath[1]}}});
  const Json before = Json::parse(kPlanText), after = Json::parse(text);
  const Json &old_items = before["mission"]["items"], &items = after["mission"]["items"];
  ASSERT_EQ(items.size(), 12u);
  const std::vector<int> from = {0, 1, 2, -1, -1, 4, 5, 6, 7, -1, 8, -1};
  const std::vector<size_t> path = {0, 1, 2, 1};
  size_t inserted = 0;
  for (size_t i = 0; i < items.size(); ++i) {
    if (from[i] >= 0) {
      EXPECT_EQ(items[i].dump(), old_items[static_cast<size_t>(from[i])].dump()) << i;
      continue;
    }
    const Place& wanted = kPath[path[inserted]];
    EXPECT_EQ(items[i]["params"],
              Json({0, 0, 0, nullptr, wanted.position.latitude_deg, wanted.position.longitude_deg, wanted.altitude.m}));
    EXPECT_EQ(items[i]["doJumpId"], 11 + inserted);  // 10 is the largest of the file
    ++inserted;
  }
  Json rest = after;
  rest["mission"]["items"] = old_items;
  EXPECT_EQ(rest.dump(), before.dump());
  // The jump leads to the same item, and the new places are flown.
  const Mission changed = parse_mission(text, "changed");
  EXPECT_EQ(changed.waypoints[1].place, source.waypoints[1].place);
  EXPECT_EQ(changed.jumps[0].to, 1u);
  EXPECT_EQ(changed.waypoints[2].place, kPath[0]);
  EXPECT_EQ(changed.waypoints.size(), source.waypoints.size() + 3);
}

TEST(ChangedPlan, RefusesToTakeOtherItemsAway) {
  const Mission source = parse_mission(kPlanText, "plan");
  const auto refused = [&](size_t first, size_t end) {
    return refusal_of([&] { changed_mission(source, {{first, end, kPath}}); });
  };
  EXPECT_TRUE(says(refused(4, 5), "item 4 cannot be replaced: it is no plain waypoint"));
  EXPECT_TRUE(says(refused(1, 2), "item 1 cannot be replaced: it is no plain waypoint"));
  EXPECT_TRUE(says(refused(2, 3), "item 2 cannot be replaced: a jump leads to it"));
  EXPECT_TRUE(says(refused(9, 10), "within 9 items"));
  EXPECT_TRUE(says(refused(4, 3), "within 9 items"));
  EXPECT_TRUE(says(refusal_of([&] { changed_mission(source, {{3, 4, kPath}, {3, 4, kPath}}); }), "lie apart"));
  EXPECT_EQ(refused(3, 4), "");
}

TEST(ChangedWaypoints, WithoutReplacementsIsTheSame) {
  EXPECT_EQ(changed_mission(parse_mission(kWaypointsText, "waypoints"), {}), kWaypointsText);
  const std::string windows = edited(kWaypointsText, "QGC WPL 110\n", "QGC WPL 110\r\n");
  for (const std::string& line : lines_of(changed_mission(parse_mission(windows, "waypoints"), {})))
    EXPECT_EQ(line.back(), '\r');
}

/// One place before item 2, two for item 3: item 2 is 3 then, where the jump leads; the rest keeps its bytes.
TEST(ChangedWaypoints, RenumbersItemsAndJumps) {
  const Mission source = parse_mission(kWaypointsText, "waypoints");
  const std::string text = changed_mission(source, {{3, 4, {kPath[1], kPath[2]}}, {2, 2, {kPath[0]}}});
  const std::vector<std::string> before = lines_of(kWaypointsText), after = lines_of(text);
  ASSERT_EQ(after.size(), 10u);
  EXPECT_EQ(after[1], before[1]);
  EXPECT_EQ(after[2], before[2]);
  EXPECT_EQ(after[3], "2\t0\t3\t16\t0\t0\t0\t0\t47.300000000\t8.300000000\t90.500\t1");
  EXPECT_EQ(after[4], "3" + before[3].substr(1));
  EXPECT_EQ(after[5], "4\t0\t0\t16\t0\t0\t0\t0\t47.400000000\t8.400000000\t650.000\t1");
  EXPECT_EQ(after[6], "5\t0\t10\t16\t0\t0\t0\t0\t47.500000000\t-8.500000000\t70.000\t1");
  EXPECT_EQ(after[7], "6" + before[5].substr(1));
  EXPECT_EQ(after[8], "7\t0\t3\t177\t3\t1\t0\t0\t0\t0\t0\t1");
  EXPECT_EQ(after[9], "8" + before[7].substr(1));
  EXPECT_EQ(flown(parse_mission(text, "changed")).waypoints, (std::vector<size_t>{0, 1, 2, 3, 4, 5, 2, 3, 4, 5, 6}));
}

TEST(ChangedWaypoints, Refusals) {
  const Mission source = parse_mission(kWaypointsText, "waypoints");
  const auto refused = [&](size_t first, size_t end) {
    return refusal_of([&] { changed_mission(source, {{first, end, kPath}}); });
  };
  EXPECT_TRUE(says(refused(0, 1), "it is home"));
  EXPECT_TRUE(says(refused(0, 0), "item 0 is home"));
  EXPECT_TRUE(says(refused(2, 3), "a jump leads to it"));
  EXPECT_TRUE(says(refused(5, 6), "no plain waypoint"));
  EXPECT_EQ(refused(7, 7), "");
  EXPECT_TRUE(says(refusal_of([] { changed_mission(parse_mission(kGpxText, "gpx"), {}); }), "bare line"));
}

/// From a file on disk, through its name.
TEST(ReadMission, FromDisk) {
  const std::string path = (std::filesystem::path(testing::TempDir()) / "landfix_mission_test.plan").string();
  std::ofstream(path, std::ios::binary) << kPlanText;
  const Mission mission = read_mission(path);
  EXPECT_EQ(mission.file, path);
  EXPECT_EQ(mission.text, kPlanText);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace landfix::mission
