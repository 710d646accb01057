// From a mission to where it leads, how high above the ground, and how fast.
#include "tools/route/path.h"

#include "builder/error.h"
#include "tests/route/missions.h"

namespace landfix::route {
namespace {

const Heights kFlat = flat_heights();

std::string refusal(const std::function<void()>& action, ExitCode code) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(int(error.code()), int(code)) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "nothing was refused";
  return "";
}

// Ground at 400 m above the ellipsoid, geoid at 50: 500 m above sea level are 550 − 400 = 150 m above ground, 100 m
// above home (which is 400 m above sea level, 450 above the ellipsoid) are also 150, terrain altitudes are what they
// say.
TEST(MissionPath, ResolvesAltitudes) {
  const auto mission = plan(item(1, 16, 0, "0, 0, 0, null", degrees_at(1000, 1000), 500) + "," +
                            item(2, 16, 3, "0, 0, 0, null", degrees_at(2000, 1000), 100) + "," +
                            item(3, 16, 10, "0, 0, 0, null", degrees_at(3000, 1000), 80));
  const Path path = path_of(mission, kZone, kFlat);
  EXPECT_NEAR(path.length_m(), 2000, 0.01);
  EXPECT_NEAR(path.at(0).agl_m, 150, 1e-6);
  EXPECT_NEAR(path.at(1000).agl_m, 150, 1e-6);
  EXPECT_NEAR(path.at(1500).agl_m, 115, 1e-4);
  EXPECT_NEAR(path.at(2000).agl_m, 80, 1e-6);
  EXPECT_NEAR(path.at(2000).east_m, kEast + 3000, 0.01);
}

// 1000 m at the plan's 20 m/s, 30 s of waiting, then 1000 m at the commanded 10 m/s: 50 + 30 + 100 s.
TEST(MissionPath, SpeedsAndWaiting) {
  const auto mission = plan(item(1, 16, 10, "0, 0, 0, null", degrees_at(0, 1000), 100) + "," +
                            item(2, 19, 10, "30, 0, 0, null", degrees_at(1000, 1000), 100) + "," +
                            item(3, 178, 2, "1, 10, -1, 0", "0, 0", 0) + "," +
                            item(4, 16, 10, "0, 0, 0, null", degrees_at(2000, 1000), 100));
  const Path path = path_of(mission, kZone, kFlat);
  EXPECT_NEAR(path.duration_s(), 180, 0.01);
  EXPECT_NEAR(path.at(1500).time_s, 80 + 50, 0.01);
  EXPECT_EQ(path.at(1500).speed_mps, 10);
  EXPECT_EQ(path.legs().at(1).name, "item 3");
}

// Two circles of 100 m radius as polygons of 24 sides: 2·24·2·100·sin(π/24), and 100 m from the centre to the rim.
TEST(MissionPath, CirclesAreFlown) {
  const auto mission = plan(item(1, 16, 10, "0, 0, 0, null", degrees_at(0, 1000), 100) + "," +
                            item(2, 18, 10, "2, 0, 100, null", degrees_at(1000, 1000), 100));
  EXPECT_NEAR(path_of(mission, kZone, kFlat).length_m(), 1000 + 100 + 2 * 24 * 2 * 100 * std::sin(M_PI / 24), 0.1);
}

// The ground rises by 0.2 per metre eastwards; a level flight 152 m above the start meets it after 760 m.
TEST(MissionPath, RefusesARouteBelowTheGround) {
  Heights slope = kFlat;
  slope.ground_m = [](double east_m, double) { return std::optional(400 + 0.2 * (east_m - kEast)); };
  const std::string why = refusal(
      [&] {
        path_through("hill", {at(0, 0), at(2000, 0)}, 552, false, 15, slope);
      },
      ExitCode::kBadInput);
  EXPECT_NE(why.find("hill: leg 1"), std::string::npos) << why;
  EXPECT_NE(why.find("775 m after the start"), std::string::npos) << why;  // seen every 25 m
  EXPECT_NO_THROW(path_through("hill", {at(0, 0), at(2000, 0)}, 150, true, 15, slope));
}

// Landing is no route below the ground: the last leg ends on it.
TEST(MissionPath, MayLand) {
  const auto mission = plan(item(1, 22, 3, "0, 0, 0, null", degrees_at(1000, 1000), 50) + "," +
                            item(2, 16, 3, "0, 0, 0, null", degrees_at(2000, 1000), 50) + "," +
                            item(3, 21, 3, "0, 0, 0, null", degrees_at(3000, 1000), -60));
  const Path path = path_of(mission, kZone, kFlat);
  EXPECT_EQ(path.at(path.length_m()).agl_m, 0);
}

TEST(MissionPath, RefusesWhatCannotBeResolved) {
  const auto gpx = mission::parse_mission(
      fmt::format(R"(<gpx version="1.1"><rte><rtept lat="47" lon="9"/><rtept lat="47.01" lon="9"/></rte></gpx>)"),
      "a.gpx");
  EXPECT_NE(refusal([&] { path_of(gpx, kZone, kFlat); }, ExitCode::kUsage).find("height above ground"),
            std::string::npos);
  PathOptions given;
  given.agl_m = 90;
  EXPECT_EQ(path_of(gpx, kZone, kFlat, given).at(0).agl_m, 90);
  const auto high = plan(item(1, 16, 0, "0, 0, 0, null", degrees_at(0, 0), 500) + "," +
                         item(2, 16, 0, "0, 0, 0, null", degrees_at(900, 0), 500));
  Heights no_geoid = kFlat;
  no_geoid.geoid_m = [](double, double) { return std::nullopt; };
  EXPECT_NE(refusal([&] { path_of(high, kZone, no_geoid); }, ExitCode::kNoData).find("geoid"), std::string::npos);
  refusal([&] { path_through("point", {at(0, 0), at(0, 0)}, 100, true, 15, kFlat); }, ExitCode::kBadInput);
}

}  // namespace
}  // namespace landfix::route
