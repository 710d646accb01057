// Which height is best where it is known why.
#include "tools/route/altitude.h"

#include "builder/error.h"
#include "tests/route/fields.h"

namespace landfix::route {
namespace {

PathAt eastwards() {
  return [](double agl_m) {
    return path_through("east", {at(500, 2000), at(4500, 2000)}, agl_m, true, 15, flat_heights());
  };
}

// Fixes need views of 150 m and more (an altitude of 150 m at 60° by 4:3), and above that attitude errors and coarse
// pixels grow with the height: the lowest height that sees enough is best.
TEST(Altitude, LowestThatSeesEnough) {
  const FunctionMap map({kEast, kNorth, kEast + 5000, kNorth + 5000}, [](double, double, double footprint_m, double) {
    Navigability n = good_place(footprint_m >= 150 ? 0.9 : 0.02);
    n.gsd_m = 0.25;
    return std::optional(n);
  });
  const AltitudeComparison c = compare_altitudes(eastwards(), {80, 160, 320, 640}, map, vehicle(), without_flights());
  EXPECT_EQ(c.rows[c.best].agl_m, 160);
  EXPECT_LT(c.rows[0].score.meeting, 0.7);
  EXPECT_LT(c.rows[1].score.rms_m, c.rows[2].score.rms_m);
  EXPECT_LT(c.rows[2].score.rms_m, c.rows[3].score.rms_m);
  // 640 px over 60°: 2·160·tan 30° / 640.
  EXPECT_NEAR(c.rows[1].camera_gsd_m, 160 * 2 * std::tan(M_PI / 6) / 640, 1e-6);
  EXPECT_NEAR(c.rows[1].footprint_m, 160 * 2 * std::tan(M_PI / 6) * std::sqrt(0.75), 1e-6);
  EXPECT_NE(to_text(c).find("<- best"), std::string::npos);
}

TEST(Altitude, RefusesNonsense) {
  const FunctionMap map = field(5000, {});
  EXPECT_THROW(compare_altitudes(eastwards(), {}, map, vehicle(), without_flights()), Error);
  EXPECT_THROW(compare_altitudes(eastwards(), {-5}, map, vehicle(), without_flights()), Error);
}

}  // namespace
}  // namespace landfix::route
