// What the localizer refuses: maps too old for a policy, images and poses that are nonsense. A reason, a state that is
// as it was, never a confident wrong place.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

#include "runtime/nav/localizer.h"
#include "tests/nav/scene.h"

namespace landfix::nav {
namespace {

using features::GridImage;
using testing::GrayMap;
using testing::Pose;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPi = 3.141592653589793, kDegree = kPi / 180;
constexpr double kGroundHeight = 210;

/// 300 m of fields at 0.25 m.
const GridImage& ground() {
  static const GridImage g = testing::ground_of(testing::countryside(1200, 31));
  return g;
}
const Camera kCamera = camera_from_field_of_view(240, 180, 60 * kDegree);

bool same(const Estimate& a, const Estimate& b) {
  return a.status == b.status && a.east_m == b.east_m && a.north_m == b.north_m && a.covariance_m2 == b.covariance_m2;
}

// ---- age

/// The ground north of 40 m was seen on day 1000, the rest on day 1300; nobody knows when that west of −100 m was.
class DatedMap : public GrayMap {
 public:
  DatedMap() : GrayMap(ground(), 4, kGroundHeight) {}
  std::optional<CaptureDays> capture_days(double west_m, double south_m, double, double north_m) const override {
    if (west_m < -100) return std::nullopt;
    return CaptureDays{north_m > 40 ? 1000 : 1300, south_m < 40 ? 1300 : 1000};
  }
};

/// One look from 60 m on day 1400 that allows 365 days: looking down, the ground within 60 m to the north or south and
/// within 70 m to the west or east may be in view, at a sigma of 2 m.
Fix look(const Pose& pose, std::optional<int> max_age_days, std::optional<int> today, bool expect_taken) {
  static const DatedMap map;
  LocalizerOptions options;
  options.max_map_age_days = max_age_days;
  options.today = today;
  Localizer localizer(map, options);
  EXPECT_EQ(localizer.start(pose.east_m + 2, pose.north_m + 1, 2), Status::kOk);
  const Estimate before = localizer.estimate();
  const Fix fix =
      localizer.update(testing::take_picture(ground(), kCamera, pose), kCamera, pose.attitude, kGroundHeight + 60, 0);
  EXPECT_EQ(same(before, localizer.estimate()), !expect_taken);
  return fix;
}

TEST(LocalizerAge, IsToldAndRefusedFromTheDayAfterTheLast) {
  const Pose south{0, -60, 60, {}}, north{0, 60, 60, {}};
  EXPECT_EQ(look(south, {}, 1400, true).map_age_days, 100);
  EXPECT_EQ(look(north, {}, 1400, true).map_age_days, 400) << "told without a policy too";
  EXPECT_EQ(look(south, 100, 1400, true).status, Status::kOk);
  EXPECT_EQ(look(north, 400, 1400, true).status, Status::kOk);
  for (const Fix& fix : {look(south, 99, 1400, false), look(north, 399, 1400, false)}) {
    EXPECT_EQ(fix.status, Status::kMapTooOld) << to_text(fix.status);
    EXPECT_TRUE(fix.map_age_days == 100 || fix.map_age_days == 400);
  }
}

TEST(LocalizerAge, UnknownIsTooOldWhereThereIsAPolicyOnly) {
  const Pose west{-90, -60, 60, {}}, south{0, -60, 60, {}};
  EXPECT_EQ(look(west, {}, 1400, true).map_age_days, std::nullopt);
  EXPECT_EQ(look(west, 10'000, 1400, false).status, Status::kMapTooOld);
  EXPECT_EQ(look(south, 10'000, {}, false).status, Status::kMapTooOld) << "today is not known";
  EXPECT_EQ(look(south, {}, {}, true).map_age_days, std::nullopt);
}

TEST(LocalizerAge, IsThatOfTheGroundInView) {
  // From 30 m south of the old ground's border, one looks at it, one away from it. Straight down shows 26 m to the
  // north.
  const double ahead = 45 * kDegree;
  EXPECT_EQ(look({0, -30, 60, {0, ahead, 0}}, 365, 1400, false).status, Status::kMapTooOld);
  EXPECT_EQ(look({0, -30, 60, {0, ahead, kPi}}, 365, 1400, true).map_age_days, 100);
  EXPECT_EQ(look({0, -30, 60, {}}, 365, 1400, true).map_age_days, 100);
}

// ---- images and poses

const ImageMap& all_layers() {
  static const ImageMap map(ground(), 4, kGroundHeight);
  return map;
}
const GrayMap& gray_values() {
  static const GrayMap map(ground(), 4, kGroundHeight);
  return map;
}

/// The camera as it is, if its focal length is `factor` times what the localizer is told.
Camera with_focal_length(double factor) {
  Camera camera = kCamera;
  camera.fx *= factor, camera.fy *= factor;
  return camera;
}

cv::Mat noise_image(uint64_t seed) {
  cv::Mat noise(180, 240, CV_8UC3);
  cv::RNG(seed * 0x9E3779B97F4A7C15).fill(noise, cv::RNG::UNIFORM, 0, 256);
  return noise;
}

/// What the camera gives at a place, and what the aircraft believes of its attitude there.
struct Shot {
  cv::Mat image;
  Attitude attitude;
};
using Camerawork = std::function<Shot(const Pose&)>;

/// At three places, with heading and height searched and not, the strict gate refuses what the image says and the state
/// stays as it was; the standard one, which one false fix in a hundred may pass, would let through one of six at
/// most.
void expect_no_fix(const Camerawork& shoot) {
  int over_standard = 0;
  for (int i = 0; i < 6; ++i) {
    const int place = i / 2;
    const Pose truth{20. * place - 10, 6 - 12. * place, 60, {0, 0, 1.4 + 0.7 * place}};
    const Shot shot = shoot(truth);
    LocalizerOptions options;
    options.gate = Gate::kStrict;
    if (i % 2) options.heading_sigma_rad = 2 * kDegree, options.height_sigma_m = 1.5;
    Localizer localizer(all_layers(), options);
    ASSERT_EQ(localizer.start(truth.east_m + 5, truth.north_m - 6, 8), Status::kOk);
    const Estimate before = localizer.estimate();
    const Fix fix = localizer.update(shot.image, kCamera, shot.attitude, kGroundHeight + 60, 0);
    EXPECT_TRUE(fix.status == Status::kImprobable || fix.status == Status::kNoTexture)
        << i << ": " << to_text(fix.status) << ", probability " << fix.probability;
    EXPECT_TRUE(same(before, localizer.estimate())) << i;
    over_standard += fix.probability > threshold_of(Gate::kStandard);
  }
  EXPECT_LE(over_standard, 1);
}

TEST(LocalizerNonsense, AFixWhereAllIsInOrder) {
  // The counterpart: what the others change is all that keeps them from a fix.
  LocalizerOptions options;
  options.gate = Gate::kStrict;
  for (int i = 0; i < 4; ++i) {
    const Pose truth{20. * i - 10, 6 - 12. * i, 60, {0, 0, 1.4 + 0.7 * i}};
    Localizer localizer(all_layers(), options);
    ASSERT_EQ(localizer.start(truth.east_m + 5, truth.north_m - 6, 8), Status::kOk);
    const Fix fix = localizer.update(testing::take_picture(ground(), kCamera, truth), kCamera, truth.attitude,
                                     kGroundHeight + 60, 0);
    EXPECT_EQ(fix.status, Status::kOk) << to_text(fix.status);
    EXPECT_LT(std::hypot(fix.east_m - truth.east_m, fix.north_m - truth.north_m), 0.3);
  }
}

TEST(LocalizerNonsense, AFocalLengthTwiceOfWhatIsTold) {
  expect_no_fix([](const Pose& p) {
    return Shot{testing::take_picture(ground(), with_focal_length(2), p), p.attitude};
  });
}

TEST(LocalizerNonsense, AFocalLengthHalfOfWhatIsTold) {
  expect_no_fix([](const Pose& p) {
    return Shot{testing::take_picture(ground(), with_focal_length(0.5), p), p.attitude};
  });
}

TEST(LocalizerNonsense, AHeadingUpsideDown) {
  expect_no_fix([](const Pose& p) {
    return Shot{testing::take_picture(ground(), kCamera, p), {0, 0, p.attitude.heading + kPi}};
  });
}

TEST(LocalizerNonsense, AnImageOfNoise) {
  expect_no_fix([](const Pose& p) { return Shot{noise_image(uint64_t(p.east_m + 100)), p.attitude}; });
}

TEST(LocalizerNonsense, ASaturatedImageGivesNoFixOrTheRightOne) {
  // Ever longer exposures: at first the dark parts suffice, in the end nothing is left.
  const Pose truth{-10, 6, 60, {0, 0, 0.7}};
  const cv::Mat image = testing::take_picture(ground(), kCamera, truth);
  LocalizerOptions options;
  options.gate = Gate::kStandard;
  for (const double exposure : {2., 4., 6., 8., 12., 40.}) {
    Localizer localizer(all_layers(), options);
    ASSERT_EQ(localizer.start(truth.east_m + 5, truth.north_m - 6, 8), Status::kOk);
    const Estimate before = localizer.estimate();
    const Fix fix = localizer.update(image * exposure, kCamera, truth.attitude, kGroundHeight + 60, 0);
    if (fix.status == Status::kOk) {
      EXPECT_LT(std::hypot(fix.east_m - truth.east_m, fix.north_m - truth.north_m), 1) << exposure;
    } else {
      EXPECT_TRUE(same(before, localizer.estimate())) << exposure << ": " << to_text(fix.status);
    }
    if (exposure <= 4) {
      EXPECT_EQ(fix.status, Status::kOk) << to_text(fix.status);
    }
    if (exposure >= 40) {
      EXPECT_NE(fix.status, Status::kOk) << fix.probability;
    }
  }
}

TEST(LocalizerNonsense, ABlankImageUnderAnyMethodAndSearch) {
  // The turned footprint has corners without data: their outline is no texture. Nor does a search that finds nothing to
  // compare blame the map.
  std::vector<std::optional<Method>> ways{{}};
  ways.insert(ways.end(), std::begin(kMethods), std::end(kMethods));
  for (const std::optional<Method> way : ways)
    for (const double shade : {0., 200.})
      for (const double heading_sigma_rad : {0., 2 * kDegree}) {
        LocalizerOptions options;
        options.method = way;
        options.heading_sigma_rad = heading_sigma_rad;
        Localizer localizer(all_layers(), options);
        ASSERT_EQ(localizer.start(5, -6, 8), Status::kOk);
        const Estimate before = localizer.estimate();
        const cv::Mat image(180, 240, CV_8UC3, cv::Scalar::all(shade));
        const Fix fix = localizer.update(image, kCamera, {0, 0, 0.7}, kGroundHeight + 60, 0);
        EXPECT_EQ(fix.status, Status::kNoTexture)
            << (way ? name_of(*way) : "auto") << " in " << shade << ": " << to_text(fix.status);
        EXPECT_TRUE(same(before, localizer.estimate()));
      }
}

TEST(LocalizerNonsense, AWholeFlightOfItLeavesTheTruthInTheEllipse) {
  // Without a gate every image is taken in. Sixteen in a row that show the ground upside down or twice as large must
  // not talk the filter out of the truth: 3.5 sigma hold it in two dimensions all but twice in a thousand.
  for (const bool upside_down : {true, false}) {
    testing::Random random(9);
    Localizer localizer(gray_values());
    Pose pose{-60, 10, 60, {}};
    ASSERT_EQ(localizer.start(pose.east_m + 3, pose.north_m - 2, 4), Status::kOk);
    for (int i = 0; i < 16; ++i) {
      pose.east_m += 6;
      ASSERT_EQ(localizer.predict(6 + random.normal(0.3), random.normal(0.3), 0.3), Status::kOk);
      const cv::Mat image = testing::take_picture(ground(), upside_down ? kCamera : with_focal_length(2), pose);
      localizer.update(image, kCamera, {0, 0, upside_down ? kPi : 0}, kGroundHeight + 60, i);
      const Estimate estimate = localizer.estimate();
      const double e = estimate.east_m - pose.east_m, n = estimate.north_m - pose.north_m;
      const auto& c = estimate.covariance_m2;
      EXPECT_LT((c[3] * e * e - 2 * c[1] * e * n + c[0] * n * n) / (c[0] * c[3] - c[1] * c[2]), 3.5 * 3.5)
          << (upside_down ? "upside down " : "twice as large ") << i;
    }
  }
}

// ---- numbers that are none

TEST(LocalizerNonsense, NumbersThatAreNone) {
  const Pose truth{0, 0, 60, {}};
  const cv::Mat image = testing::take_picture(ground(), kCamera, truth);
  Localizer localizer(gray_values());
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    EXPECT_EQ(localizer.start(0, 0, bad), Status::kNotFinite) << "covariance";
    EXPECT_EQ(localizer.start(0, bad, 5), Status::kNotFinite);
  }
  EXPECT_EQ(localizer.start(0, 0, -1), Status::kBadValue);
  EXPECT_EQ(localizer.update(image, kCamera, {}, kGroundHeight + 60, 0).status, Status::kNotStarted);
  ASSERT_EQ(localizer.start(1, 2, 5), Status::kOk);
  const Estimate before = localizer.estimate();
  const auto with = [&](double Camera::*what, double value) {
    Camera camera = kCamera;
    camera.*what = value;
    return localizer.update(image, camera, {}, kGroundHeight + 60, 0).status;
  };
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    EXPECT_EQ(localizer.predict(1, 1, bad), Status::kNotFinite) << "covariance";
    EXPECT_EQ(localizer.start(0, 0, bad), Status::kNotFinite) << "covariance";
    for (const Attitude& attitude : {Attitude{bad, 0, 0}, {0, bad, 0}, {0, 0, bad}})
      EXPECT_EQ(localizer.update(image, kCamera, attitude, kGroundHeight + 60, 0).status, Status::kNotFinite);
    EXPECT_EQ(localizer.update(image, kCamera, {}, bad, 0).status, Status::kNotFinite);
    for (double Camera::*what : {&Camera::fx, &Camera::fy, &Camera::cx, &Camera::cy})
      EXPECT_EQ(with(what, bad), Status::kNotFinite);
  }
  EXPECT_EQ(with(&Camera::fx, 0), Status::kBadValue);
  EXPECT_EQ(with(&Camera::fy, -100), Status::kBadValue);
  Camera masked = kCamera;
  masked.mask = cv::Mat(180, 200, CV_8U, cv::Scalar(255));
  EXPECT_EQ(localizer.update(image, masked, {}, kGroundHeight + 60, 0).status, Status::kBadImage);
  masked.mask = cv::Mat::zeros(180, 240, CV_8U);
  EXPECT_EQ(localizer.update(image, masked, {}, kGroundHeight + 60, 0).status, Status::kNothingVisible);
  for (const int type : {CV_8UC2, CV_16UC1, CV_32FC1})
    EXPECT_EQ(localizer.update(cv::Mat(180, 240, type, cv::Scalar::all(1)), kCamera, {}, kGroundHeight + 60, 0).status,
              Status::kBadImage);
  EXPECT_TRUE(same(before, localizer.estimate()));
  EXPECT_EQ(localizer.update(image, kCamera, {}, kGroundHeight + 60, 0).status, Status::kOk) << "still in order";
}

TEST(LocalizerNonsense, OptionsThatAreNone) {
  const auto start = [](const std::function<void(LocalizerOptions&)>& change) {
    LocalizerOptions options;
    change(options);
    return Localizer(gray_values(), options).start(0, 0, 5);
  };
  EXPECT_EQ(start([](auto&) {}), Status::kOk);
  for (double LocalizerOptions::*sigma :
       {&LocalizerOptions::attitude_sigma_rad, &LocalizerOptions::attitude_bias_sigma_rad,
        &LocalizerOptions::map_bias_sigma_m, &LocalizerOptions::change_sigma_m, &LocalizerOptions::orientation_sigma_px,
        &LocalizerOptions::heading_sigma_rad, &LocalizerOptions::height_sigma_m})
    for (const double bad : {kNan, kInfinity, -1.})
      EXPECT_EQ(start([&](auto& o) { o.*sigma = bad; }), Status::kBadValue);
  for (double LocalizerOptions::*share :
       {&LocalizerOptions::outlier_probability, &LocalizerOptions::min_coverage,
        &LocalizerOptions::search_tail_probability, &LocalizerOptions::min_pixels_per_residual})
    for (const double bad : {kNan, 0., -1.}) EXPECT_EQ(start([&](auto& o) { o.*share = bad; }), Status::kBadValue);
  EXPECT_EQ(start([](auto& o) { o.max_template_px = 8; }), Status::kBadValue);
  EXPECT_EQ(start([](auto& o) { o.max_window_px = 320; }), Status::kBadValue);
}

}  // namespace
}  // namespace landfix::nav
