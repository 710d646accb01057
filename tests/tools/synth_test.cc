// The procedural world: same bytes however it is cut, and one truth in image, heights and labels.
#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "builder/error.h"
#include "tools/synth/world.h"

namespace landfix::synth {
namespace {

namespace fs = std::filesystem;

WorldOptions default_world() {
  WorldOptions options;
  options.seed = 7;
  return options;
}

cv::Mat gray(const cv::Mat& rgb) {
  cv::Mat g;
  cv::cvtColor(rgb, g, cv::COLOR_RGB2GRAY);
  return g;
}

bool equal(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

Window window_of(const Rectangle& r, double gsd_m) {
  return {r.west_m, r.north_m, static_cast<int>(std::lround((r.east_m - r.west_m) / gsd_m)),
          static_cast<int>(std::lround((r.north_m - r.south_m) / gsd_m)), gsd_m};
}

template <typename Pixel>
Pixel value_at(const features::GridImage& image, Point p) {
  return image.pixels.at<Pixel>(static_cast<int>(std::lround(image.row_of(p.y))),
                                static_cast<int>(std::lround(image.column_of(p.x))));
}

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A fresh directory that vanishes with the test.
class SynthFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    directory_ = fs::path(::testing::TempDir()) / (std::string("landfix_synth_") + test->name());
    fs::remove_all(directory_);
    GDALAllRegister();
  }
  void TearDown() override { fs::remove_all(directory_); }

