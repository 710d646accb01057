// The flight simulator: routes, sensors, bookkeeping, and the numbers a flight without GNSS must reach.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "builder/error.h"
#include "tests/tools/memory_map.h"
#include "tools/fly/flight.h"
#include "tools/fly/report.h"
#include "tools/fly/route_file.h"
#include "tools/fly/shift.h"
#include "tools/fly/summary.h"

namespace landfix::fly {
namespace {

using features::GridImage;

constexpr double kWest = 500'000, kNorth = 4'000'000;  // of the world below
constexpr tiles::Zone kZone{33, true};

double degrees(double deg) { return deg * M_PI / 180; }

// --- a small world ---------------------------------------------------------------------------------------------------

/// Texture at all scales from `gsd_m` to 200 m, as fields, houses and grass have it.
cv::Mat texture_of(int size_px, double gsd_m, uint64_t seed) {
  cv::Mat sum = cv::Mat::zeros(size_px, size_px, CV_32FC1);
  cv::RNG random(seed);
  for (double cell_m = 200, amplitude = 25; cell_m > gsd_m; cell_m /= 2, amplitude *= 0.85) {
    const int cells = int(std::ceil(size_px * gsd_m / cell_m)) + 4;
    cv::Mat noise(cells, cells, CV_32FC1), wave;
    random.fill(noise, cv::RNG::NORMAL, 0, amplitude);
    const double zoom = cell_m / gsd_m;
    cv::resize(noise, wave, {}, zoom, zoom, cv::INTER_CUBIC);
    sum += wave(cv::Rect(int(zoom), int(zoom), size_px, size_px));
  }
  return sum;
}

/// A square world of `size_m` with hills, gentle ones by default; map and scene show it in different light.
struct World {
  explicit World(double size_m, double gsd_m, double hills_m = 5) {
    const int size_px = int(size_m / gsd_m);
    const cv::Mat texture = texture_of(size_px, gsd_m, 7), change = texture_of(size_px, gsd_m, 8);
    texture.convertTo(map.pixels, CV_8U, 1.0, 120);
    cv::Mat scene = 0.8 * texture + 0.4 * change;  // correlation 0.9 with the map
    scene.convertTo(ortho.pixels, CV_8U, 0.8, 140);
    heights.pixels = cv::Mat(size_px / 8, size_px / 8, CV_32FC1);
    for (auto* image : {&map, &ortho, &heights}) image->west_m = kWest, image->north_m = kNorth, image->gsd_m = gsd_m;
    heights.gsd_m = 8 * gsd_m;
    for (int y = 0; y < heights.pixels.rows; ++y) {
      for (int x = 0; x < heights.pixels.cols; ++x) {
        heights.pixels.at<float>(y, x) =
            float(200 + hills_m * (std::sin(x * heights.gsd_m / 60) + std::cos(y * heights.gsd_m / 90)));
      }
    }
  }
  GridImage map, ortho, heights;
};

// --- routes ----------------------------------------------------------------------------------------------------------

/// Steps of 1 m along the route turn by at most 1 / radius and move by 1 m (a little less in turns).
void expect_smooth(const Route& route, double radius_m) {
  for (double s = 0; s + 1 <= route.length_m(); s += 1) {
    const RoutePoint a = route.at(s), b = route.at(s + 1);
    EXPECT_NEAR(std::hypot(b.east_m - a.east_m, b.north_m - a.north_m), 1.0, 1e-3) << "at " << s;
    EXPECT_LE(std::abs(std::remainder(b.heading_rad - a.heading_rad, 2 * M_PI)), 1 / radius_m + 1e-9) << "at " << s;
  }
}

TEST(Route, LoopsHaveTheirLengthCloseAndTurnSmoothly) {
  for (const Route& route : {Route::loop(100, 200, 1000, 40), Route::racetrack(100, 200, 1000, 40)}) {
    EXPECT_NEAR(route.length_m(), 1000, 1e-9);
    EXPECT_TRUE(route.closed());
    const RoutePoint start = route.at(0), end = route.at(1000 - 1e-9);
    EXPECT_NEAR(start.east_m, end.east_m, 1e-6);
    EXPECT_NEAR(start.north_m, end.north_m, 1e-6);
    EXPECT_NEAR(std::remainder(start.heading_rad - end.heading_rad, 2 * M_PI), 0, 1e-6);
    EXPECT_NEAR(route.at(250).north_m, route.at(1250).north_m, 1e-9);
    expect_smooth(route, 40);
    double east = 0, north = 0;
    for (int s = 0; s < 1000; ++s) east += route.at(s).east_m / 1000, north += route.at(s).north_m / 1000;
    EXPECT_NEAR(east, 100, 0.5);
    EXPECT_NEAR(north, 200, 0.5);
  }
  // Too short for its turns: a circle.
  EXPECT_NEAR(Route::loop(0, 0, 100, 40).at(0).east_m, -100 / (2 * M_PI), 1e-9);
}

TEST(Route, CornersAreCutByTurns) {
  const Route route = Route::through({{0, 0}, {0, 300}, {200, 300}}, 40);
  // A right angle of radius 40 saves 2·40 - π/2·40 m.
  EXPECT_NEAR(route.length_m(), 500 - 80 + 20 * M_PI, 1e-9);
  EXPECT_FALSE(route.closed());
  expect_smooth(route, 40);
  EXPECT_NEAR(route.at(0).heading_rad, 0, 1e-12);
  EXPECT_NEAR(route.at(1e9).east_m, 200, 1e-6);
  EXPECT_NEAR(route.at(1e9).north_m, 300, 1e-6);
  EXPECT_NEAR(route.at(1e9).heading_rad, M_PI / 2, 1e-9);

  const Route triangle = Route::through({{0, 0}, {100, 300}, {300, 0}, {0, 0}}, 20);
  EXPECT_TRUE(triangle.closed());
  expect_smooth(triangle, 20);
  EXPECT_THROW(Route::through({{1, 1}, {1, 1}}, 40), Error);
}

TEST(Route, FilesHoldLongitudeAndLatitude) {
  const auto folder = std::filesystem::path(testing::TempDir());
  const auto write = [&](const char* name, const char* text) {
    std::ofstream(folder / name) << text;
    return folder / name;
  };
  // On the central meridian of zone 33 (15° east) the easting is 500 km.
  const auto csv = read_route(write("route.csv", "lon,lat\n15.0,36.0\n# note\n15.0, 36.01,77\n"), kZone);
  const auto json =
      read_route(write("route.geojson", R"({"type":"FeatureCollection","features":[{"type":"Feature","properties":{},
            "geometry":{"type":"LineString","coordinates":[[15.0,36.0],[15.0,36.01]]}}]})"),
                 kZone);
  ASSERT_EQ(csv.size(), 2u);
  EXPECT_NEAR(csv[0].x(), 500'000, 1e-3);
  EXPECT_NEAR(csv[1].y() - csv[0].y(), 1109.2, 0.5);  // 0.01° of latitude at 36° north, times 0.9996
  ASSERT_EQ(json.size(), 2u);
  EXPECT_EQ(json[1], csv[1]);
  EXPECT_THROW(read_route(folder / "absent.csv", kZone), Error);
  EXPECT_THROW(read_route(write("bad.csv", "15.0,36.0\nfifteen\n"), kZone), Error);
  EXPECT_THROW(read_route(write("bad.geojson", "{\"type\":\"Point\",\"coordinates\":[1,2]}"), kZone), Error);
  EXPECT_THROW(read_route(write("far.csv", "15.0,360.0\n15,1\n"), kZone), Error);
}

