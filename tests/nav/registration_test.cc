// Registration over levels, rotation and scale: where, how turned, how sure; on fields through the seasons.
#include "runtime/nav/registration.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "runtime/nav/point_mass_filter.h"
#include "tests/nav/scene.h"

namespace landfix::nav {
namespace {

using features::GridImage;
using testing::Random;
using testing::View;

constexpr double kDegree = 0.017453292519943295;

/// 360 m of fields at 0.25 m, as one season shows them.
const GridImage& ground(uint64_t season) {
  static const GridImage seasons[] = {testing::ground_of(testing::countryside(1440, 7, 0)),
                                      testing::ground_of(testing::countryside(1440, 7, 1))};
  return seasons[season];
}

/// The first season at 0.5 m to 4 m.
const ImageMap& map() {
  static const ImageMap m(testing::coarser(ground(0), 2), 4);
  return m;
}

RegistrationPrior prior(double east_m, double north_m, double sigma_m) {
  RegistrationPrior p;
  p.east_m = east_m, p.north_m = north_m;
  p.covariance_m2 = {sigma_m * sigma_m, 0, 0, sigma_m * sigma_m};
  return p;
}

Registration run(const MapSource& source, const GridImage& patch, const RegistrationPrior& p,
                 const RegistrationOptions& options) {
  Registration out;
  Registrar(source, options).run(patch, p, out);
  return out;
}

RegistrationOptions only(Method method, Gate gate = Gate::kNone) {
  RegistrationOptions o;
  o.method = method;
  o.gate = gate;
  return o;
}

double apart(const Registration& r, double east_m, double north_m) {
  return std::hypot(r.peak.east_m - east_m, r.peak.north_m - north_m);
}

/// The image with white noise of this many gray levels.
GridImage noisy(GridImage image, double sigma, Random& random) {
  cv::Mat noise(image.pixels.size(), CV_16SC(image.pixels.channels()));
  cv::RNG(uint64_t(random.uniform(1, 1e9))).fill(noise, cv::RNG::NORMAL, 0, sigma);
  cv::Mat out;
  cv::add(image.pixels, noise, out, cv::noArray(), image.pixels.type());
  image.pixels = out;
  return image;
}

/// Longer and shorter sigma of a covariance and the direction of the longer, counter-clockwise from east within ±90°.
struct Ellipse {
  explicit Ellipse(const std::array<double, 4>& c) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes((Eigen::Matrix2d() << c[0], c[1], c[2], c[3]).finished());
    shorter_m = std::sqrt(axes.eigenvalues()[0]);
    longer_m = std::sqrt(axes.eigenvalues()[1]);
    direction_rad = std::atan(axes.eigenvectors()(1, 1) / axes.eigenvectors()(0, 1));
  }
  double longer_m, shorter_m, direction_rad;
};

double mahalanobis2(const std::array<double, 4>& c, double east_m, double north_m) {
  return (c[3] * east_m * east_m - 2 * c[1] * east_m * north_m + c[0] * north_m * north_m) /
         (c[0] * c[3] - c[1] * c[2]);
}

class EveryMethod : public ::testing::TestWithParam<Method> {};
std::string name_of_case(const ::testing::TestParamInfo<Method>& info) { return name_of(info.param); }
INSTANTIATE_TEST_SUITE_P(Methods, EveryMethod, ::testing::ValuesIn(kMethods), name_of_case);

TEST_P(EveryMethod, FindsRotationAndScaleCoarseToFine) {
  // 256 px over ±200 px; heading and height 4° and 4 % wrong, each way, with a prior of 3° and 3 %.
  Registrar registrar(map(), only(GetParam()));
  Registration r;
  for (const int turn : {1, -1})
    for (const int stretch : {1, -1}) {
      if (GetParam() != Method::kOrientation && (turn < 0 || stretch > 0)) continue;  // the others take long
      const Similarity error{4 * turn * kDegree, 1 + 0.04 * stretch};
      const double east = 37.3 * stretch, north = -52.1 * turn;
      RegistrationPrior p = prior(-10, 10, 100. / 3);
      p.heading_sigma_rad = 3 * kDegree;
      p.scale_sigma = 0.03;
      registrar.run(testing::look_down(ground(0), {east, north, error, 256, 0.5}), p, r);
      ASSERT_EQ(r.status, Status::kOk);
      EXPECT_GT(r.gsd_m, 0.5) << "searched coarser, then refined";
      EXPECT_LT(apart(r, east, north), 0.5);
      const bool contour = GetParam() == Method::kContour;  // distances truncated and rounded tell less
      EXPECT_NEAR(r.similarity.rotation_rad, error.rotation_rad, (contour ? 1 : 0.3) * kDegree);
      EXPECT_NEAR(r.similarity.scale, error.scale, contour ? 0.015 : 0.005);
      EXPECT_LT(r.rotation_sigma_rad, (contour ? 2 : 1) * kDegree);
      EXPECT_GT(r.rotation_sigma_rad, 0);
      EXPECT_LT(r.scale_sigma, contour ? 0.03 : 0.02);
      EXPECT_GT(r.probability, 0.95);
    }
}

TEST_P(EveryMethod, OverLevelsAnswersAsTheExhaustiveSearchAtTheFinest) {
  RegistrationOptions coarse = only(GetParam()), exhaustive = coarse;
  const bool contour = GetParam() == Method::kContour;  // a small template holds too few of them
  coarse.min_template_px = contour ? 90 : 30;
  coarse.search_budget_px = 1;
  exhaustive.search_budget_px = 1e12;
  Random random(4);
  for (int i = 0; i < 3; ++i) {
    const View view{random.uniform(-20, 20),
                    random.uniform(-20, 20),
                    {random.normal(2 * kDegree), 1 + random.normal(0.02)},
                    contour ? 192 : 128,
                    0.5};
    RegistrationPrior p = prior(0, 0, 10);
    p.heading_sigma_rad = 2 * kDegree;
    p.scale_sigma = 0.02;
    const GridImage patch = testing::look_down(ground(0), view);
    const Registration a = run(map(), patch, p, coarse), b = run(map(), patch, p, exhaustive);
    ASSERT_EQ(a.status, Status::kOk);
    ASSERT_EQ(b.status, Status::kOk);
    EXPECT_EQ(a.gsd_m, contour ? 1 : 2);
    EXPECT_EQ(b.gsd_m, 0.5);
    EXPECT_LT(apart(b, view.east_m, view.north_m), 0.4);
    EXPECT_LT(apart(a, b.peak.east_m, b.peak.north_m), 0.2);
    // Contours are so wide that similarities within two pixels of the edge look alike.
    EXPECT_NEAR(a.similarity.rotation_rad, b.similarity.rotation_rad, (contour ? 2 : 0.4) * kDegree);
    EXPECT_NEAR(a.similarity.scale, b.similarity.scale, contour ? 0.035 : 0.007);
  }
}

TEST_P(EveryMethod, KeepsItsBuffersAndNotItsPast) {
  // One registrar over changing sizes, levels and priors answers as new ones do, bit for bit.
  Registrar kept(map(), only(GetParam()));
  Registration a;
  for (const auto& [side, gsd, sigma] : {std::tuple(128, 0.5, 8.), {60, 1., 15.}, {200, 0.5, 12.}, {128, 0.5, 0.}}) {
    const GridImage patch = testing::look_down(ground(0), {5, 6, {0.02, 1}, side, gsd});
    RegistrationPrior p = prior(3, 4, sigma);
    p.heading_sigma_rad = side == 60 ? 0 : 0.02;
    kept.run(patch, p, a);
    const Registration b = run(map(), patch, p, only(GetParam()));
    ASSERT_EQ(a.status, b.status);
    EXPECT_EQ(a.peak.east_m, b.peak.east_m);
    EXPECT_EQ(a.peak.north_m, b.peak.north_m);
    EXPECT_EQ(a.probability, b.probability);
    EXPECT_EQ(a.covariance_m2, b.covariance_m2);
    EXPECT_EQ(a.similarity.rotation_rad, b.similarity.rotation_rad);
    EXPECT_EQ(cv::norm(a.surface.pixels, b.surface.pixels, cv::NORM_INF), 0);
    EXPECT_EQ(cv::norm(a.likelihood.values.pixels, b.likelihood.values.pixels, cv::NORM_INF), 0);
  }
}

TEST_P(EveryMethod, NamesTheEllipseThatHoldsTheTruth) {
  // 200 places, of which the camera sees 30 % as they are (contours bear less: 70 %), the rest of its contrast comes
  // from elsewhere, and noise: at least 90 % inside of 95 %, and no ellipse that is far too large (0.35 pixels an axis
  // are always granted).
  const ImageMap coarse(testing::coarser(ground(0), 4), 1);
  const double same = GetParam() == Method::kContour ? 0.7 : 0.3;
  const GridImage changed = testing::ground_of(ground(0).pixels * same + testing::countryside(1440, 55) * (1 - same));
  Registrar registrar(coarse, only(GetParam()));
  Registration r;
  Random random(21);
  int inside = 0, found = 0;
  double squares = 0, variances = 0;
  for (int i = 0; i < 200; ++i) {
    const double east = random.uniform(-100, 100), north = random.uniform(-100, 100);
    const GridImage patch = noisy(testing::look_down(changed, {east, north, {}, 64}), 10, random);
    registrar.run(patch, prior(east + random.uniform(-8, 8), north + random.uniform(-8, 8), 5), r);
    if (r.status == Status::kNoTexture && GetParam() == Method::kContour) continue;  // too few contours
    ASSERT_EQ(r.status, Status::kOk);
    if (apart(r, east, north) > 8) continue;  // another peak: the probability's business
    ++found;
    inside += mahalanobis2(r.covariance_m2, r.peak.east_m - east, r.peak.north_m - north) <= 5.99;
    squares += std::pow(apart(r, east, north), 2);
    variances += r.covariance_m2[0] + r.covariance_m2[3];
  }
  const double rms = std::sqrt(squares / found), expected = std::sqrt(variances / found);
  std::printf("%s: %d of %d inside, RMS %.2f m, expected %.2f m\n", name_of(GetParam()), inside, found, rms, expected);
  EXPECT_GE(found, GetParam() == Method::kContour ? 120 : 180);
  EXPECT_GE(inside, 0.9 * found);
  EXPECT_LT(expected, std::max((GetParam() == Method::kContour ? 5 : 3) * rms, 0.8));
}

TEST_P(EveryMethod, IsRarelySureOfWhatIsNotThere) {
  // 100 images of other places at the standard gate, 30 of this place with some noise.
  const ImageMap coarse(testing::coarser(ground(0), 4), 1);
  const GridImage elsewhere = testing::ground_of(testing::countryside(1440, 99));
  Registrar registrar(coarse, only(GetParam(), Gate::kStandard));
  Registration r;
  Random random(5);
  int accepted = 0, improbable = 0, right = 0, wrong = 0;
  for (int i = 0; i < 100; ++i) {
    const View view{random.uniform(-50, 50), random.uniform(-50, 50), {}, 96};
    registrar.run(testing::look_down(elsewhere, view), prior(0, 0, 20), r);
    accepted += r.status == Status::kOk;
    improbable += r.status == Status::kImprobable;
    if (i >= 30) continue;
    registrar.run(noisy(testing::look_down(ground(0), view), 20, random), prior(0, 0, 20), r);
    if (r.status == Status::kOk) ++(apart(r, view.east_m, view.north_m) < 3 ? right : wrong);
  }
  EXPECT_LE(accepted, 1);
  EXPECT_EQ(improbable, 100 - accepted);
  EXPECT_EQ(wrong, 0);
  EXPECT_GE(right, GetParam() == Method::kContour ? 20 : 28);
}

TEST(Registration, FindsTheSeasonedGroundByOrientationAndIsSure) {
  // Every field has another colour than in the map. 8 places, rotation and scale searched.
  Registrar registrar(map(), only(Method::kOrientation, Gate::kStandard));
  Registration r;
  Random random(6);
  int right = 0, wrong = 0;
  for (int i = 0; i < 8; ++i) {
    const View view{random.uniform(-60, 60),
                    random.uniform(-60, 60),
                    {random.normal(2 * kDegree), 1 + random.normal(0.02)},
                    200,
                    0.5};
    RegistrationPrior p = prior(0, 0, 25);
    p.heading_sigma_rad = 2 * kDegree;
    p.scale_sigma = 0.02;
    registrar.run(testing::look_down(ground(1), view), p, r);
    if (r.status == Status::kOk) ++(apart(r, view.east_m, view.north_m) < 2 ? right : wrong);
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GE(right, 7);
}

constexpr uint64_t kThen = 0x9E3779B97F4A7C15, kToday = 0xD1B54A32D192ED03;  // streams of small seeds are correlated

/// Bare ground with one straight road through (0, 0), counter-clockwise from east by `direction`; noise of its own.
GridImage lone_road(double direction_rad, uint64_t seed) {
  cv::Mat image(1200, 1200, CV_8UC3, cv::Scalar(100, 110, 90));
  const cv::Point2d middle(599.5, 599.5), along(2000 * std::cos(direction_rad), -2000 * std::sin(direction_rad));
  cv::line(image, middle - along, middle + along, cv::Scalar(200, 195, 190), 32, cv::LINE_AA);
  cv::Mat noise(image.size(), CV_16SC3);
  cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0, 12);
  cv::add(image, noise, image, cv::noArray(), CV_8U);
  return testing::ground_of(image);
}

TEST_P(EveryMethod, IsUnsureAlongALoneRoad) {
  // Noise makes bumps along the crest, whole distances make steps: less long by orientation and contours.
  const double least = GetParam() == Method::kContour ? 2 : GetParam() == Method::kOrientation ? 3 : 10;
  for (const double degrees : {0., 30., 45., 90., 135.}) {
    const ImageMap road(testing::coarser(lone_road(degrees * kDegree, kThen), 4), 1);
    const Registration r =
        run(road, testing::look_down(lone_road(degrees * kDegree, kToday), {}), prior(0, 0, 10), only(GetParam()));
    ASSERT_EQ(r.status, Status::kOk) << degrees;
    const Ellipse e(r.covariance_m2);
    EXPECT_GT(e.longer_m, least * e.shorter_m) << degrees;
    EXPECT_LT(e.shorter_m, 1);
    EXPECT_LT(std::abs(std::sin(e.direction_rad - degrees * kDegree)), std::sin(10 * kDegree)) << degrees;
    EXPECT_LT(r.probability, 0.9) << "places along the road rival";
    // Across the road it is right.
    EXPECT_LT(std::abs(r.peak.north_m * std::cos(degrees * kDegree) - r.peak.east_m * std::sin(degrees * kDegree)), 1);
  }
  const Registration r =
      run(map(), testing::look_down(ground(0), {4, 5, {}, 128, 0.5}), prior(0, 0, 10), only(GetParam()));
  const Ellipse e(r.covariance_m2);
  EXPECT_LT(e.longer_m, 2 * e.shorter_m);
  EXPECT_LT(e.longer_m, 1);
}

TEST(Registration, HasALikelihoodThatThePointMassFilterTakes) {
  // Mean 1 over the positions searched, the outliers' share beyond; filtered from 10 m away it stands at the truth.
  const RegistrationOptions options = only(Method::kOrientation);
  const Registration r = run(map(), testing::look_down(ground(0), {7, -5, {}, 128, 0.5}), prior(0, 0, 8), options);
  ASSERT_EQ(r.status, Status::kOk);
  EXPECT_NEAR(cv::mean(r.likelihood.values.pixels, r.likelihood.values.valid)[0], 1, 1e-4);
  EXPECT_EQ(r.likelihood.outside, options.outlier_probability);
  EXPECT_EQ(r.likelihood.values.west_m, r.surface.west_m);
  EXPECT_EQ(r.likelihood.values.north_m, r.surface.north_m);
  EXPECT_EQ(r.likelihood.values.pixels.size(), r.surface.pixels.size());
  // ±24 m around the prior, each position a pixel.
  EXPECT_LE(r.surface.west_m, -24);
  EXPECT_GE(r.surface.west_m + r.surface.pixels.cols * r.surface.gsd_m, 24);
  PointMassFilter filter;
  ASSERT_EQ(filter.start(0, 0, 8), Status::kOk);
  ASSERT_EQ(filter.update(r.likelihood), Status::kOk);
  const PointMassFilter::Moments m = filter.moments();
  EXPECT_LT(std::hypot(m.east_m - 7, m.north_m + 5), 1.5);
}

TEST_P(EveryMethod, KeepsTwinsApartAndIsNotSure) {
  // 110 m square, west of the middle, are copied to 120 m east; the camera sees the 60 m inside. Both are found equally
  // likely; which of them it is, nothing tells.
  GridImage twins = testing::coarser(ground(0), 4);
  const cv::Rect here(60, 125, 110, 110);
  const cv::Mat copy = twins.pixels(here).clone();
  copy.copyTo(twins.pixels(here + cv::Point(120, 0)));
  const GridImage patch{copy(cv::Rect(25, 25, 60, 60)).clone(), {}, -30, 30, 1};
  const ImageMap m(twins, 1);
  const Registration r = run(m, patch, prior(0, 0, 28), only(GetParam(), Gate::kStandard));
  EXPECT_EQ(r.status, Status::kImprobable);
  EXPECT_LT(r.peak.gap, 1e-3);
  EXPECT_LT(r.probability, 0.55);
  const double east = -180 + 60 + 55, north = 180 - 125 - 55;
  const auto mass = [&](double e, double n) {
    const GridImage& l = r.likelihood.values;
    const cv::Rect around(int(std::lround(l.column_of(e))) - 3, int(std::lround(l.row_of(n))) - 3, 7, 7);
    return cv::sum(l.pixels(around))[0] / cv::sum(l.pixels)[0];
  };
  EXPECT_NEAR(mass(east, north), mass(east + 120, north), 0.1);
  EXPECT_GT(mass(east, north) + mass(east + 120, north), GetParam() == Method::kContour ? 0.2 : 0.9);
}

TEST(Registration, GuardsThePoseByItsPrior) {
  // A heading known to 1° is not turned by 5° however well that would match: six of six stay.
  Random random(3);
  for (int i = 0; i < 6; ++i) {
    RegistrationPrior p = prior(0, 0, 10);
    p.heading_sigma_rad = 1 * kDegree;
    const double east = random.uniform(-20, 20), north = random.uniform(-20, 20);
    const Registration r =
        run(map(), testing::look_down(ground(0), {east, north, {}, 128, 0.5}), p, only(Method::kOrientation));
    ASSERT_EQ(r.status, Status::kOk);
    EXPECT_LT(std::abs(r.similarity.rotation_rad), 0.3 * kDegree);
    EXPECT_EQ(r.similarity.scale, 1);
    EXPECT_EQ(r.scale_sigma, 0);
  }
}

}  // namespace
}  // namespace landfix::nav
