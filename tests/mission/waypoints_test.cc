// "QGC WPL" files, and the order in which jumps make a mission fly.
#include <cmath>

#include "tests/mission/files.h"

namespace landfix::mission {
namespace {

using enum AltitudeReference;

/// A file of version 110: home, then these items, each "frame command p1 p2 p3 p4 latitude longitude altitude".
std::string file_of(const std::vector<std::string>& items) {
  std::string text = "QGC WPL 110\n0 1 0 16 0 0 0 0 47.1 8.1 431.25 1\n";
  for (size_t i = 0; i < items.size(); ++i) text += std::to_string(i + 1) + " 0 " + items[i] + " 1\n";
  return text;
}

const std::string kNorth = "3 16 0 0 0 0 47.2 8.1 60", kEast = "3 16 0 0 0 0 47.2 8.2 60";

std::string jump(int target, int repeats) {
  return "2 177 " + std::to_string(target) + " " + std::to_string(repeats) + " 0 0 0 0 0";
}

std::vector<size_t> order(const std::vector<std::string>& items) {
  return flown(parse_mission(file_of(items), "mission file")).waypoints;
}

TEST(Waypoints, ItemsInTheirFrames) {
  const Mission mission = parse_mission(kWaypointsText, "mission file");
  ASSERT_TRUE(mission.home);
  EXPECT_EQ(*mission.home, place(47.1, 8.1, 431.25, kSeaLevel));
  ASSERT_EQ(mission.waypoints.size(), 5u);
  EXPECT_EQ(mission.waypoints[0].place, place(47.1, 8.1, 50, kHome));
  EXPECT_TRUE(mission.waypoints[0].implied);
  EXPECT_EQ(mission.waypoints[1].place, place(47.11, 8.11, 60, kHome));
  EXPECT_EQ(mission.waypoints[2].place, place(47.12, 8.12, 500, kSeaLevel));
  EXPECT_EQ(mission.waypoints[2].hold_s, 2.5);
  EXPECT_EQ(mission.waypoints[3].place, place(47.13, 8.13, 70, kTerrain));
  EXPECT_EQ(mission.waypoints[3].item, 4u);
  EXPECT_EQ(mission.waypoints[4].action, Action::kReturn);
  EXPECT_EQ(mission.waypoints[4].place.position, (Position{47.1, 8.1}));
  EXPECT_EQ(mission.waypoints[4].place.altitude.reference, kNone);  // as the vehicle is set up
  EXPECT_EQ(flown(mission).waypoints, (std::vector<size_t>{0, 1, 2, 3, 1, 2, 3, 4}));
}

TEST(Waypoints, LinesOfWindowsAndBlanks) {
  std::string windows, blanks = kWaypointsText;
  for (const char c : kWaypointsText) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  for (char& c : blanks) c = c == '\t' ? ' ' : c;
  for (const std::string& text : {windows, blanks, "\xEF\xBB\xBF" + kWaypointsText}) {
    const Mission mission = parse_mission(text, "mission file");
    ASSERT_EQ(mission.waypoints.size(), 5u);
    EXPECT_EQ(mission.waypoints[3].place, place(47.13, 8.13, 70, kTerrain));
  }
}

/// Version 120 has no home in item 0, so that it is flown.
TEST(Waypoints, Version120HasNoHome) {
  const Mission mission = parse_mission("QGC WPL 120\n0 1 3 16 0 0 0 0 47.1 8.1 50 1\n", "mission file");
  EXPECT_FALSE(mission.home);
  ASSERT_EQ(mission.waypoints.size(), 1u);
  EXPECT_EQ(mission.waypoints[0].place, place(47.1, 8.1, 50, kHome));
}

/// Ground stations write 0, 0 for a home they do not know; a return then leads nowhere, which is noted.
TEST(Waypoints, HomeNotKnown) {
  const Mission mission = parse_mission(edited(kWaypointsText, "47.100000\t8.100000", "0\t0"), "mission file");
  EXPECT_FALSE(mission.home);
  ASSERT_EQ(mission.waypoints.size(), 3u);  // neither take-off nor return has a place
  ASSERT_EQ(mission.notes.size(), 2u);
  EXPECT_TRUE(says(mission.notes[0].text, "line 3: command 22 has no position"));
  EXPECT_TRUE(says(mission.notes[1].text, "line 8: command 20 has no position"));
}

/// What stands in item 0 with a height above home is home all the same, of no known height.
TEST(Waypoints, HomeWithHeightAboveItself) {
  const Mission mission = parse_mission(edited(kWaypointsText, "0\t1\t0\t16", "0\t1\t3\t16"), "mission file");
  ASSERT_TRUE(mission.home);
  EXPECT_EQ(*mission.home, place(47.1, 8.1, 0, kNone));
}

TEST(Waypoints, LandingAndLoiteringWithoutPositionAreWhereTheVehicleIs) {
  const Mission mission =
      parse_mission(file_of({kNorth, "3 19 30 0 -40 0 0 0 60", "3 21 0 0 0 0 nan nan 0"}), "mission file");
  ASSERT_EQ(mission.waypoints.size(), 3u);
  EXPECT_EQ(mission.waypoints[1].place, place(47.2, 8.1, 60, kHome));
  EXPECT_EQ(mission.waypoints[1].hold_s, 30);
  EXPECT_EQ(mission.waypoints[1].radius_m, -40);
  EXPECT_EQ(mission.waypoints[2].place, place(47.2, 8.1, 0, kHome));
  EXPECT_EQ(mission.waypoints[2].action, Action::kLand);
}

TEST(Waypoints, DelayAndSpeed) {
  const Mission mission = parse_mission(file_of({kNorth, "2 93 7 0 0 0 0 0 0", "2 178 0 22 -1 0 0 0 0", kEast,
                                                 "2 178 1 -1 50 0 0 0 0", "2 178 2 9 0 0 0 0 0", kNorth}),
                                        "mission file");
  ASSERT_EQ(mission.waypoints.size(), 3u);
  EXPECT_EQ(mission.waypoints[0].hold_s, 7);
  ASSERT_TRUE(mission.waypoints[1].speed);
  EXPECT_EQ(mission.waypoints[1].speed->mps, 22);
  EXPECT_TRUE(mission.waypoints[1].speed->through_air);
  EXPECT_FALSE(mission.waypoints[2].speed);  // -1 changes nothing, and 2 is the climb
}

TEST(Waypoints, CommandsThatMoveOtherwiseAreNoted) {
  const Mission mission =
      parse_mission(file_of({kNorth, "3 30 1 0 0 0 0 0 90", "2 206 25 0 0 0 0 0 0"}), "mission file");
  ASSERT_EQ(mission.notes.size(), 1u);
  EXPECT_TRUE(says(mission.notes[0].text, "command 30"));
}

TEST(Jumps, OverWaypoints) {
  EXPECT_EQ(order({kNorth, kEast, jump(1, 2), kNorth}), (std::vector<size_t>{0, 1, 0, 1, 0, 1, 2}));
}

TEST(Jumps, Ahead) { EXPECT_EQ(order({kNorth, jump(4, 1), kEast, kNorth}), (std::vector<size_t>{0, 2})); }

TEST(Jumps, NeverTaken) { EXPECT_EQ(order({kNorth, jump(1, 0), kEast}), (std::vector<size_t>{0, 1})); }

/// Counters of the inner loop are not reset: 0 0 0 (inner twice), 1, then by the outer loop 0 1, then 2.
TEST(Jumps, Nested) {
  EXPECT_EQ(order({kNorth, jump(1, 2), kEast, jump(1, 1), kNorth}), (std::vector<size_t>{0, 0, 0, 1, 0, 1, 2}));
}

/// Taken for ever: once, so that the leg back occurs, and then the flight goes on no further.
TEST(Jumps, ForEver) {
  const Flight flight = flown(parse_mission(file_of({kNorth, kEast, jump(1, -1), kNorth}), "mission file"));
  EXPECT_EQ(flight.waypoints, (std::vector<size_t>{0, 1, 0, 1}));
  EXPECT_TRUE(flight.endless);
}

/// To a command that is no waypoint: on with what follows it. To a tag likewise.
TEST(Jumps, ToCommandsAndTags) {
  EXPECT_EQ(order({kNorth, "2 178 1 9 -1 0 0 0 0", kEast, jump(2, 1)}), (std::vector<size_t>{0, 1, 1}));
  EXPECT_EQ(order({kNorth, "2 600 33 0 0 0 0 0 0", kEast, "2 601 33 2 0 0 0 0 0"}), (std::vector<size_t>{0, 1, 1, 1}));
}

/// 2 waypoints, 65 535 times: more than 100 000.
TEST(Jumps, FlightOfLimitedLength) {
  const Mission mission = parse_mission(file_of({kNorth, kEast, jump(1, 65535)}), "mission file");
  try {
    flown(mission);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kBadInput);
    EXPECT_TRUE(says(e.what(), "jumps of item 3"));
  }
}

}  // namespace
}  // namespace landfix::mission