// --- sensors ---------------------------------------------------------------------------------------------------------

TEST(Sensors, AttitudeHasItsNoiseAndItsConstantError) {
  Sensors sensors({}, 3);
  constexpr int kCount = 20000;
  double sum = 0, squares = 0;
  for (int i = 0; i < kCount; ++i) {
    const double error = sensors.attitude({0.1, 0.2, 0.3}).pitch - 0.2;
    sum += error, squares += error * error;
  }
  const double mean = sum / kCount, sigma = std::sqrt(squares / kCount - mean * mean);
  EXPECT_NEAR(std::abs(mean), degrees(0.3), degrees(0.02));  // 0.5° / √20000 = 0.0035°
  EXPECT_NEAR(sigma, degrees(0.5), degrees(0.015));
}

TEST(Sensors, DeadReckoningDriftsByTheStatedShareOfTheDistance) {
  SensorOptions options;
  options.odometry_drift = 0.025;
  const auto rms_share = [&](const Route& route) {
    double squares = 0;
    constexpr int kFlights = 300;
    for (uint64_t seed = 0; seed < kFlights; ++seed) {
      Sensors sensors(options, seed);
      Eigen::Vector2d sum(0, 0);
      terrain::Pose before;
      for (double s = 0; s <= 1000; s += 10) {
        const RoutePoint p = route.at(s);
        const terrain::Pose pose{p.east_m, p.north_m, 0, {0, 0, p.heading_rad}};
        if (s > 0) sum += sensors.displacement(before, pose);
        before = pose;
      }
      const RoutePoint start = route.at(0), end = route.at(1000);
      const Eigen::Vector2d truth(end.east_m - start.east_m, end.north_m - start.north_m);
      squares += (sum - truth).squaredNorm() / kFlights;
    }
    return std::sqrt(squares) / 1000;
  };
  // On a loop what is constant in the body cancels, and 0.9 of the share is left; on a line 0.995 of it remains, with
  // the heading's constant error (0.3°: 0.5 % of the distance) and noise on top.
  EXPECT_NEAR(rms_share(Route::loop(0, 0, 1000, 40)), 0.0225, 0.001);
  EXPECT_NEAR(rms_share(Route::through({{0, 0}, {0, 1000}}, 40)), 0.0255, 0.0025);
}

