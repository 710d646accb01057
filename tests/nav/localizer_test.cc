// The whole onboard loop on textured ground in memory: closed-loop consistency, look-alikes, and what must not move it.
#include "runtime/nav/localizer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "tests/nav/scene.h"

namespace landfix::nav {
namespace {

using features::GridImage;
using testing::GrayMap;
using testing::Pose;
using testing::Random;

constexpr double kDegree = 0.017453292519943295;
constexpr double kGroundHeight = 210;

/// The camera's view with another gain and offset and with sensor noise.
cv::Mat degraded(const cv::Mat& picture, Random& random) {
  cv::Mat noise(picture.size(), CV_32F), out;
  cv::RNG(uint64_t(random.uniform(1, 1e9))).fill(noise, cv::RNG::NORMAL, 0, 8);
  picture.convertTo(out, CV_32F, random.uniform(0.6, 1.1), random.uniform(-10, 40));
  out += noise;
  out.convertTo(out, CV_8U);
  return out;
}

/// Squared Mahalanobis distance of the truth.
double mahalanobis2(const Estimate& e, double east_m, double north_m) {
  const double de = east_m - e.east_m, dn = north_m - e.north_m;
  const auto& c = e.covariance_m2;
  return (c[3] * de * de - 2 * c[1] * de * dn + c[0] * dn * dn) / (c[0] * c[3] - c[1] * c[2]);
}

struct Statistics {
  int updates = 0, fixes = 0, inside = 0;
  double squares = 0, worst_m = 0, variances = 0;
  double rms_m() const { return std::sqrt(squares / updates); }
  double expected_rms_m() const { return std::sqrt(variances / updates); }
  double consistency() const { return double(inside) / updates; }
};

struct FlightPlan {
  double height_m, step_m, white_attitude_rad, start_sigma_m;
  int steps;
};

/// One flight with a turn in the middle: odometry with a scale and a direction error of 2.5 % each, attitude with a
/// constant and a white error, a barometer off by 1 m; the scene is the map with 20 % of other texture mixed in.
void fly(const GrayMap& map, const GridImage& scene, const FlightPlan& plan, uint64_t seed, Statistics& statistics) {
  Random random(seed);
  const Camera camera = camera_from_field_of_view(240, 180, 60 * kDegree);
  LocalizerOptions options;
  options.attitude_sigma_rad = plan.white_attitude_rad;
  Localizer localizer(map, options);
  Pose pose{random.uniform(-60, 60), random.uniform(-60, 60), plan.height_m, {}};
  double course = random.uniform(0, 6.283);
  ASSERT_EQ(localizer.start(pose.east_m + random.normal(plan.start_sigma_m),
                            pose.north_m + random.normal(plan.start_sigma_m), plan.start_sigma_m),
            Status::kOk);
  const double scale = random.normal(0.025), turned = random.normal(0.025);
  const double roll_bias = random.normal(0.3 * kDegree), pitch_bias = random.normal(0.3 * kDegree),
               barometer = random.normal(1);
  for (int step = 0; step < plan.steps; ++step) {
    if (step == plan.steps / 2) course += 2.5;
    const double de = plan.step_m * std::sin(course), dn = plan.step_m * std::cos(course);
    pose.east_m += de, pose.north_m += dn;
    // The drift is not white: what it adds over the 40 m until it is forgotten is what a step's sigma must make up for.
    ASSERT_EQ(localizer.predict((1 + scale) * de + turned * dn, (1 + scale) * dn - turned * de,
                                0.025 * std::sqrt(40 * plan.step_m)),
              Status::kOk);
    const Attitude measured{0, 0, course};
    pose.attitude = {measured.roll + roll_bias + random.normal(plan.white_attitude_rad),
                     measured.pitch + pitch_bias + random.normal(plan.white_attitude_rad), course};
    const cv::Mat image = degraded(testing::take_picture(scene, camera, pose), random);
    const Fix fix = localizer.update(image, camera, measured, kGroundHeight + plan.height_m + barometer, step);
    const Estimate estimate = localizer.estimate();
    ASSERT_EQ(fix.status, Status::kOk) << to_text(fix.status);
    const double error = std::hypot(estimate.east_m - pose.east_m, estimate.north_m - pose.north_m);
    statistics.updates += 1;
    statistics.fixes += std::hypot(fix.east_m - pose.east_m, fix.north_m - pose.north_m) < 0.1 * plan.height_m;
    statistics.inside += mahalanobis2(estimate, pose.east_m, pose.north_m) <= 9;
    statistics.squares += error * error;
    statistics.variances += estimate.covariance_m2[0] + estimate.covariance_m2[3];
    statistics.worst_m = std::max(statistics.worst_m, error);
  }
}

/// 800 m of texture at 0.25 m, and the same place looking a little different.
const GridImage& ground() {
  static const GridImage g{testing::random_texture(3200, 3200, 11), {}, -400, 400, 0.25};
  return g;
}
const GridImage& changed_ground() {
  static const GridImage g{ground().pixels * 0.8 + testing::random_texture(3200, 3200, 12) * 0.2, {}, -400, 400, 0.25};
  return g;
}

Statistics monte_carlo(const GridImage& scene, const FlightPlan& plan, int flights) {
  const GrayMap map(ground(), 5, kGroundHeight);
  Statistics statistics;
  for (int i = 0; i < flights; ++i) fly(map, scene, plan, 100 + uint64_t(i), statistics);
  std::printf("%d updates: RMS %.2f m (expected %.2f), worst %.2f m, inside 3 sigma %.3f, true peaks %.3f\n",
              statistics.updates, statistics.rms_m(), statistics.expected_rms_m(), statistics.worst_m,
              statistics.consistency(), double(statistics.fixes) / statistics.updates);
  return statistics;
}

TEST(Localizer, IsConsistentAndAccurateLow) {
  // 60 m above ground: 0.3° constant and 0.5° white attitude errors are 0.31 m and 0.52 m per axis.
  const Statistics s = monte_carlo(changed_ground(), {60, 6, 0.5 * kDegree, 10, 40}, 12);
  EXPECT_GE(s.consistency(), 0.97);
  EXPECT_LT(s.rms_m(), 1.0);
  EXPECT_LT(s.worst_m, 4);
  EXPECT_LT(s.expected_rms_m(), 2 * s.rms_m()) << "a covariance that is far too large is no consistency";
}

TEST(Localizer, IsConsistentAndAccurateHigh) {
  // 200 m above ground with 1° of white attitude noise: 1.05 m and 3.5 m per axis.
  const Statistics s = monte_carlo(changed_ground(), {200, 10, 1 * kDegree, 10, 24}, 10);
  EXPECT_GE(s.consistency(), 0.97);
  EXPECT_LT(s.rms_m(), 3.5);
  EXPECT_LT(s.expected_rms_m(), 2 * s.rms_m());
}

TEST(Localizer, StaysHonestWhereTheSceneHasChanged) {
  // Three quarters of the camera's contrast come from elsewhere: many peaks are false. No accuracy is promised; the
  // ellipse must hold.
  const GridImage scene{ground().pixels * 0.25 + testing::random_texture(3200, 3200, 13) * 0.75, {}, -400, 400, 0.25};
  const Statistics s = monte_carlo(scene, {60, 6, 0.5 * kDegree, 15, 40}, 12);
  EXPECT_GE(s.consistency(), 0.97);
}

/// Flies level and north-up over a map without any error.
class Ideal {
 public:
  Ideal(const GrayMap& map, const GridImage& scene, double sigma_m, double east_m = 0, double north_m = 0)
      : localizer(map), scene_(scene), pose_{east_m, north_m, 60, {}} {
    EXPECT_EQ(localizer.start(east_m, north_m, sigma_m), Status::kOk);
  }
  void move(double east_m, double north_m, double sigma_m) {
    pose_.east_m += east_m, pose_.north_m += north_m;
    EXPECT_EQ(localizer.predict(east_m, north_m, sigma_m), Status::kOk);
  }
  /// Puts the aircraft somewhere without telling it.
  void displace(double east_m, double north_m) { pose_.east_m += east_m, pose_.north_m += north_m; }
  Fix look() { return show(testing::take_picture(scene_, camera, pose_)); }
  Fix show(const cv::Mat& image) { return localizer.update(image, camera, pose_.attitude, kGroundHeight + 60, 0); }
  const Pose& truth() const { return pose_; }
  double error_m() const {
    return std::hypot(localizer.estimate().east_m - pose_.east_m, localizer.estimate().north_m - pose_.north_m);
  }

