// What a score says of routes whose good and poor parts are known.
#include "tools/route/score.h"

#include "builder/error.h"
#include "tests/route/missions.h"
#include "tools/route/report.h"
#include "tools/route/simulate.h"

namespace landfix::route {
namespace {

const Heights kFlat = flat_heights();

Path eastwards(double from_m, double to_m, double y_m = 3000) {
  return path_through("east", {at(from_m, y_m), at(0.5 * (from_m + to_m), y_m), at(to_m, y_m)}, 120, true, 15, kFlat);
}

FunctionMap lake() { return field(6000, {{3010, 0, 4010, 6000, poor_place(kWater)}}); }

// A lake of 1000 m over the second of two legs: the gap is the lake, its reason water; the first leg meets 10 m, of the
// second what drifts less than 10 m at 95 % before the lake ends does not.
TEST(Score, FindsTheLake) {
  const RouteScore s = score(eastwards(500, 5500), lake(), vehicle(), without_flights());
  EXPECT_NEAR(s.longest_gap.start_m, 2510, 15);
  EXPECT_NEAR(s.longest_gap.end_m, 3510, 15);
  EXPECT_NEAR(s.longest_gap.duration_s(), 1000 / 15.0, 1);
  EXPECT_EQ(s.longest_gap.reason, "water");
  EXPECT_FALSE(s.met);
  EXPECT_EQ(s.worst.reason, "water");
  EXPECT_NEAR(s.worst.end_m, 3510, 80);
  ASSERT_EQ(s.legs.size(), 2u);
  EXPECT_EQ(s.legs[0].meeting, 1);
  EXPECT_EQ(s.legs[0].reason, "");
  EXPECT_EQ(s.legs[1].reason, "water");
  // Constant drift of 0.0180 per metre and axis over 1000 m, 2.448 sigma, and little else.
  EXPECT_NEAR(s.largest_radius_m, 1000 * 0.0180 * 2.448, 5);
  EXPECT_NEAR(s.meeting, 1 - s.worst.length_m() / 5000, 0.01);
}

TEST(Score, MeetsOnGoodGround) {
  const RouteScore s = score(eastwards(500, 5500), field(6000, {}), vehicle(), without_flights());
  EXPECT_TRUE(s.met);
  EXPECT_EQ(s.meeting, 1);
  EXPECT_EQ(s.longest_gap.length_m(), 0);
  EXPECT_EQ(s.on_map, 1);
}

// The last 1500 of 5000 m lie beyond the map: scored as ground without fixes, and said so. A route wholly beyond is
// refused.
TEST(Score, RoutesThatLeaveTheMap) {
  const RouteScore s = score(eastwards(2500, 7500), field(6000, {}), vehicle(), without_flights());
  EXPECT_NEAR(s.on_map, 0.7, 0.005);
  EXPECT_EQ(s.worst.reason, "off the map");
  EXPECT_NE(to_text(s).find(" % of the route lie where the map knows nothing"), std::string::npos) << to_text(s);
  try {
    score(eastwards(7000, 9000), field(6000, {}), vehicle());
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(int(error.code()), int(ExitCode::kNoData));
  }
}

// A scene where nothing can be matched is scored as dead reckoning from the start to the end.
TEST(Score, NoNavigablePlace) {
  const RouteScore s =
      score(eastwards(500, 5500), field(6000, {}, poor_place(kUniformField)), vehicle(), without_flights());
  EXPECT_NEAR(s.longest_gap.length_m(), 5000, 1);
  EXPECT_EQ(s.longest_gap.reason, "uniform field");
  EXPECT_NEAR(s.largest_rms_m, 5000 * 0.0180 * M_SQRT2, 2);
}

// Without a fix the error across the route after 5000 m is a Gaussian of 90 m, and as good as all of it is one constant
// drift, so that who is outside has come there at the end: 1 − P(outside 90 m) = 0.683. 2000 flights: 1 % of noise.
TEST(Score, ChanceToStayInTheCorridor) {
  const FunctionMap nothing = field(6000, {}, poor_place(kWater));
  ScoreOptions options;
  options.corridor_m = 5000 * vehicle().errors.drift_share;
  const RouteScore s = score(eastwards(500, 5500), nothing, vehicle(), options);
  EXPECT_NEAR(s.in_corridor.value(), 0.683, 0.035);
  EXPECT_NEAR(s.corridor_error, std::sqrt(0.683 * 0.317 / 2000), 0.001);
  EXPECT_EQ(score(eastwards(500, 5500), nothing, vehicle(), options).in_corridor, s.in_corridor);
}

TEST(Score, Requirement) {
  EXPECT_EQ(parse_requirement("7.5m@90%").radius_m, 7.5);
  EXPECT_NEAR(parse_requirement("7.5m@90%").confidence, 0.9, 1e-12);
  for (const char* bad : {"", "10m", "10@95%", "10m@95", "10m@100%", "-1m@95%", "10m@95%x", "m@95%"})
    EXPECT_THROW(parse_requirement(bad), Error) << bad;
}

TEST(Score, ReasonsInWords) {
  EXPECT_EQ(words(kWater | kOldMap), "water, map older than 5 years");
  EXPECT_EQ(words(kRepeats, Repeat{18, -0.1}), "looks like the place 18 m to the north");
  EXPECT_EQ(words(kRepeats, Repeat{25, 5 * M_PI / 4}), "looks like the place 25 m to the south-west");
  EXPECT_EQ(words(0), "");
}

// One file: nothing is fetched from elsewhere, and what came from a file's name is text, not markup.
TEST(Score, ReportStandsAlone) {
  RouteScore s = score(eastwards(500, 5500), lake(), vehicle(), without_flights());
  s.name = "<script>alert(1)</script>";
  const std::string html = html_report(s, lake(), vehicle());
  EXPECT_EQ(html.find("http"), std::string::npos);
  EXPECT_EQ(html.find("<script"), std::string::npos);
  EXPECT_EQ(html.find("<link"), std::string::npos);
  EXPECT_NE(html.find("data:image/png;base64,iVBOR"), std::string::npos);
  EXPECT_NE(html.find("not met: water"), std::string::npos);
  EXPECT_EQ(html, html_report(s, lake(), vehicle()));
}

// What the mission says of places is on the map: a fence to stay out of, one to stay in, and a rally point; and where
// the requirement is missed.
TEST(Score, ReportShowsFencesAndRallyPoints) {
  const RouteScore s = score(eastwards(500, 5500), lake(), vehicle(), without_flights());
  const std::string bare = html_report(s, lake(), vehicle());
  ReportScene scene;
  scene.fences = Fences({{at(1000, 1000), at(2000, 1000), at(2000, 1500)}}, {{at(0, 0), at(6000, 0), at(6000, 6000)}});
  scene.rally_points = {at(1500, 2500)};
  const std::string html = html_report(s, lake(), vehicle(), scene);
  for (const char* what : {"class=\"exclusion\"", "class=\"inclusion\"", ">R</text>", "rally point", "no-fly area"}) {
    EXPECT_NE(html.find(what), std::string::npos) << what;
    EXPECT_EQ(bare.find(what), std::string::npos) << what;
  }
  for (const char* what : {">N</text>", "worst stretch", "below 0.2", ">1 km</text>"})
    EXPECT_NE(html.find(what), std::string::npos) << what;
  EXPECT_EQ(html.find("nan"), std::string::npos);
}

TEST(Score, Json) {
  const auto json = to_json(score(eastwards(500, 5500), lake(), vehicle(), without_flights()), kZone, 100);
  EXPECT_EQ(json["worst_stretch"]["reason"], "water");
  EXPECT_LE(json["points"].size(), 100u);
  EXPECT_NEAR(json["points"].back()["distance_m"].get<double>(), 5000, 60);
  EXPECT_NEAR(json["points"][0]["latitude_deg"].get<double>(), 46.98, 0.05);
}

}  // namespace
}  // namespace landfix::route