  fs::path directory_;
};

TEST(Synth, WindowHasTheBytesOfTheWhole) {
  const World world(default_world());
  const Window whole{500300, 5401400, 420, 380, 0.5};
  // Off the tile lattice, touching the edge of the whole.
  const Window part{500300 + 37 * 0.5, 5401400 - 53 * 0.5, 383, 101, 0.5};
  const cv::Rect roi(37, 53, 383, 101);
  EXPECT_TRUE(equal(world.ortho(part).pixels, world.ortho(whole).pixels(roi)));
  EXPECT_TRUE(equal(world.dtm(part).pixels, world.dtm(whole).pixels(roi)));
  EXPECT_TRUE(equal(world.dsm(part).pixels, world.dsm(whole).pixels(roi)));
}

TEST(Synth, ImageSaysWhereItLies) {
  const World world(default_world());
  const features::GridImage image = world.ortho({500010.3, 5400020.2, 8, 4, 0.5});
  EXPECT_EQ(image.west_m, 500010.5);  // the nearest whole multiple of 0.5 m
  EXPECT_EQ(image.north_m, 5400020.0);
  EXPECT_EQ(image.gsd_m, 0.5);
  EXPECT_EQ(image.pixels.cols, 8);
  EXPECT_EQ(image.pixels.type(), CV_8UC3);
}

TEST_F(SynthFiles, ThreadsDoNotChangeTheFiles) {
  WorldOptions options = default_world();
  options.size_m = 600;  // several tiles of 256 m, the last ones cut
  const WriteSummary one = write_world(options, directory_ / "one", {1, nullptr});
  const WriteSummary two = write_world(options, directory_ / "two", {2, nullptr});
  ASSERT_EQ(one.files.size(), 10u);
  ASSERT_EQ(two.files.size(), 10u);
  for (const fs::path& file : one.files) {
    const std::string bytes = bytes_of(file);
    EXPECT_FALSE(bytes.empty()) << file;
    EXPECT_TRUE(bytes == bytes_of(directory_ / "two" / file.filename())) << file;
  }
}

TEST_F(SynthFiles, LargerWorldContainsTheSmaller) {
  const auto read = [&](const char* name, double size_m) {
    WorldOptions options = default_world();
    options.gsd_m = 1;
    options.size_m = size_m;
    write_world(options, directory_ / name);
    GDALDatasetUniquePtr data(GDALDataset::Open((directory_ / name / "ortho.tif").c_str()));
    cv::Mat pixels(data->GetRasterYSize(), data->GetRasterXSize(), CV_8UC3);
    EXPECT_EQ(data->RasterIO(GF_Read, 0, 0, pixels.cols, pixels.rows, pixels.data, pixels.cols, pixels.rows, GDT_Byte,
                             3, nullptr, 3, pixels.cols * 3, 1, nullptr),
              CE_None);
    return pixels;
  };
  const cv::Mat small = read("small", 300), large = read("large", 700);
  ASSERT_EQ(large.rows, 700);
  // They share the south-western corner, which is at the bottom.
  EXPECT_TRUE(equal(small, large(cv::Rect(0, 400, 300, 300))));
  WorldOptions other = default_world();
  other.seed = 8;
  EXPECT_FALSE(equal(small, World(other).ortho({500000, 5400300, 300, 300, 1}).pixels));
}

/// A village of the default world.
constexpr Rectangle kVillage{500800, 5400700, 501300, 5401200};

TEST(Synth, ShadowFallsAwayFromTheSun) {
  WorldOptions options = default_world();
  options.relief_m = 0;
  options.sun_elevation_deg = 45;
  options.sun_azimuth_deg = 180;
  const World south_sun(options);
  options.sun_azimuth_deg = 0;
  const World north_sun(options);
  const Labels labels = south_sun.labels(south_sun.extent());
  int walls = 0, as_expected = 0;
  for (const Building& b : labels.buildings) {
    const auto near = [&](Point p) { return cv::norm(p - b.centre) < b.reach_m() + 20; };
    if (std::ranges::any_of(labels.trees, [&](const Tree& t) { return near(t.position); }) ||
        std::ranges::any_of(labels.buildings, [&](const Building& n) { return n.key != b.key && near(n.centre); })) {
      continue;
    }
    const Window window = window_of(bounds_of(b.outline()).grown(5), 0.5);
    const auto from_south = south_sun.ortho(window), from_north = north_sun.ortho(window);
    const Outline o = b.outline();
    for (size_t k = 0; k < o.size(); ++k) {
      const Point a = o[k], c = o[(k + 1) % o.size()];
      const Point outward = Point((c - a).y, -(c - a).x) * (1 / cv::norm(c - a));
      if (std::abs(outward.y) < 0.8 || cv::norm(c - a) < 8) continue;
      // Walls are at least 3 m high: at 45° a point 2 m behind one is in its shadow, and lit with the sun behind it.
      const Point p = (a + c) * 0.5 + outward * 2;
      if (b.outside_m(b.local(p)) < 1.5) continue;
      const auto& shaded = outward.y > 0 ? from_south : from_north;
      const auto& lit = outward.y > 0 ? from_north : from_south;
      const double dark = value_at<cv::Vec3b>(shaded, p)[0], bright = value_at<cv::Vec3b>(lit, p)[0];
      ++walls;
      // Skylight is 0.36 of the light, less in red.
      as_expected += dark < 0.45 * bright;
    }
  }
  EXPECT_GE(walls, 8);
  EXPECT_EQ(as_expected, walls);
}

TEST(Synth, HeightsMatchTheLabels) {
  const World world(default_world());
  const Labels labels = world.labels(kVillage);
  const auto [dtm, dsm] = world.heights(window_of(kVillage.grown(40), 0.5));
  ASSERT_GE(labels.buildings.size(), 40u);
  for (const Building& b : labels.buildings) {
    EXPECT_GE(b.height_m, 3);
    EXPECT_LE(b.height_m, 12.5);
    // Along the axis of the body runs its ridge, or a flat roof. The ground under it may slope a little.
    for (const double along : {-0.35, 0.0, 0.35}) {
      const Point p = b.centre + b.axis * (along * b.length_m);
      const double above = static_cast<double>(value_at<float>(dsm, p) - value_at<float>(dtm, p));
      // A pixel's centre lies up to 0.36 m from the ridge, on a roof of slope 0.96 at most.
      EXPECT_NEAR(above, b.height_m, 0.35 + 0.1 * std::abs(along) * b.length_m) << b.centre;
    }
  }
  ASSERT_GE(labels.trees.size(), 100u);
  for (const Tree& t : labels.trees) {
    EXPECT_NEAR(value_at<float>(dtm, t.position), t.base_m, 0.1);
    // Nothing but a taller neighbour hides a tree's top.
    EXPECT_GE(value_at<float>(dsm, t.position), t.base_m + 0.7 * t.height_m) << t.position;
  }
}

TEST(Synth, TreesAndBuildingsStandBesideRoadsAndWater) {
  const World world(default_world());
  const Labels labels = world.labels(world.extent());
  ASSERT_GE(labels.water.size(), 1u);
  const auto distance = [](const Road& road, Point p) {
    double least = 1e9;
    for (size_t k = 0; k + 1 < road.line.size(); ++k) {
      const Point a = road.line[k], d = road.line[k + 1] - a;
      least = std::min(least, cv::norm(p - a - d * std::clamp(d.dot(p - a) / d.dot(d), 0.0, 1.0)));
    }
    return least;
  };
  for (const Road& road : labels.roads) {
    const Rectangle near = bounds_of(road.line).grown(30);
    for (const Tree& t : labels.trees) {
      if (!near.contains(t.position)) continue;
      EXPECT_GT(distance(road, t.position), road.width_m / 2) << t.position;
    }
    for (const Building& b : labels.buildings) {
      for (const Point& corner : b.outline()) {
        if (!near.contains(corner)) continue;
        EXPECT_GT(distance(road, corner), road.width_m / 2 + 1) << corner;
      }
    }
    for (const Lake& lake : labels.water) {
      for (const Point& p : road.line) EXPECT_GT(lake.shore_distance_m(p), 5) << p;
    }
  }
  for (const Lake& lake : labels.water) {
    for (const Tree& t : labels.trees) EXPECT_GT(lake.shore_distance_m(t.position), 0);
    for (const Building& b : labels.buildings) EXPECT_GT(lake.shore_distance_m(b.centre), 10);
  }
  ASSERT_GE(labels.intersections.size(), 50u);
  for (const Intersection& i : labels.intersections) {
    EXPECT_GE(i.degree, 3);
    // Every intersection lies on two roads or more.
    const auto on = [&](const Road& r) {
      return bounds_of(r.line).grown(5).contains(i.position) && distance(r, i.position) < 1;
    };
    EXPECT_GE(std::ranges::count_if(labels.roads, on), 2) << i.position;
  }
}

TEST(Synth, RoadsShareAVertexAtEveryIntersection) {
  for (const uint64_t seed : {1, 2, 3, 7}) {
    WorldOptions options = default_world();
    options.seed = seed;
    const World world(options);
    const Labels labels = world.labels(world.extent());
    // Ends of roads that have a vertex here count once, what goes on through it twice.
    for (const Intersection& i : labels.intersections) {
      int arms = 0;
      for (const Road& road : labels.roads)
        for (size_t k = 0; k < road.line.size(); ++k)
          if (cv::norm(road.line[k] - i.position) < 1e-3) arms += k == 0 || k + 1 == road.line.size() ? 1 : 2;
      EXPECT_EQ(arms, i.degree) << seed << " " << i.position;
    }
  }
}

TEST(Synth, WaterIsFlatAndDark) {
  const World world(default_world());
  const Labels labels = world.labels(world.extent());
  ASSERT_FALSE(labels.water.empty());
  const Lake& lake = labels.water.front();
  const Rectangle around = bounds_of(lake.outline()).grown(30);
  const auto dtm = world.dtm(window_of(around, 2));
  const auto ortho = world.ortho(window_of(around, 2));
  int wet = 0;
  double lowest_shore = 1e9;
  for (int y = 0; y < dtm.pixels.rows; ++y) {
    for (int x = 0; x < dtm.pixels.cols; ++x) {
      const Point p(dtm.west_m + (x + 0.5) * 2, dtm.north_m - (y + 0.5) * 2);
      const double shore = lake.shore_distance_m(p);
      if (shore > 5) lowest_shore = std::min(lowest_shore, static_cast<double>(dtm.pixels.at<float>(y, x)));
      if (shore > -3) continue;
      ++wet;
      EXPECT_NEAR(dtm.pixels.at<float>(y, x), lake.level_m, 1e-3);
      EXPECT_LT(ortho.pixels.at<cv::Vec3b>(y, x)[0], 85);  // red: water absorbs it
    }
  }
  EXPECT_GT(wet, 1000);
  EXPECT_GE(lowest_shore, lake.level_m - 1e-3);
}

/// Cosine and sine of twice the direction of each pixel's gradient, faded where there is none.
std::array<cv::Mat, 2> orientation(const cv::Mat& rgb) {
  cv::Mat smooth, gx, gy;
  cv::GaussianBlur(gray(rgb), smooth, {}, 1.5);
  cv::Sobel(smooth, gx, CV_32F, 1, 0);
  cv::Sobel(smooth, gy, CV_32F, 0, 1);
  const cv::Mat energy = gx.mul(gx) + gy.mul(gy) + 100;
  return {(gx.mul(gx) - gy.mul(gy)) / energy, 2 * gx.mul(gy) / energy};
}

double agreement(const std::array<cv::Mat, 2>& a, const std::array<cv::Mat, 2>& b) {
  const auto product = [](const auto& p, const auto& q) { return p[0].dot(q[0]) + p[1].dot(q[1]); };
  return product(a, b) / std::sqrt(product(a, a) * product(b, b));
}

TEST(Synth, SeasonChangesColoursAndNotGeometry) {
  WorldOptions options = default_world();
  const World summer(options);
  options.season = Season::kAutumn;
  options.year = 2021;
  options.sun_azimuth_deg = 200;
  options.sun_elevation_deg = 33;
  const World autumn(options);
  const Rectangle area{500000, 5400000, 500900, 5400900};
  EXPECT_TRUE(equal(summer.dsm(window_of(area, 1)).pixels, autumn.dsm(window_of(area, 1)).pixels));

  const auto first = summer.ortho(window_of(area, 1)), second = autumn.ortho(window_of(area, 1));
  const auto a = orientation(first.pixels), b = orientation(second.pixels);
  const double here = agreement(a, b);
  const cv::Rect left(0, 0, 880, 900), right(20, 0, 880, 900);
  const double beside = agreement({a[0](left), a[1](left)}, {b[0](right), b[1](right)});
  EXPECT_GT(here, 0.2);
  EXPECT_GT(here, 4 * std::abs(beside));

  const Labels before = summer.labels(area), after = autumn.labels(area);
  ASSERT_EQ(before.trees.size(), after.trees.size());
  ASSERT_EQ(before.fields.size(), after.fields.size());
  const cv::Mat gray_before = gray(first.pixels), gray_after = gray(second.pixels);
  std::vector<std::pair<double, double>> brightness;
  int rotated = 0, rotating = 0;
  for (size_t k = 0; k < before.fields.size(); ++k) {
    EXPECT_EQ(before.fields[k].outline, after.fields[k].outline);
    if (before.fields[k].crop != Crop::kGrass && before.fields[k].crop != Crop::kOrchard) {
      ++rotating;
      rotated += before.fields[k].crop != after.fields[k].crop;
    }
    cv::Mat mask = cv::Mat::zeros(gray_before.size(), CV_8U);
    std::vector<cv::Point> outline;
    for (const Point& p : before.fields[k].outline)
      outline.emplace_back(std::lround(first.column_of(p.x)), std::lround(first.row_of(p.y)));
    cv::fillPoly(mask, std::vector{outline}, 255);
    if (cv::countNonZero(mask) > 1500)
      brightness.emplace_back(cv::mean(gray_before, mask)[0], cv::mean(gray_after, mask)[0]);
  }
  EXPECT_EQ(rotated, rotating);
  // Among pairs of fields that differ by 15 gray levels on both dates, many have changed places.
  int pairs = 0, inverted = 0;
  for (const auto& p : brightness) {
    for (const auto& q : brightness) {
      const double was = p.first - q.first, is = p.second - q.second;
      if (was < 15 || std::abs(is) < 15) continue;
      ++pairs;
      inverted += is < 0;
    }
  }
  EXPECT_GE(pairs, 20);
  EXPECT_GT(inverted, pairs / 5);
}

TEST(Synth, EveryPlaceCanBeTold) {
  WorldOptions options = default_world();
  const World map_world(options);
  options.sun_azimuth_deg = 165;
  const World camera_world(options);
  constexpr int kPatch = 128, kSearch = 80;  // 64 m in ±40 m
  std::mt19937 random(5);
  int itself = 0, under_another_sun = 0;
  for (int k = 0; k < 10; ++k) {
    const double east = 500000 + random() % 1900, north = 5400100 + random() % 1900;
    const Window patch{east, north, kPatch, kPatch, 0.5};
    const Window search{east - kSearch * 0.5, north + kSearch * 0.5, kPatch + 2 * kSearch, kPatch + 2 * kSearch, 0.5};
    const cv::Mat map = gray(map_world.ortho(search).pixels);
    const auto unique = [&](const World& world) {
      cv::Mat score;
      cv::matchTemplate(map, gray(world.ortho(patch).pixels), score, cv::TM_CCOEFF_NORMED);
      cv::Point best;
      double peak = 0, rival = 0;
      cv::minMaxLoc(score, nullptr, &peak, nullptr, &best);
      cv::circle(score, best, 10, -1, cv::FILLED);
      cv::minMaxLoc(score, nullptr, &rival);
      return cv::norm(best - cv::Point(kSearch, kSearch)) <= 4 && rival < 0.9 * peak;
    };
    itself += unique(map_world);
    under_another_sun += unique(camera_world);
  }
  EXPECT_GE(itself, 9);
  EXPECT_GE(under_another_sun, 8);
}

TEST_F(SynthFiles, WritesGeoreferencedFiles) {
  WorldOptions options = default_world();
  options.size_m = 260;
  options.near_infrared = true;
  options.season = Season::kAutumn;
  options.zone = 32;
  options.dem_gsd_m = 2;
  const WriteSummary summary = write_world(options, directory_);
  EXPECT_EQ(summary.ortho_pixels, 520 * 520);
  EXPECT_EQ(summary.height_pixels, 130 * 130);
  EXPECT_FALSE(fs::exists(directory_ / ".synth.part"));
  for (const char* name : {"ortho.tif", "dtm.tif", "dsm.tif"}) {
    GDALDatasetUniquePtr data(GDALDataset::Open((directory_ / name).c_str()));
    ASSERT_TRUE(data) << name;
    const bool ortho = std::string(name) == "ortho.tif";
    std::array<double, 6> transform{};
    ASSERT_EQ(data->GetGeoTransform(transform.data()), CE_None);
    const double gsd = ortho ? 0.5 : 2;
    EXPECT_EQ(transform, (std::array<double, 6>{500000, gsd, 0, 5400260, 0, -gsd}));
    EXPECT_STREQ(data->GetSpatialRef()->GetAuthorityCode(nullptr), "32632");
    EXPECT_EQ(data->GetRasterCount(), ortho ? 4 : 1);
    EXPECT_EQ(data->GetRasterBand(1)->GetRasterDataType(), ortho ? GDT_Byte : GDT_Float32);
    int block_width = 0, block_height = 0;
    data->GetRasterBand(1)->GetBlockSize(&block_width, &block_height);
    EXPECT_EQ(block_width, 512);
    const char* datum = data->GetMetadataItem("LANDFIX_VERTICAL_DATUM");
    EXPECT_EQ(datum != nullptr && std::string(datum) == "ellipsoid", !ortho) << name;
  }
  const auto sidecar = nlohmann::json::parse(bytes_of(directory_ / "ortho.tif.json"));
  EXPECT_EQ(sidecar["date"], "2020-10-10");
  EXPECT_EQ(sidecar["licence"], "CC0-1.0");
  EXPECT_EQ(sidecar["attribution"], "landfix synth");
}

TEST_F(SynthFiles, LabelsLieWhereTheGridSays) {
  WorldOptions options = default_world();
  options.west_m = 500800;
  options.south_m = 5400700;
  options.size_m = 500;
  const WriteSummary summary = write_world(options, directory_);
  OGRSpatialReference utm, geographic;
  utm.importFromEPSG(32633);
  geographic.importFromEPSG(4326);
  utm.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  geographic.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  const std::unique_ptr<OGRCoordinateTransformation> to_grid(OGRCreateCoordinateTransformation(&geographic, &utm));
  const auto trees = nlohmann::json::parse(bytes_of(directory_ / "trees.geojson"))["features"];
  ASSERT_EQ(static_cast<int64_t>(trees.size()), summary.trees);
  ASSERT_GT(summary.trees, 100);
  for (const auto& tree : trees) {
    double x = tree["geometry"]["coordinates"][0], y = tree["geometry"]["coordinates"][1];
    ASSERT_TRUE(to_grid->Transform(1, &x, &y));
    EXPECT_NEAR(x, tree["properties"]["easting_m"].get<double>(), 0.002);
    EXPECT_NEAR(y, tree["properties"]["northing_m"].get<double>(), 0.002);
  }
  // Every object of the world once, as World::labels has them.
  const World world(options);
  const Labels labels = world.labels(world.extent());
  EXPECT_EQ(summary.buildings, static_cast<int64_t>(labels.buildings.size()));
  EXPECT_EQ(summary.trees, static_cast<int64_t>(labels.trees.size()));
  EXPECT_EQ(summary.roads, static_cast<int64_t>(labels.roads.size()));
  EXPECT_EQ(summary.fields, static_cast<int64_t>(labels.fields.size()));
  EXPECT_EQ(summary.intersections, static_cast<int64_t>(labels.intersections.size()));
}

TEST_F(SynthFiles, BadValuesAreRefused) {
  const auto message = [&](auto change) -> std::string {
    WorldOptions options = default_world();
    change(options);
    try {
      write_world(options, directory_);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kBadInput);
      return error.what();
    }
    return "no error";
  };
  EXPECT_NE(message([](WorldOptions& o) { o.gsd_m = 0; }).find("gsd is 0, expected 0.05 to 20"), std::string::npos);
  EXPECT_NE(message([](WorldOptions& o) { o.gsd_m = NAN; }).find("gsd is nan"), std::string::npos);
  EXPECT_NE(message([](WorldOptions& o) { o.zone = 61; }).find("zone is 61"), std::string::npos);
  EXPECT_NE(message([](WorldOptions& o) { o.size_m = -5; }).find("size"), std::string::npos);
  EXPECT_NE(message([](WorldOptions& o) { o.sun_elevation_deg = 2; }).find("sun elevation is 2"), std::string::npos);
  EXPECT_NE(message([](WorldOptions& o) { o.snow = true; }).find("winter"), std::string::npos);
  EXPECT_FALSE(fs::exists(directory_));
}

TEST_F(SynthFiles, UnwritableDirectoryIsAnInputOutputError) {
  fs::create_directories(directory_);
  std::ofstream(directory_ / "file") << "not a directory";
  WorldOptions options = default_world();
  options.size_m = 50;
  try {
    write_world(options, directory_ / "file");
    FAIL() << "wrote into a file";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kIo);
    EXPECT_NE(std::string(error.what()).find((directory_ / "file").string()), std::string::npos);
  }
}

}  // namespace
}  // namespace landfix::synth
