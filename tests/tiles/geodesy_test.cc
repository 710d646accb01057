// Geodesy against PROJ, whose UTM and UPS share no code with GeographicLib.
#include "tiles/geodesy.h"

#include <gtest/gtest.h>
#include <proj.h>

#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <string>

#include "tests/tiles/random.h"

namespace landfix::tiles {
namespace {

using tests::Random;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kMillimetre = 1e-3;

struct Destroy {
  void operator()(PJ* p) const { proj_destroy(p); }
};
using Projection = std::unique_ptr<PJ, Destroy>;

// PROJ's own projection of a zone: radians in, metres out, no datum shift in between.
PJ* projection(const Zone& zone) {
  static std::map<std::pair<int, bool>, Projection> all;
  Projection& p = all[{zone.number, zone.north}];
  if (!p) {
    const std::string name = zone.number == 0 ? "+proj=ups" : "+proj=utm +zone=" + std::to_string(zone.number);
    p.reset(proj_create(PJ_DEFAULT_CTX, (name + (zone.north ? "" : " +south") + " +ellps=WGS84").c_str()));
  }
  return p.get();
}

double distance(const GridPoint& g, const PJ_COORD& c) { return std::hypot(g.east_m - c.xy.x, g.north_m - c.xy.y); }

// Metres on the ellipsoid between two close places.
double ground_distance(const GeodeticPoint& a, const Geodetic& b) {
  const double e2 = 0.00669437999014, s = std::sin(b.latitude_rad), w = 1 - e2 * s * s;
  const double meridian = 6378137 * (1 - e2) / std::pow(w, 1.5),
               parallel = 6378137 / std::sqrt(w) * std::cos(b.latitude_rad);
  const double longitude = std::remainder(a.longitude_rad - b.longitude_rad, 2 * std::numbers::pi);
  return std::hypot(meridian * (a.latitude_rad - b.latitude_rad), parallel * longitude);
}

struct Worst {
  double forward_m = 0, inverse_m = 0, scale = 0, convergence_rad = 0;
};

void compare(const Zone& zone, const Geodetic& place, Worst& worst, bool factors) {
  const auto grid = grid_from_geodetic(zone, place);
  ASSERT_TRUE(grid);
  const PJ_COORD in = proj_coord(place.longitude_rad, place.latitude_rad, 0, 0);
  const PJ_COORD expected = proj_trans(projection(zone), PJ_FWD, in);
  worst.forward_m = std::max(worst.forward_m, distance(*grid, expected));
  const auto back = geodetic_from_grid(zone, grid->east_m, grid->north_m);
  ASSERT_TRUE(back);
  worst.inverse_m = std::max(worst.inverse_m, ground_distance(*back, place));
  if (!factors) return;
  const PJ_FACTORS f = proj_factors(projection(zone), in);
  worst.scale = std::max(worst.scale, std::abs(grid->scale - f.meridional_scale));
  worst.convergence_rad =
      std::max(worst.convergence_rad,
               std::abs(std::remainder(grid->convergence_rad - f.meridian_convergence, 2 * std::numbers::pi)));
}

void expect_same(const Worst& worst) {
  EXPECT_LT(worst.forward_m, kMillimetre);
  EXPECT_LT(worst.inverse_m, kMillimetre);
  EXPECT_LT(worst.scale, 1e-6);
  EXPECT_LT(worst.convergence_rad, 1e-6);
  for (const auto& [name, value] : {std::pair{"forward_m", worst.forward_m},
                                    {"inverse_m", worst.inverse_m},
                                    {"scale", worst.scale},
                                    {"convergence_rad", worst.convergence_rad}})
    testing::Test::RecordProperty(name, testing::PrintToString(value));
}

TEST(Geodesy, MatchesProjToAMillimetreInEveryUtmZone) {
  // 50 000 points: all zones, both hemispheres' false northings, latitudes to the poles, up to 10 degrees from the
  // central meridian: the zone is 6 degrees wide, so most lie beyond its edges.
  Random random(1);
  Worst worst;
  for (int i = 0; i < 50000; ++i) {
    const Zone zone{int(random.integer(1, 60)), random.integer(0, 1) == 1};
    const double meridian = 6.0 * zone.number - 183;
    compare(zone, {random.uniform(-89.9, 89.9) * kDegree, (meridian + random.uniform(-10, 10)) * kDegree}, worst,
            i % 10 == 0);
  }
  expect_same(worst);
}

TEST(Geodesy, MatchesProjFarBeyondTheZone) {
  // 20 000 points 10 to 30 degrees from the central meridian: a mission that keeps one zone over several.
  Random random(2);
  Worst worst;
  for (int i = 0; i < 20000; ++i) {
    const Zone zone{int(random.integer(1, 60)), random.integer(0, 1) == 1};
    const double offset = random.uniform(10, 30) * (random.integer(0, 1) ? 1 : -1);
    compare(zone, {random.uniform(-85, 85) * kDegree, (6.0 * zone.number - 183 + offset) * kDegree}, worst,
            i % 10 == 0);
  }
  expect_same(worst);
}

TEST(Geodesy, MatchesProjOnTheEdgesOfZones) {
  // 10 000 points exactly on the meridians between zones, seen from both sides.
  Random random(3);
  Worst worst;
  for (int i = 0; i < 5000; ++i) {
    const int number = int(random.integer(1, 60));
    const Geodetic edge{random.uniform(-80, 84) * kDegree, (6.0 * number - 180) * kDegree};
    compare({number, edge.latitude_rad >= 0}, edge, worst, true);
    compare({number % 60 + 1, edge.latitude_rad >= 0}, edge, worst, true);
  }
  expect_same(worst);
}

TEST(Geodesy, MatchesProjInUps) {
  // 20 000 points from the poles to 60 degrees, far beyond the 84 and 80 degrees where UPS takes over.
  Random random(4);
  Worst worst;
  for (int i = 0; i < 20000; ++i) {
    const bool north = random.integer(0, 1) == 1;
    const double latitude = random.uniform(60, i % 2 ? 90 : 89.999);
    compare({0, north}, {(north ? 1 : -1) * latitude * kDegree, random.uniform(-180, 180) * kDegree}, worst,
            i % 10 == 0);
  }
  expect_same(worst);
}

TEST(Geodesy, PolesAreWhereTheyBelong) {
  for (const bool north : {true, false}) {
    const auto pole = grid_from_geodetic({0, north}, {(north ? 90 : -90) * kDegree, 0});
    ASSERT_TRUE(pole);
    EXPECT_NEAR(pole->east_m, 2e6, 1e-6);
    EXPECT_NEAR(pole->north_m, 2e6, 1e-6);
    EXPECT_NEAR(pole->scale, 0.994, 1e-12);
  }
}

// Walks 10 m along grid north and looks where that leads on the ellipsoid: no formula of either library.
TEST(Geodesy, ConvergenceIsTheBearingOfGridNorth) {
  Random random(5);
  for (int i = 0; i < 5000; ++i) {
    const bool ups = i % 5 == 0;
    const Zone zone{ups ? 0 : int(random.integer(1, 60)), random.integer(0, 1) == 1};
    const double latitude = ups ? (zone.north ? 1 : -1) * random.uniform(75, 89) : random.uniform(-80, 80);
    const double longitude = ups ? random.uniform(-180, 180) : 6.0 * zone.number - 183 + random.uniform(-8, 8);
    const auto here = grid_from_geodetic(zone, {latitude * kDegree, longitude * kDegree});
    ASSERT_TRUE(here);
    const auto south = geodetic_from_grid(zone, here->east_m, here->north_m - 5);
    const auto north = geodetic_from_grid(zone, here->east_m, here->north_m + 5);
    ASSERT_TRUE(south && north);
    const double e2 = 0.00669437999014, s = std::sin(latitude * kDegree), w = 1 - e2 * s * s;
    const double to_north = 6378137 * (1 - e2) / std::pow(w, 1.5) * (north->latitude_rad - south->latitude_rad);
    const double to_east = 6378137 / std::sqrt(w) * std::cos(latitude * kDegree) *
                           std::remainder(north->longitude_rad - south->longitude_rad, 2 * std::numbers::pi);
    const double bearing = std::atan2(to_east, to_north);
    ASSERT_LT(std::abs(std::remainder(bearing - here->convergence_rad, 2 * std::numbers::pi)), 2e-6)
        << latitude << " " << longitude;
    ASSERT_NEAR(10 / std::hypot(to_east, to_north), here->scale, 2e-6);
  }
}

TEST(Geodesy, ConvergenceHasTheSignOfTheDocumentation) {
  // East of the central meridian on the northern hemisphere, grid north points east of true north.
  EXPECT_GT(grid_from_geodetic({32, true}, {50 * kDegree, 11 * kDegree})->convergence_rad, 0.02);
  EXPECT_LT(grid_from_geodetic({32, true}, {50 * kDegree, 7 * kDegree})->convergence_rad, -0.02);
  EXPECT_NEAR(grid_from_geodetic({32, true}, {50 * kDegree, 9 * kDegree})->convergence_rad, 0, 1e-12);
  EXPECT_NEAR(grid_from_geodetic({32, true}, {50 * kDegree, 9 * kDegree})->scale, 0.9996, 1e-12);
}

TEST(Geodesy, EpsgCodesNameTheSameGrid) {
  // One place in each of the 122 zones, projected by PROJ from the register's definition.
  for (int number = 0; number <= 60; ++number)
    for (const bool north : {true, false}) {
      const Zone zone{number, north};
      const double latitude = (north ? 1 : -1) * (number == 0 ? 86.0 : 47.25),
                   longitude = number == 0 ? 33.0 : 6.0 * number - 182.5;
      const std::string code = "EPSG:" + std::to_string(epsg_code(zone));
      const Projection any(proj_create_crs_to_crs(PJ_DEFAULT_CTX, "OGC:CRS84", code.c_str(), nullptr));
      ASSERT_TRUE(any) << code;
      const Projection east_north(proj_normalize_for_visualization(PJ_DEFAULT_CTX, any.get()));
      const PJ_COORD expected = proj_trans(east_north.get(), PJ_FWD, proj_coord(longitude, latitude, 0, 0));
      const auto grid = grid_from_geodetic(zone, {latitude * kDegree, longitude * kDegree});
      ASSERT_TRUE(grid);
      EXPECT_LT(distance(*grid, expected), kMillimetre) << code;
    }
}

Zone zone_at(double latitude_deg, double longitude_deg) {
  return *standard_zone({latitude_deg * kDegree, longitude_deg * kDegree});
}

TEST(StandardZone, FollowsTheSixDegrees) {
  EXPECT_EQ(zone_at(47, 8.5), (Zone{32, true}));
  EXPECT_EQ(zone_at(-33.9, 151.2), (Zone{56, false}));
  EXPECT_EQ(zone_at(10, -180), (Zone{1, true}));
  EXPECT_EQ(zone_at(10, 179.999), (Zone{60, true}));
  EXPECT_EQ(zone_at(10, 180), (Zone{1, true}));
  EXPECT_EQ(zone_at(10, 188.5), (Zone{2, true}));
  EXPECT_EQ(zone_at(0, 3), (Zone{31, true}));
}

TEST(StandardZone, KnowsNorwaySvalbardAndThePoles) {
  EXPECT_EQ(zone_at(60.4, 5.3), (Zone{32, true}));  // Bergen lies in zone 31 by longitude
  EXPECT_EQ(zone_at(60.4, 2.9), (Zone{31, true}));
  EXPECT_EQ(zone_at(55.9, 5.3), (Zone{31, true}));  // south of the exception
  EXPECT_EQ(zone_at(78.2, 8.9), (Zone{31, true}));  // Svalbard has 31, 33, 35 and 37 only
  EXPECT_EQ(zone_at(78.2, 15.6), (Zone{33, true}));
  EXPECT_EQ(zone_at(78.2, 21.1), (Zone{35, true}));
  EXPECT_EQ(zone_at(78.2, 33.1), (Zone{37, true}));
  EXPECT_EQ(zone_at(84.5, 20), (Zone{0, true}));
  EXPECT_EQ(zone_at(83.9, 20), (Zone{33, true}));  // Svalbard's bands end at 84 degrees
  EXPECT_EQ(zone_at(-80.5, 20), (Zone{0, false}));
  EXPECT_EQ(zone_at(-79.9, 20), (Zone{34, false}));
}

TEST(Geodesy, RefusesWhatHasNoAnswer) {
  const double nan = std::nan("");
  EXPECT_FALSE(standard_zone({nan, 0}));
  EXPECT_FALSE(standard_zone({91 * kDegree, 0}));
  EXPECT_FALSE(standard_zone({0, nan}));
  EXPECT_FALSE(standard_zone({0, 541 * kDegree}));
  for (const Geodetic bad :
       {Geodetic{nan, 0.1}, Geodetic{0.1, nan}, Geodetic{91 * kDegree, 0.1}, Geodetic{0.1, INFINITY}})
    EXPECT_FALSE(grid_from_geodetic({32, true}, bad));
  EXPECT_FALSE(grid_from_geodetic({61, true}, {0.1, 0.1}));
  EXPECT_FALSE(grid_from_geodetic({-1, true}, {0.1, 0.1}));
  EXPECT_FALSE(grid_from_geodetic({32, true}, {0.1, 80 * kDegree}));  // 71 degrees from the central meridian
  EXPECT_FALSE(grid_from_geodetic({0, true}, {-0.1, 0.1}));           // the other hemisphere of UPS
  EXPECT_FALSE(geodetic_from_grid({32, true}, nan, 0));
  EXPECT_FALSE(geodetic_from_grid({32, true}, 0, 4e7));
  EXPECT_FALSE(geodetic_from_grid({77, true}, 5e5, 5e6));
}

TEST(Geodesy, InverseAnswersOnlyWhatForwardCouldHaveSaid) {
  // All over the grid's domain: either no answer, or a place that projects back to the same metres.
  Random random(6);
  int answered = 0;
  for (int i = 0; i < 20000; ++i) {
    const Zone zone{int(random.integer(0, 60)), random.integer(0, 1) == 1};
    const double east = random.uniform(-3.3e7, 3.3e7), north = random.uniform(-3.3e7, 3.3e7);
    const auto place = geodetic_from_grid(zone, east, north);
    if (!place) continue;
    ++answered;
    const auto grid = grid_from_geodetic(zone, {place->latitude_rad, place->longitude_rad});
    ASSERT_TRUE(grid) << zone.number << " " << east << " " << north;
    ASSERT_LT(std::hypot(grid->east_m - east, grid->north_m - north), kMillimetre)
        << zone.number << " " << east << " " << north;
  }
  EXPECT_GT(answered, 500);
}

}  // namespace
}  // namespace landfix::tiles