TEST(Sensors, PictureHasGainOffsetVignettingAndNoise) {
  SensorOptions options;
  options.gain = 0.5, options.offset = 30, options.pixel_noise = 4, options.vignetting = 0.2;
  Sensors sensors(options, 1);
  const cv::Mat picture = sensors.picture(cv::Mat(480, 640, CV_8UC1, cv::Scalar(100)));
  cv::Scalar mean, sigma;
  cv::meanStdDev(picture(cv::Rect(290, 210, 60, 60)), mean, sigma);
  EXPECT_NEAR(mean[0], 0.5 * 100 + 30, 0.5);
  EXPECT_NEAR(sigma[0], 4, 0.3);
  cv::meanStdDev(picture(cv::Rect(0, 0, 20, 20)), mean, sigma);
  EXPECT_NEAR(mean[0], 0.5 * 0.8 * 100 + 30, 1.5);  // a fifth of the light is lost in the corner
}

// --- flights ---------------------------------------------------------------------------------------------------------

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

class Flights : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    world_ = new World(480, 0.5);
    map_ = new MemoryMap(world_->map, world_->heights);
    scene_ = new terrain::Scene(world_->ortho, world_->heights);
  }
  static void TearDownTestSuite() {
    delete scene_;
    delete map_;
    delete world_;
  }
  static FlightOptions options() {
    FlightOptions o;
    o.image_interval_s = 1;
    o.gnss_until_s = 3;
    return with_known_errors(o);
  }
  static Route route(double length_m) { return Route::loop(kWest + 240, kNorth - 240, length_m, 40); }

  static World* world_;
  static MemoryMap* map_;
  static terrain::Scene* scene_;
};
World* Flights::world_ = nullptr;
MemoryMap* Flights::map_ = nullptr;
terrain::Scene* Flights::scene_ = nullptr;

TEST_F(Flights, OneSeedGivesOneFlightAndSummaryAgreesWithTheCsv) {
  const auto folder = std::filesystem::path(testing::TempDir());
  const auto first = fly(*scene_, *map_, route(300), options(), 5);
  write_track_csv(folder / "first.csv", first, kZone);
  write_track_csv(folder / "again.csv", fly(*scene_, *map_, route(300), options(), 5), kZone);
  write_track_csv(folder / "other.csv", fly(*scene_, *map_, route(300), options(), 6), kZone);
  EXPECT_EQ(text_of(folder / "first.csv"), text_of(folder / "again.csv"));
  EXPECT_NE(text_of(folder / "first.csv"), text_of(folder / "other.csv"));

  // The summary again, from nothing but the CSV's columns.
  std::istringstream lines(text_of(folder / "first.csv"));
  std::string line, cell;
  std::getline(lines, line);
  std::map<std::string, size_t> column;
  for (std::istringstream names(line); std::getline(names, cell, ',');) column.emplace(cell, column.size());
  double squares = 0, largest = 0, inside = 0;
  int images = 0;
  while (std::getline(lines, line)) {
    std::vector<std::string> cells;
    for (std::istringstream row(line); std::getline(row, cell, ',');) cells.push_back(cell);
    const auto value = [&](const char* name) { return std::stod(cells.at(column.at(name))); };
    if (value("gnss") == 1) continue;
    const double error = std::hypot(value("estimate_east_m") - value("truth_east_m"),
                                    value("estimate_north_m") - value("truth_north_m"));
    squares += error * error, largest = std::max(largest, error), inside += value("inside_3_sigma"), ++images;
  }
  const Summary summary = summarize({first});
  EXPECT_EQ(summary.images, size_t(images));
  EXPECT_EQ(images, 18);  // 300 m at 15 m/s: 21 images, three of them at 0, 1 and 2 s with GNSS
  EXPECT_NEAR(summary.rms_m, std::sqrt(squares / images), 2e-3);
  EXPECT_NEAR(summary.max_m, largest, 2e-3);
  EXPECT_NEAR(summary.inside_3_sigma, inside / images, 1e-9);
  EXPECT_LE(summary.percentile95_m, summary.max_m);
}

