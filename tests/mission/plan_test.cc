// QGroundControl's plans: what their items say of the route.
#include <cmath>

#include "tests/mission/files.h"

namespace landfix::mission {
namespace {

using enum AltitudeReference;

class Plan : public testing::Test {
 protected:
  const Mission mission_ = parse_mission(kPlanText, "mission file");
};

/// Item and part of every waypoint, in order: the take-off; items 2 and 3; the three places among the four items of the
/// survey; the corridor's two; approach and landing.
TEST_F(Plan, WaypointsNameTheirItems) {
  std::vector<std::pair<size_t, size_t>> origins;
  for (const Waypoint& waypoint : mission_.waypoints) origins.emplace_back(waypoint.item, waypoint.part);
  EXPECT_EQ(origins, (std::vector<std::pair<size_t, size_t>>{
                         {0, 0}, {2, 0}, {3, 0}, {4, 0}, {4, 2}, {4, 3}, {5, 0}, {5, 1}, {8, 0}, {8, 1}}));
}

TEST_F(Plan, TakeOffWithoutPositionIsAtHome) {
  const Waypoint& first = mission_.waypoints[0];
  EXPECT_EQ(first.action, Action::kTakeoff);
  EXPECT_TRUE(first.implied);
  EXPECT_EQ(first.place, place(47.1, 8.1, 50, kHome));
}

TEST_F(Plan, WaypointKeepsHoldAndAltitude) {
  const Waypoint& second = mission_.waypoints[1];
  EXPECT_EQ(second.place, place(47.1, 8.11, 60, kHome));
  EXPECT_EQ(second.action, Action::kPass);
  EXPECT_EQ(second.hold_s, 4);
  EXPECT_FALSE(second.implied);
}

/// Item 1 commands 12 m/s over ground before item 2; nothing commands another speed.
TEST_F(Plan, SpeedBelongsToTheLegThatFollows) {
  EXPECT_FALSE(mission_.waypoints[0].speed);
  ASSERT_TRUE(mission_.waypoints[1].speed);
  EXPECT_EQ(mission_.waypoints[1].speed->mps, 12);
  EXPECT_FALSE(mission_.waypoints[1].speed->through_air);
  for (size_t i = 2; i < mission_.waypoints.size(); ++i) EXPECT_FALSE(mission_.waypoints[i].speed) << i;
}

/// Item 3: the parameter is null, 80 m above ground is what was asked for.
TEST_F(Plan, AltitudeNotYetComputedIsAboveTerrain) {
  EXPECT_EQ(mission_.waypoints[2].place, place(47.1, 8.12, 80, kTerrain));
}

/// Computed, it is what the vehicle is sent: above sea level.
TEST_F(Plan, AltitudeOfTheParameterRules) {
  const Mission computed = parse_mission(edited(kPlanText, "8.12, null]", "8.12, 513.5]"), "mission file");
  EXPECT_EQ(computed.waypoints[2].place, place(47.1, 8.12, 513.5, kSeaLevel));
}

TEST_F(Plan, SurveyIsWhatTheVehicleIsSent) {
  EXPECT_EQ(mission_.waypoints[3].place, place(47.11, 8.10, 70, kTerrain));
  EXPECT_EQ(mission_.waypoints[4].place, place(47.11, 8.13, 70, kTerrain));
  EXPECT_EQ(mission_.waypoints[5].place, place(47.12, 8.13, 71, kTerrain));
}

/// The corridor's Items are empty: its polyline, 640.5 m above sea level (mode 2).
TEST_F(Plan, CorridorWithoutItemsFollowsItsPolyline) {
  EXPECT_EQ(mission_.waypoints[6].place, place(47.13, 8.13, 640.5, kSeaLevel));
  EXPECT_EQ(mission_.waypoints[7].place, place(47.14, 8.13, 640.5, kSeaLevel));
}

TEST_F(Plan, OldSurveysSayTheirAltitudeOtherwise) {
  const auto altitude = [](const std::string& camera, const std::string& follow) {
    std::string text = edited(kPlanText, R"("DistanceMode": 2, "DistanceToSurface": 640.5)", camera);
    text = edited(text, R"("Items": [],)", R"("Items": [], )" + follow);
    return parse_mission(text, "mission file").waypoints[6].place.altitude;
  };
  EXPECT_EQ(altitude(R"("DistanceToSurfaceRelative": true, "DistanceToSurface": 90)", ""), (Altitude{90, kHome}));
  EXPECT_EQ(altitude(R"("DistanceToSurfaceRelative": false, "DistanceToSurface": 90)", ""), (Altitude{90, kSeaLevel}));
  EXPECT_EQ(altitude(R"("DistanceToSurfaceRelative": true, "DistanceToSurface": 90)", R"("FollowTerrain": true,)"),
            (Altitude{90, kTerrain}));
  EXPECT_EQ(altitude(R"("CameraName": "x")", "").reference, kNone);
}

TEST_F(Plan, LandingPatternCirclesDownThenLands) {
  const Waypoint &approach = mission_.waypoints[8], &landing = mission_.waypoints[9];
  EXPECT_EQ(approach.place, place(47.105, 8.105, 40, kHome));
  EXPECT_EQ(approach.action, Action::kLoiter);
  EXPECT_EQ(approach.radius_m, -75);  // against the clock
  EXPECT_EQ(landing.place, place(47.1, 8.1, 0, kHome));
  EXPECT_EQ(landing.action, Action::kLand);
}

/// Of a VTOL (version 1), and straight in rather than circled down.
TEST_F(Plan, LandingPatternStraightIn) {
  std::string text = edited(kPlanText, "fwLanding", "vtolLanding");
  text = edited(text, "\"useLoiterToAlt\": true, \"version\": 2", "\"useLoiterToAlt\": false, \"version\": 1");
  const Mission straight =
      parse_mission(edited(text, "\"altitudesAreRelative\": true", "\"altitudesAreRelative\": false"), "mission file");
  EXPECT_EQ(straight.waypoints[8].place, place(47.105, 8.105, 40, kSeaLevel));
  EXPECT_EQ(straight.waypoints[8].action, Action::kPass);
  EXPECT_EQ(straight.waypoints[9].action, Action::kLand);
}

TEST_F(Plan, StructureScanIsNotedNotInvented) {
  ASSERT_EQ(mission_.notes.size(), 1u);
  EXPECT_EQ(mission_.notes[0].item, 6u);
  EXPECT_TRUE(says(mission_.notes[0].text, "StructureScan"));
}

TEST_F(Plan, FencesRallyPointsAndHome) {
  ASSERT_EQ(mission_.fences.size(), 2u);
  EXPECT_TRUE(mission_.fences[0].inclusion);
  EXPECT_EQ(mission_.fences[0].polygon, (std::vector<Position>{{47.0, 8.0}, {47.0, 8.2}, {47.2, 8.2}, {47.2, 8.0}}));
  EXPECT_FALSE(mission_.fences[1].inclusion);
  EXPECT_TRUE(mission_.fences[1].polygon.empty());
  EXPECT_EQ(mission_.fences[1].centre, (Position{47.12, 8.12}));
  EXPECT_EQ(mission_.fences[1].radius_m, 250.5);
  EXPECT_EQ(mission_.rally_points, (std::vector<Place>{place(47.11, 8.11, 30, kHome)}));
  ASSERT_TRUE(mission_.home);
  EXPECT_EQ(*mission_.home, place(47.1, 8.1, 431.25, kSeaLevel));
  EXPECT_EQ(mission_.cruise_speed_mps, 15);
  EXPECT_EQ(mission_.hover_speed_mps, 5);
}

/// The jump of item 7 leads to id 3, which is item 2 and waypoint 1, twice: waypoints 1 to 7 come three times.
TEST_F(Plan, JumpIsTakenAsOftenAsItSays) {
  ASSERT_EQ(mission_.jumps.size(), 1u);
  EXPECT_EQ(mission_.jumps[0].at, 8u);
  EXPECT_EQ(mission_.jumps[0].to, 1u);
  const Flight flight = flown(mission_);
  std::vector<size_t> expected = {0};
  for (int round = 0; round < 3; ++round) {
    for (size_t i = 1; i < 8; ++i) expected.push_back(i);
  }
  expected.insert(expected.end(), {8, 9});
  EXPECT_EQ(flight.waypoints, expected);
  EXPECT_FALSE(flight.endless);
}

/// Plans before 2017 keep the position apart from four parameters.
TEST_F(Plan, PositionApartFromParameters) {
  const std::string text = edited(kPlanText, R"("params": [4, 0, 0, null, 47.1, 8.11, 60])",
                                  R"("coordinate": [47.1, 8.11, 60], "params": [4, 0, 0, 0])");
  EXPECT_EQ(parse_mission(text, "mission file").waypoints[1].place, place(47.1, 8.11, 60, kHome));
}

/// QGroundControl reads fences and rally points of version 2 only, and plans without them at all.
TEST_F(Plan, OldFencesAreNotedAndLeftOut) {
  const Mission old = parse_mission(edited(kPlanText, "\"version\": 2\n    },\n    \"groundStation\"",
                                           "\"version\": 1\n    },\n    \"groundStation\""),
                                    "mission file");
  EXPECT_TRUE(old.fences.empty());
  ASSERT_EQ(old.notes.size(), 2u);
  EXPECT_TRUE(says(old.notes[1].text, "geoFence"));
}

/// Loitering without end is where the flight ends; a delay adds to the waypoint before.
TEST_F(Plan, LoiterWithoutEndEndsTheFlight) {
  const auto command = [](int number) {
    return "\"command\": " + std::to_string(number) + ",\n             \"doJumpId\": 3";
  };
  const Mission loiter = parse_mission(edited(kPlanText, command(16), command(17)), "mission file");
  EXPECT_EQ(loiter.waypoints[1].action, Action::kLoiter);
  EXPECT_TRUE(std::isinf(loiter.waypoints[1].hold_s));
  EXPECT_EQ(flown(loiter).waypoints, (std::vector<size_t>{0, 1}));
  const Mission turns = parse_mission(edited(kPlanText, command(16), command(18)), "mission file");
  EXPECT_EQ(turns.waypoints[1].turns, 4);
  EXPECT_EQ(turns.waypoints[1].hold_s, 0);
}

}  // namespace
}  // namespace landfix::mission
