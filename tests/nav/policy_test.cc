// What registration makes of bad input, of doubt and of maps that lack a layer: a reason, never a confident wrong
// place.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "runtime/nav/registration.h"
#include "tests/nav/scene.h"

namespace landfix::nav {
namespace {

using features::GridImage;
using testing::Random;
using testing::View;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPi = 3.141592653589793;

/// 300 m of fields at 0.25 m; the map at 1 m and 2 m.
const GridImage& ground() {
  static const GridImage g = testing::ground_of(testing::countryside(1200, 31));
  return g;
}
const ImageMap& map() {
  static const ImageMap m(testing::coarser(ground(), 4), 2);
  return m;
}

RegistrationPrior prior(double east_m = 0, double north_m = 0, double sigma_m = 15) {
  RegistrationPrior p;
  p.east_m = east_m, p.north_m = north_m;
  p.covariance_m2 = {sigma_m * sigma_m, 0, 0, sigma_m * sigma_m};
  return p;
}

/// All ways to register at a gate: auto and each method alone.
std::vector<RegistrationOptions> all_ways(Gate gate = Gate::kStandard) {
  std::vector<RegistrationOptions> ways(1 + std::size(kMethods));
  for (size_t i = 0; i < std::size(kMethods); ++i) ways[i + 1].method = kMethods[i];
  for (RegistrationOptions& way : ways) way.gate = gate;
  return ways;
}

std::string name(const RegistrationOptions& way) { return way.method ? name_of(*way.method) : "auto"; }

Registration run(const MapSource& source, const GridImage& patch, const RegistrationPrior& p,
                 const RegistrationOptions& options = {}) {
  Registration out;
  Registrar(source, options).run(patch, p, out);
  return out;
}

double apart(const Registration& r, double east_m, double north_m) {
  return std::hypot(r.peak.east_m - east_m, r.peak.north_m - north_m);
}

/// Every way gives exactly this status.
void expect_status(Status expected, const MapSource& source, const GridImage& patch, const RegistrationPrior& p,
                   const char* what) {
  for (const RegistrationOptions& way : all_ways())
    EXPECT_EQ(run(source, patch, p, way).status, expected) << what << ", " << name(way);
}

/// No way gives a fix at the standard gate that lies elsewhere than here.
int expect_no_wrong_fix(const MapSource& source, const GridImage& patch, const RegistrationPrior& p, double east_m,
                        double north_m, const std::string& what) {
  int fixes = 0;
  for (const RegistrationOptions& way : all_ways()) {
    const Registration r = run(source, patch, p, way);
    fixes += r.status == Status::kOk;
    if (r.status == Status::kOk) {
      EXPECT_LT(apart(r, east_m, north_m), 3) << what << ", " << name(way) << ", probability " << r.probability;
    }
    EXPECT_STRNE(to_text(r.status), "unknown status");
  }
  return fixes;
}

constexpr double kNowhere = 1e9;

// ---- images that say nothing

TEST(BadInput, BlankImages) {
  for (const double shade : {0., 77., 255.})
    expect_status(Status::kNoTexture, map(), {cv::Mat(96, 96, CV_8UC3, cv::Scalar::all(shade)), {}, -48, 48, 1},
                  prior(), "blank");
}

TEST(BadInput, SaturatedImages) {
  // Four times too long an exposure: nearly all is white, what is left may be right.
  for (int i = 0; i < 5; ++i) {
    GridImage patch = testing::look_down(ground(), {10. * i - 20, 5, {}, 96});
    patch.pixels = patch.pixels * 4;
    expect_no_wrong_fix(map(), patch, prior(), 10. * i - 20, 5, "saturated");
  }
}

TEST(BadInput, ImagesOfNoiseAlone) {
  for (int i = 0; i < 10; ++i) {
    GridImage patch{cv::Mat(96, 96, CV_8UC3), {}, -48, 48, 1};
    cv::RNG(uint64_t(i + 1)).fill(patch.pixels, cv::RNG::UNIFORM, 0, 256);
    EXPECT_EQ(expect_no_wrong_fix(map(), patch, prior(), kNowhere, 0, "noise"), 0);
  }
}

TEST(BadInput, ImagesSmallerThanATemplate) {
  for (const int side : {1, 2, 3, 5, 8, 12, 16, 24})
    for (int i = 0; i < 4; ++i)
      expect_no_wrong_fix(map(), testing::look_down(ground(), {5. * i, -3. * i, {}, side}), prior(), 5. * i, -3. * i,
                          std::to_string(side) + " px");
}

TEST(BadInput, ImagesThatAreNone) {
  expect_status(Status::kBadImage, map(), {}, prior(), "empty");
  for (const int type : {CV_8UC2, CV_16UC1, CV_32FC1, CV_8SC1, CV_64FC3})
    expect_status(Status::kBadImage, map(), {cv::Mat(96, 96, type, cv::Scalar::all(1)), {}, -48, 48, 1}, prior(),
                  "type");
  GridImage patch = testing::look_down(ground(), {});
  patch.valid = cv::Mat(128, 127, CV_8U, cv::Scalar(255));
  expect_status(Status::kBadImage, map(), patch, prior(), "mask of another size");
  patch.valid = cv::Mat(128, 128, CV_32F, cv::Scalar(1));
  expect_status(Status::kBadImage, map(), patch, prior(), "mask of another type");
  patch.valid = cv::Mat::zeros(128, 128, CV_8U);
  expect_status(Status::kBadImage, map(), patch, prior(), "nothing valid");
  RegistrationOptions rim;
  rim.rim_px = 64;
  patch.valid.release();
  EXPECT_EQ(run(map(), patch, prior(), rim).status, Status::kBadImage);
}

// ---- poses that are wrong

TEST(BadInput, AWrongFocalLength) {
  // Half as much again or two thirds of what was assumed: nothing there looks alike at the scale searched.
  for (int i = 0; i < 10; ++i) {
    RegistrationPrior p = prior();
    if (i % 2) p.scale_sigma = 0.02;
    const View view{8. * i - 40, 20 - 4. * i, {0, i % 4 < 2 ? 1.5 : 0.667}, 96};
    expect_no_wrong_fix(map(), testing::look_down(ground(), view), p, view.east_m, view.north_m, "focal length");
  }
}

TEST(BadInput, AnImageUpsideDown) {
  for (int i = 0; i < 10; ++i) {
    RegistrationPrior p = prior();
    if (i % 2) p.heading_sigma_rad = 0.03;
    const View view{8. * i - 40, 20 - 4. * i, {kPi, 1}, 96};
    expect_no_wrong_fix(map(), testing::look_down(ground(), view), p, view.east_m, view.north_m, "upside down");
  }
}

TEST(BadInput, APriorThatIsElsewhere) {
  // The aircraft is 90 m from where ±30 m are searched.
  for (int i = 0; i < 10; ++i)
    EXPECT_EQ(expect_no_wrong_fix(map(), testing::look_down(ground(), {-60. - i, 30. + 2 * i, {}, 96}),
                                  prior(50, 0, 10), kNowhere, 0, "elsewhere"),
              0);
}

// ---- regions that show nothing

TEST(BadInput, AFootprintOutsideOfTheMap) {
  const GridImage patch = testing::look_down(ground(), {});
  expect_status(Status::kOutsideMap, map(), patch, prior(10'000, 0), "far east");
  expect_status(Status::kOutsideMap, map(), patch, prior(0, -600), "south");
  expect_status(Status::kOutsideMap, map(), patch, prior(1e9, -1e9), "beyond all maps");
}

TEST(BadInput, AFootprintPartlyOutsideOfTheMap) {
  // The camera's ground goes on where the map's ends: of 96 m, 70 % and 30 % lie on the map.
  const GridImage half = [] {
    GridImage g = testing::coarser(ground(), 4);
    g.pixels = g.pixels.colRange(0, 150).clone();  // from -150 m to 0
    return g;
  }();
  const ImageMap western(half, 2);
  int fixes = 0;
  for (int i = 0; i < 5; ++i)
    fixes += expect_no_wrong_fix(western, testing::look_down(ground(), {-19.25, 12. * i - 24, {}, 96}),
                                 prior(-15, 0, 12), -19.25, 12. * i - 24, "70 % on the map");
  EXPECT_GE(fixes, 20) << "of 5 places in 5 ways";
  for (int i = 0; i < 5; ++i)
    EXPECT_EQ(expect_no_wrong_fix(western, testing::look_down(ground(), {19.25, 12. * i - 24, {}, 96}),
                                  prior(19, 12. * i - 24, 4), kNowhere, 0, "30 % on the map"),
              0);
}

TEST(BadInput, ARegionWithoutData) {
  GridImage empty = testing::coarser(ground(), 4);
  empty.valid = cv::Mat::zeros(empty.pixels.size(), CV_8U);
  expect_status(Status::kOutsideMap, ImageMap(empty, 2), testing::look_down(ground(), {}), prior(), "nodata");
}

TEST(BadInput, ARegionOfWater) {
  // Flat water, water with a buoy, and water with a swell of two gray levels; under the camera land, water or swell.
  const auto swell = [](uint64_t seed) {
    cv::Mat noise(1200, 1200, CV_8UC3);
    cv::RNG(seed).fill(noise, cv::RNG::UNIFORM, 58, 63);
    return testing::ground_of(noise);
  };
  const GridImage flat = testing::ground_of(cv::Mat(1200, 1200, CV_8UC3, cv::Scalar(70, 60, 50)));
  GridImage buoy = testing::ground_of(flat.pixels.clone());
  cv::circle(buoy.pixels, {700, 560}, 6, cv::Scalar(220, 90, 40), cv::FILLED);
  for (const GridImage& sea : {flat, buoy, swell(0x9E3779B97F4A7C15)}) {
    const ImageMap water(testing::coarser(sea, 4), 2);
    for (const GridImage& seen : {ground(), flat, swell(0xD1B54A32D192ED03)})
      for (int i = 0; i < 3; ++i)
        EXPECT_EQ(expect_no_wrong_fix(water, testing::look_down(seen, {9. * i, -7. * i, {}, 96}), prior(), kNowhere, 0,
                                      "water"),
                  0);
  }
}

// ---- numbers that are none

TEST(BadInput, PriorsThatAreNone) {
  const GridImage patch = testing::look_down(ground(), {});
  const auto with = [](const std::function<void(RegistrationPrior&)>& change) {
    RegistrationPrior p = prior();
    change(p);
    return p;
  };
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    expect_status(Status::kNotFinite, map(), patch, with([&](auto& p) { p.east_m = bad; }), "east");
    expect_status(Status::kNotFinite, map(), patch, with([&](auto& p) { p.north_m = bad; }), "north");
    for (size_t i = 0; i < 4; ++i)
      expect_status(Status::kNotFinite, map(), patch, with([&](auto& p) { p.covariance_m2[i] = bad; }), "covariance");
    expect_status(Status::kNotFinite, map(), patch, with([&](auto& p) { p.sigmas = bad; }), "sigmas");
    expect_status(Status::kNotFinite, map(), patch, with([&](auto& p) { p.heading_sigma_rad = bad; }), "heading");
    expect_status(Status::kNotFinite, map(), patch, with([&](auto& p) { p.scale_sigma = bad; }), "scale");
  }
  using Covariance = std::array<double, 4>;
  for (const Covariance& c :
       {Covariance{-1, 0, 0, 100}, {100, 0, 0, -1}, {100, 101, 101, 100}, {100, 50, -50, 100}, {0, 5, 5, 0}})
    expect_status(Status::kBadValue, map(), patch, with([&](auto& p) { p.covariance_m2 = c; }), "no covariance");
  expect_status(Status::kBadValue, map(), patch, with([](auto& p) { p.sigmas = 0; }), "no region");
  expect_status(Status::kBadValue, map(), patch, with([](auto& p) { p.heading_sigma_rad = -0.1; }), "heading");
  expect_status(Status::kBadValue, map(), patch, with([](auto& p) { p.scale_sigma = -0.1; }), "scale");
}

TEST(BadInput, ResolutionsAndPlacesThatAreNone) {
  GridImage patch = testing::look_down(ground(), {});
  for (const double gsd : {3., 0.7, 1e9, 4., 1e-300, 0., -1., kNan, kInfinity}) {
    patch.gsd_m = gsd;
    expect_status(Status::kBadValue, map(), patch, prior(), "resolution");
  }
  patch.gsd_m = 1;
  patch.west_m = kNan;
  expect_status(Status::kNotFinite, map(), patch, prior(), "origin");
  patch.west_m = 1e12;
  expect_status(Status::kOutsideMap, map(), patch, prior(), "origin far off");
}

TEST(BadInput, FinerImagesThanTheMapAreNoError) {
  const GridImage patch = testing::look_down(ground(), {11.25, -6.5, {}, 512, 0.25});
  const Registration r = run(map(), patch, prior());
  EXPECT_EQ(r.status, Status::kOk);
  EXPECT_LT(apart(r, 11.25, -6.5), 0.3);
}

TEST(BadInput, ACovarianceOfZeroSearchesOnePlace) {
  // Right or not, the evidence is of one place: unrelated content must not pass because nothing rivals it.
  const GridImage elsewhere = testing::ground_of(testing::countryside(1200, 32));
  int fixes = 0;
  for (int i = 0; i < 10; ++i) {
    const View view{8. * i - 40, 20 - 4. * i, {}, 96};
    const RegistrationPrior p = prior(view.east_m, view.north_m, 0);
    fixes += expect_no_wrong_fix(map(), testing::look_down(ground(), view), p, view.east_m, view.north_m, "one place");
    EXPECT_EQ(expect_no_wrong_fix(map(), testing::look_down(elsewhere, view), p, kNowhere, 0, "one place, unrelated"),
              0);
  }
  EXPECT_GE(fixes, 40) << "of 10 places in 5 ways";
}

TEST(BadInput, AHugeUncertaintyIsRefusedAtOnce) {
  const GridImage patch = testing::look_down(ground(), {});
  const auto begin = std::chrono::steady_clock::now();
  for (const double sigma : {1e4, 1e8, 1e150})
    expect_status(Status::kTooLarge, map(), patch, prior(0, 0, sigma), "huge");
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), 0.5);
}

TEST(BadInput, AnUnknownHeadingOrHeightIsSearchedAsFarAsItMakesSense) {
  // Sigmas beyond all reason neither mirror the image (a scale below zero) nor ask for more than all directions.
  RegistrationPrior p = prior(3, 4, 1);
  p.heading_sigma_rad = 1e9;
  const View upside_down{4, 5, {3.0, 1}, 96};
  RegistrationOptions options;
  options.method = Method::kOrientation;
  Registration r = run(map(), testing::look_down(ground(), upside_down), p, options);
  ASSERT_EQ(r.status, Status::kOk);
  EXPECT_NEAR(r.similarity.rotation_rad, 3.0, 0.01);
  p.heading_sigma_rad = 0;
  p.scale_sigma = 1e9;
  r = run(map(), testing::look_down(ground(), {4, 5, {0, 1.3}, 96}), p, options);
  ASSERT_EQ(r.status, Status::kOk);
  EXPECT_NEAR(r.similarity.scale, 1.3, 0.01);
  EXPECT_LT(apart(r, 4, 5), 1);
}

// ---- layers

constexpr MapLayer kGrayOnly[] = {MapLayer::kGray}, kContourOnly[] = {MapLayer::kContour},
                   kOrientationOnly[] = {MapLayer::kOrientation};

TEST(Auto, TakesWhatTheMapHas) {
  const GridImage image = testing::coarser(ground(), 4), patch = testing::look_down(ground(), {7, 8});
  const auto method_on = [&](std::span<const MapLayer> layers) {
    const Registration r = run(ImageMap(image, 2, 0, layers), patch, prior());
    EXPECT_EQ(r.status, Status::kOk);
    EXPECT_LT(apart(r, 7, 8), 0.5);
    return r.method;
  };
  EXPECT_EQ(method_on(kMapLayers), Method::kOrientation);
  EXPECT_EQ(method_on(kGrayOnly), Method::kGray);
  EXPECT_EQ(method_on(kOrientationOnly), Method::kOrientation);
  const Registration contour = run(ImageMap(image, 2, 0, kContourOnly), patch, prior());
  EXPECT_EQ(contour.method, Method::kContour);
  EXPECT_LT(apart(contour, 7, 8), 1);
}

TEST(Methods, HaveNamesThatLeadBack) {
  for (const Method method : kMethods) EXPECT_EQ(method_of(name_of(method)), method);
  EXPECT_EQ(method_of("ncc"), std::nullopt);
  EXPECT_EQ(method_of(""), std::nullopt);
}

TEST(Auto, SaysSoWhereTheLayerIsMissing) {
  const GridImage image = testing::coarser(ground(), 4), patch = testing::look_down(ground(), {});
  expect_status(Status::kNoLayer, ImageMap(image, 2, 0, {}), patch, prior(), "no layers at all");
  RegistrationOptions gray;
  gray.method = Method::kGray;
  EXPECT_EQ(run(ImageMap(image, 2, 0, kOrientationOnly), patch, prior(), gray).status, Status::kNoLayer);
}

/// Orientation of one map and gray of another.
class Chimera : public MapSource {
 public:
  Chimera(const MapSource& orientation, const MapSource& gray) : orientation_(orientation), gray_(gray) {}
  std::pair<double, double> gsd_range_m(MapLayer layer) const override {
    return layer == MapLayer::kOrientation || layer == MapLayer::kGray ? of(layer).gsd_range_m(layer)
                                                                       : std::pair(0., 0.);
  }
  Status read(MapLayer layer, double west_m, double south_m, double east_m, double north_m, double gsd_m,
              GridImage& window) const override {
    return of(layer).read(layer, west_m, south_m, east_m, north_m, gsd_m, window);
  }
  std::optional<double> ground_height_m(double, double) const override { return 0; }