  Localizer localizer;
  const Camera camera = camera_from_field_of_view(240, 180, 60 * kDegree);

 private:
  const GridImage& scene_;
  Pose pose_;
};

double probability_near(const PointMassFilter& filter, double east_m, double north_m, double radius_m) {
  double sum = 0;
  for (int y = 0; y < filter.masses().rows; ++y)
    for (int x = 0; x < filter.masses().cols; ++x)
      if (std::hypot(filter.west_m() + x * filter.cell_m() - east_m, filter.north_m() - y * filter.cell_m() - north_m) <
          radius_m)
        sum += filter.masses().at<double>(y, x);
  return sum;
}

TEST(Localizer, KeepsTwoLookAlikesUntilTheViewTellsThemApart) {
  // The 110 m around (0, 0) are copied to (150, 0); the aircraft believes to be halfway, 75 ± 60 m, and is at (0, 0).
  GridImage twins{ground().pixels.clone(), {}, -400, 400, 0.25};
  const cv::Rect here(1600 - 220, 1600 - 220, 440, 440);
  twins.pixels(here).copyTo(twins.pixels(here + cv::Point(600, 0)));
  const GrayMap map(twins, 5, kGroundHeight);
  Ideal flight(map, twins, 60, 75, 0);
  flight.displace(-75, 0);
  const Fix fix = flight.look();
  ASSERT_EQ(fix.status, Status::kOk);
  EXPECT_GT(fix.ambiguity, 0.95);
  EXPECT_GT(fix.covariance_m2[0], 70 * 70);  // two modes 150 m apart: 75² and a little
  EXPECT_NEAR(probability_near(flight.localizer.filter(), 0, 0, 10), 0.5, 0.15);
  EXPECT_NEAR(probability_near(flight.localizer.filter(), 150, 0, 10), 0.5, 0.15);
  EXPECT_GT(flight.localizer.estimate().covariance_m2[0], 60 * 60);
  for (int i = 0; i < 8; ++i) {
    flight.move(0, 10, 0.3);
    ASSERT_EQ(flight.look().status, Status::kOk);
  }
  EXPECT_LT(flight.error_m(), 1);
  EXPECT_LT(flight.localizer.estimate().covariance_m2[0], 4);
}

TEST(Localizer, FindsItselfFromFarOffOnACoarserLevel) {
  // ±4 sigma of 100 m and the footprint are 880 m: 3500 pixels at 0.25 m, so that 1 m is taken; within a few images it
  // is back at 0.25 m.
  const GrayMap map(ground(), 5, kGroundHeight);
  Ideal flight(map, ground(), 100);
  flight.displace(130, -110);
  const Fix first = flight.look();
  ASSERT_EQ(first.status, Status::kOk);
  EXPECT_EQ(first.gsd_m, 1);
  EXPECT_LT(flight.error_m(), 25);
  Fix last;
  for (int i = 0; i < 6; ++i) {
    flight.move(-12, 5, 0.3);
    last = flight.look();
  }
  EXPECT_EQ(last.gsd_m, 0.25);
  EXPECT_GT(last.score, 0.9);
  EXPECT_LT(std::hypot(last.east_m - flight.truth().east_m, last.north_m - flight.truth().north_m), 0.1);
  EXPECT_LT(flight.error_m(), 0.5);
}

TEST(Localizer, LearnsNothingFromABlankOrNoisyImage) {
  const GrayMap map(ground(), 5, kGroundHeight);
  Ideal flight(map, ground(), 8);
  const Estimate before = flight.localizer.estimate();
  EXPECT_EQ(flight.show(cv::Mat(180, 240, CV_8U, cv::Scalar(90))).status, Status::kNoTexture);
  Estimate after = flight.localizer.estimate();
  EXPECT_EQ(after.east_m, before.east_m);
  EXPECT_EQ(after.covariance_m2, before.covariance_m2);
  // Pure noise correlates with nothing: the ellipse neither shrinks nor moves by more than a tenth of sigma.
  cv::Mat noise(180, 240, CV_8U);
  cv::RNG(3).fill(noise, cv::RNG::UNIFORM, 0, 256);
  EXPECT_EQ(flight.show(noise).status, Status::kOk);
  after = flight.localizer.estimate();
  EXPECT_NEAR(after.east_m, before.east_m, 0.8);
  EXPECT_NEAR(after.north_m, before.north_m, 0.8);
  EXPECT_NEAR(std::sqrt(after.covariance_m2[0]), 8, 0.8);
}

TEST(Localizer, DoesNotGrowSurerByHovering) {
  // Pictures of the same place repeat the same error: after the first they weigh nothing.
  const GrayMap map(ground(), 5, kGroundHeight);
  Ideal flight(map, ground(), 8);
  ASSERT_EQ(flight.look().weight, 1);
  const double first = flight.localizer.estimate().covariance_m2[0];
  for (int i = 0; i < 20; ++i) EXPECT_EQ(flight.look().weight, 0);
  EXPECT_NEAR(flight.localizer.estimate().covariance_m2[0], first, 1e-9);
}

TEST(Localizer, NeverReportsLessThanTheConstantErrors) {
  // 0.3° at 60 m and 0.25 m of map: 0.403 m per axis, however many images agree.
  const GrayMap map(ground(), 5, kGroundHeight);
  Ideal flight(map, ground(), 5);
  for (int i = 0; i < 15; ++i) {
    flight.move(8, 0, 0.01);
    flight.look();
  }
  EXPECT_GT(flight.localizer.estimate().covariance_m2[0], 0.16);
  EXPECT_GT(flight.localizer.estimate().covariance_m2[3], 0.16);
}

TEST(Localizer, NeverAveragesAwayWhatHasChanged) {
  // Half of the contrast is foreign: the correlation is about 0.7, and 3 m (1 - 0.7) = 0.9 m per axis stay however many
  // images agree; an unchanged scene leaves less than half of that variance.
  const GridImage changed{ground().pixels * 0.5 + testing::random_texture(3200, 3200, 14) * 0.5, {}, -400, 400, 0.25};
  const GrayMap map(ground(), 5, kGroundHeight);
  Ideal same(map, ground(), 5), other(map, changed, 5);
  Fix fix;
  for (int i = 0; i < 20; ++i) {
    same.move(8, 0, 0.1);
    other.move(8, 0, 0.1);
    same.look();
    fix = other.look();
  }
  ASSERT_EQ(fix.status, Status::kOk);
  EXPECT_NEAR(fix.score, 0.7, 0.1);
  const double change_m = 3 * (1 - fix.score);
  EXPECT_GT(other.localizer.estimate().covariance_m2[0], 0.16 + 0.8 * change_m * change_m);
  EXPECT_LT(same.localizer.estimate().covariance_m2[0], 0.5 * other.localizer.estimate().covariance_m2[0]);
}

TEST(Localizer, TakesAHeadingKnownWellAsItIs) {
  // 0.2° turn the rim of the patch by less than half a pixel: not worth a search, and the heading's own sigma stands.
  const GrayMap map(ground(), 5, kGroundHeight);
  const Camera camera = camera_from_field_of_view(240, 180, 60 * kDegree);
  LocalizerOptions options;
  options.heading_sigma_rad = 0.2 * kDegree;
  Localizer localizer(map, options);
  ASSERT_EQ(localizer.start(0, 0, 5), Status::kOk);
  const Fix fix = localizer.update(testing::take_picture(ground(), camera, {}), camera, {}, kGroundHeight + 60, 0);
  ASSERT_EQ(fix.status, Status::kOk);
  EXPECT_EQ(fix.rotation_rad, 0);
  EXPECT_EQ(fix.rotation_sigma_rad, options.heading_sigma_rad);
}

TEST(Localizer, LeavesOutWhatTheMaskCovers) {
  // A skid with its own texture covers the lower third. Masked, the rest matches as before; not masked, a third of the
  // contrast is foreign.
  const GrayMap map(ground(), 5, kGroundHeight);
  Camera camera = camera_from_field_of_view(240, 180, 60 * kDegree);
  cv::Mat image = testing::take_picture(ground(), camera, {});
  const cv::Rect skid(0, 120, 240, 60);
  testing::random_texture(240, 60, 5).copyTo(image(skid));
  const auto score = [&] {
    Localizer localizer(map);
    EXPECT_EQ(localizer.start(0, 0, 5), Status::kOk);
    const Fix fix = localizer.update(image, camera, {}, kGroundHeight + 60, 0);
    EXPECT_EQ(fix.status, Status::kOk);
    return fix.score;
  };
  const double open = score();
  camera.mask = cv::Mat(180, 240, CV_8U, cv::Scalar(255));
  camera.mask(skid).setTo(0);
  EXPECT_GT(score(), 0.95);
  EXPECT_LT(open, 0.8);
}

TEST(Localizer, TakesColourAndOrientation) {
  // Half of all edges have turned round in another season: gray values fail, orientation of the colours does not.
  const GridImage summer = testing::ground_of(testing::countryside(1600, 3)),
                  winter = testing::ground_of(testing::countryside(1600, 3, 1));
  const ImageMap map(summer, 4, kGroundHeight);
  const Camera camera = camera_from_field_of_view(240, 180, 60 * kDegree);
  Localizer localizer(map);
  ASSERT_EQ(localizer.start(6, 5, 5), Status::kOk);
  const cv::Mat image = testing::take_picture(winter, camera, {0, 0, 60, {}});
  ASSERT_EQ(image.type(), CV_8UC3);
  const Fix fix = localizer.update(image, camera, {}, kGroundHeight + 60, 0);
  ASSERT_EQ(fix.status, Status::kOk) << to_text(fix.status);
  EXPECT_EQ(fix.method, Method::kOrientation);
  EXPECT_GT(fix.probability, 0.9);
  EXPECT_NEAR(fix.east_m, 0, 0.3);
  EXPECT_NEAR(fix.north_m, 0, 0.3);
}

TEST(Localizer, SaysSoOutsideTheMapAndAtItsEdge) {
  const GrayMap map(ground(), 5, kGroundHeight);
  Ideal beyond(map, ground(), 5, 700, 0);
  const Estimate before = beyond.localizer.estimate();
  EXPECT_EQ(beyond.show(testing::random_texture(240, 180, 1)).status, Status::kOutsideMap);
  EXPECT_EQ(beyond.localizer.estimate().east_m, before.east_m);
  // At 375 m, 10 m of the 35 m half footprint stick out over the edge at 400 m: still a fix.
  Ideal edge(map, ground(), 4, 375, 0);
  const Fix fix = edge.look();
  ASSERT_EQ(fix.status, Status::kOk);
  EXPECT_LT(std::hypot(fix.east_m - 375, fix.north_m), 0.5);
}

TEST(Localizer, RefusesBadInputAndStaysAsItWas) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const GrayMap map(ground(), 5, kGroundHeight);
  const Camera camera = camera_from_field_of_view(240, 180, 60 * kDegree);
  const cv::Mat image = testing::random_texture(240, 180, 1);
  Localizer localizer(map);
  EXPECT_EQ(localizer.estimate().status, Status::kNotStarted);
  EXPECT_EQ(localizer.update(image, camera, {}, 270, 0).status, Status::kNotStarted);
  EXPECT_EQ(localizer.predict(1, 1, 1), Status::kNotStarted);
  EXPECT_EQ(localizer.start(nan, 0, 1), Status::kNotFinite);
  ASSERT_EQ(localizer.start(10, 20, 5), Status::kOk);
  const Estimate before = localizer.estimate();
  EXPECT_EQ(localizer.predict(nan, 0, 1), Status::kNotFinite);
  EXPECT_EQ(localizer.predict(1, 0, -1), Status::kBadValue);
  EXPECT_EQ(localizer.update(image, camera, {nan, 0, 0}, 270, 0).status, Status::kNotFinite);
  EXPECT_EQ(localizer.update(image, camera, {}, nan, 0).status, Status::kNotFinite);
  EXPECT_EQ(localizer.update(image, camera, {}, 100, 0).status, Status::kBelowGround);
  EXPECT_EQ(localizer.update({}, camera, {}, 270, 0).status, Status::kBadImage);
  EXPECT_EQ(localizer.update(image, camera, {0, 3, 0}, 270, 0).status, Status::kNothingVisible);
  EXPECT_EQ(localizer.estimate().east_m, before.east_m);
  EXPECT_EQ(localizer.estimate().covariance_m2, before.covariance_m2);
  LocalizerOptions wrong;
  wrong.outlier_probability = 0;
  EXPECT_EQ(Localizer(map, wrong).start(0, 0, 1), Status::kBadValue);
}

}  // namespace
}  // namespace landfix::nav
