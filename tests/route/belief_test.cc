// The closed form against flights drawn from the same model, and against what can be said by hand.
#include "tools/route/belief.h"

#include "tests/route/fields.h"
#include "tools/route/score.h"
#include "tools/route/simulate.h"

namespace landfix::route {
namespace {

// Without a fix only drift, noise of odometry and the start are left: after 1000 m the drift's share is 0.0252 of them
// (2.5 % by 0.99, 0.3° of heading), the root of 2·(1.5² + 4e-4·1000) m comes on top.
TEST(Belief, GrowsAsDriftWhereThereIsNoFix) {
  const Vehicle v = vehicle();
  Belief belief(v.errors);
  for (int i = 0; i < 100; ++i) belief.fly(10, 100, v.errors);
  const double drift_m = 1000 * std::sqrt(0.025 * 0.025 * 0.99 + 0.005236 * 0.005236);
  EXPECT_NEAR(belief.rms_m(), std::sqrt(drift_m * drift_m + 2 * (1.5 * 1.5 + 0.4)), 0.01);
}

// Of one Gaussian the radius is known: σ·√(−2 ln 0.05) = 2.448 σ; on a line (σ, 0) it is the normal's 1.960 σ.
TEST(Belief, RadiusOfAGaussian) {
  EXPECT_NEAR(within_circle(4 * Eigen::Matrix2d::Identity(), 2 * 2.4477), 0.95, 1e-4);
  Eigen::Matrix2d line = Eigen::Matrix2d::Zero();
  line(0, 0) = 4;
  EXPECT_NEAR(within_circle(line, 2 * 1.95996), 0.95, 5e-3);
}

struct Case {
  const char* name;
  double agl_m, speed_mps;
  FunctionMap map;
};

std::vector<Case> cases() {
  std::vector<Case> cases;
  cases.push_back({"good", 150, 15, field(6000, {})});
  cases.push_back({"every second fix", 150, 15, field(6000, {}, good_place(0.5, 3))});
  cases.push_back({"rare fixes", 300, 20, field(6000, {}, good_place(0.08, 4))});
  cases.push_back({"lake", 120, 12, field(6000, {{2000, 0, 3000, 6000, poor_place(kWater)}})});
  cases.push_back({"patches", 200, 20,
                   field(6000,
                         {{500, 0, 900, 6000, poor_place(kForest, 0.2)},
                          {1500, 0, 2600, 6000, poor_place(kUniformField, 0.05)},
                          {4000, 0, 4200, 6000, poor_place(kWater)}},
                         good_place(0.8, 2))});
  Navigability road = good_place(0.7);
  road.covariance_m2 << 1, 0, 0, 225;
  cases.push_back({"along a road", 150, 15, field(6000, {}, road)});
  Navigability deceiving = good_place(0.6);
  deceiving.false_probability = 0.01;
  cases.push_back({"false fixes", 150, 15, field(6000, {}, deceiving)});
  return cases;
}

// 2000 drawn flights have 2 % of noise in a root mean square; merging histories may cost the rest of 5 %.
TEST(Belief, AgreesWithDrawnFlights) {
  const Heights heights = flat_heights();
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const Path path = path_through(c.name, {at(100, 500), at(5800, 700)}, c.agl_m, true, c.speed_mps, heights);
    const Vehicle v = vehicle();
    const RouteScore closed = score(path, c.map, v, without_flights());
    const Flights drawn = simulate(images_along(path, c.map, v), v, {});
    ASSERT_EQ(closed.points.size(), drawn.rms_m.size());
    double sum2 = 0, worst = 0, largest = 0, within = 0;
    for (size_t i = 0; i < drawn.rms_m.size(); ++i) {
      sum2 += drawn.rms_m[i] * drawn.rms_m[i];
      within += drawn.within[i];
      largest = std::max(largest, std::abs(closed.points[i].within - drawn.within[i]));
      worst = std::max(worst, std::abs(closed.points[i].rms_m / drawn.rms_m[i] - 1));
    }
    const double n = double(drawn.rms_m.size()), rms_m = std::sqrt(sum2 / n);
    EXPECT_NEAR(closed.rms_m / rms_m, 1, 0.05);
    EXPECT_LT(worst, 0.35);  // few of the drawn flights carry it where fixes begin again
    EXPECT_NEAR(closed.within, within / n, 0.02);
    EXPECT_LT(largest, 0.06);
  }
}

}  // namespace
}  // namespace landfix::route