 private:
  const MapSource& of(MapLayer layer) const { return layer == MapLayer::kGray ? gray_ : orientation_; }
  const MapSource &orientation_, &gray_;
};

TEST(Auto, AsksForASecondOpinionWhereItIsNotSure) {
  // Small templates of another season, noisy: orientation alone is in doubt. A gray map of the same day at the same
  // place confirms; the same 40 m aside casts doubt, or prevails where it is the surer one.
  const GridImage today = testing::ground_of(testing::countryside(1200, 31, 1));
  GridImage aside = testing::coarser(today, 4);
  const ImageMap right(aside, 1, 0, kGrayOnly);
  aside.west_m += 40;
  const ImageMap shifted(aside, 1, 0, kGrayOnly);
  const Chimera agreeing(map(), right), contradicting(map(), shifted);
  RegistrationOptions alone;
  alone.method = Method::kOrientation;
  int doubtful = 0;
  for (int i = 0; i < 30; ++i) {
    GridImage patch = testing::look_down(today, {3. * i - 45, 30. - 2 * i, {}, 40});
    const RegistrationPrior p = prior(0, 0, 25);
    const Registration first = run(map(), patch, p, alone);
    if (first.status != Status::kImprobable || apart(first, 3. * i - 45, 30. - 2 * i) > 2) continue;
    ++doubtful;
    RegistrationOptions gray;
    gray.method = Method::kGray;
    const Registration with = run(agreeing, patch, p), against = run(contradicting, patch, p);
    const Registration confirming = run(agreeing, patch, p, gray), other = run(contradicting, patch, p, gray);
    EXPECT_GE(with.probability, std::max(first.probability, confirming.probability));
    EXPECT_LT(apart(with, 3. * i - 45, 30. - 2 * i), 2);
    EXPECT_LE(against.probability, std::max(first.probability, other.probability));
  }
  EXPECT_GE(doubtful, 3);
}

// ---- the gate

TEST(Gate, LetsThroughByProbabilityAlone) {
  EXPECT_EQ(threshold_of(Gate::kNone), 0);
  EXPECT_GT(threshold_of(Gate::kStandard), 0.5);
  EXPECT_GT(threshold_of(Gate::kStrict), threshold_of(Gate::kStandard));
  EXPECT_LT(threshold_of(Gate::kStrict), 1);
  const GridImage elsewhere = testing::ground_of(testing::countryside(1200, 32));
  for (const GridImage& scene : {ground(), elsewhere})
    for (const RegistrationOptions& way : all_ways(Gate::kNone)) {
      RegistrationOptions standard = way, strict = way;
      standard.gate = Gate::kStandard;
      strict.gate = Gate::kStrict;
      const GridImage patch = testing::look_down(scene, {2, 3});
      const Registration a = run(map(), patch, prior(), way), b = run(map(), patch, prior(), standard),
                         c = run(map(), patch, prior(), strict);
      EXPECT_EQ(a.status, Status::kOk);
      EXPECT_EQ(a.probability, b.probability);
      EXPECT_EQ(a.probability, c.probability);
      EXPECT_EQ(b.status, a.probability < threshold_of(Gate::kStandard) ? Status::kImprobable : Status::kOk);
      EXPECT_EQ(c.status, a.probability < threshold_of(Gate::kStrict) ? Status::kImprobable : Status::kOk);
    }
}

TEST(Probability, GrowsWithTheGapAndStaysWithinReason) {
  for (const Method method : kMethods) {
    for (const double spread : {0., 1e-9, 0.02, 0.1, 1.}) {
      double before = 0;
      for (const double gap : {-1., -0.1, 0., 0.01, 0.03, 0.1, 0.3, 1., 2.}) {
        Evidence e{0.5, gap, spread};
        const double p = probability_of(method, e);
        EXPECT_GT(p, 0);
        EXPECT_LT(p, 1);
        EXPECT_GE(p, before) << name_of(method) << " " << gap << " " << spread;
        before = p;
      }
    }
    EXPECT_GT(probability_of(method, {0.6, 0.4, 0.05, 0.5, 1000}), 0.99);
    EXPECT_LT(probability_of(method, {0.2, 0.001, 0.05, 5, 1000}), 0.5);
    EXPECT_LE(probability_of(method, {0.9, 0, 0.05, 0.4, 1000}), 0.55)
        << name_of(method) << ": two peaks of one height, however sharp, are a toss-up at best";
  }
}

TEST(Probability, OfTwoMethodsGrowsByAgreementAndFallsByContradiction) {
  for (const double a : {0.0001, 0.1, 0.5, 0.8, 0.99, 0.9999})
    for (const double b : {0.0001, 0.1, 0.5, 0.8, 0.99, 0.9999}) {
      const double with = combined_probability(a, b, true), against = combined_probability(a, b, false);
      EXPECT_GT(with, 0);
      EXPECT_LT(with, 1);
      EXPECT_GT(against, 0);
      EXPECT_GE(with, std::max(a, b) - 1e-12);
      EXPECT_LE(against, std::max(a, b) + 1e-12);
      EXPECT_EQ(with, combined_probability(b, a, true));
      EXPECT_EQ(against, combined_probability(b, a, false));
    }
  EXPECT_LE(combined_probability(0.99, 0.99, false), 0.95) << "two that are sure of different places";
}

}  // namespace
}  // namespace landfix::nav