TEST_F(Flights, RoutesOffTheSceneAreRefusedWithTheirPlace) {
  try {
    fly(*scene_, *map_, Route::loop(kWest + 480, kNorth - 240, 300, 40), options(), 1);
    FAIL() << "a route over the edge of the scene was flown";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kNoData);
    EXPECT_NE(std::string(e.what()).find("leaves the scene"), std::string::npos) << e.what();
  }
  FlightOptions still = options();
  still.speed_mps = 0;
  EXPECT_THROW(fly(*scene_, *map_, route(300), still, 1), Error);
}

TEST_F(Flights, ShiftBetweenSceneAndMapIsMeasured) {
  // The scene says that everything lies 1.5 m west and 0.5 m north of where the map has it.
  GridImage ortho = world_->ortho;
  ortho.west_m -= 1.5, ortho.north_m += 0.5;
  const Shift shift = measure_shift(terrain::Texture(ortho), *map_);
  EXPECT_GE(shift.places, 20);
  EXPECT_NEAR(shift.map_from_scene.x(), 1.5, 0.1);
  EXPECT_NEAR(shift.map_from_scene.y(), -0.5, 0.1);
  EXPECT_LT(shift.spread.norm(), 0.2);
}

TEST_F(Flights, TracksAreDrawnWhereTheyLie) {
  const auto records = fly(*scene_, *map_, route(300), options(), 5);
  const cv::Mat picture = draw_tracks(records, *map_, 800);
  EXPECT_EQ(picture.type(), CV_8UC3);
  EXPECT_NEAR(std::max(picture.cols, picture.rows), 800, 30);
  cv::Mat truth;
  cv::inRange(picture, cv::Scalar(70, 210, 70), cv::Scalar(90, 230, 90), truth);
  EXPECT_GT(cv::countNonZero(truth), 1000);  // a line of 300 m, more than 2 px per metre, 3 px wide, partly overdrawn
}

TEST_F(Flights, TracksAreDrawnOverAMapWithoutGray) {
  const nav::MapLayer layers[] = {nav::MapLayer::kOrientation};
  const MemoryMap map(world_->map, world_->heights, layers);
  std::vector<Record> records(3);
  for (size_t i = 0; i < records.size(); ++i) {
    records[i].truth.east_m = records[i].estimate.east_m = kWest + 100 * double(i);
    records[i].truth.north_m = kNorth, records[i].estimate.north_m = kNorth - 10;
    records[i].dead_reckoning_east_m = kWest, records[i].dead_reckoning_north_m = kNorth;
    records[i].gnss = i == 0;
  }
  const cv::Mat picture = draw_tracks(records, map, 640);
  EXPECT_EQ(picture.size(), cv::Size(640, 260));  // 200 m x 10 m with 60 m of margin on all sides, half a metre per pixel
  cv::Mat truth;
  cv::inRange(picture, cv::Scalar(70, 210, 70), cv::Scalar(90, 230, 90), truth);
  EXPECT_GT(cv::countNonZero(truth), 400);  // 200 m at 2 px per metre, 3 px wide
}

TEST(Relief, IsTakenOutWhereTheMapHasHeights) {
  // Slopes of 35 m in 60 m: at the side of the view from 60 m, 30 m out, ground is some 15 m higher or lower than below
  // the aircraft and shows 8 m from where a plane would put it. Through the heights the pictures match nearly as well
  // as over flat ground: 0.9, which the change leaves, less noise, blur, and what the uncertain position leaves of the
  // relief.
  const World world(480, 0.5, 35);
  MemoryMap map(world.map, world.heights);
  const terrain::Scene scene(world.ortho, world.heights);
  FlightOptions options;
  options.image_interval_s = 1;
  const Route route = Route::loop(kWest + 240, kNorth - 240, 300, 40);
  const auto mean_score = [&](bool tell_heights) {
    map.tell_heights = tell_heights;
    double sum = 0;
    int fixes = 0;
    for (const Record& r : fly(scene, map, route, with_known_errors(options), 3)) {
      if (r.gnss) continue;
      sum += r.fix.score, ++fixes;
    }
    return sum / fixes;
  };
  const double with = mean_score(true), without = mean_score(false);
  RecordProperty("with", std::to_string(with));
  RecordProperty("without", std::to_string(without));
  EXPECT_GT(with, 0.75);
  EXPECT_LT(without, with - 0.08);
}

}  // namespace
}  // namespace landfix::fly
