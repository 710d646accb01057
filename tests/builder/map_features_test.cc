// Landmarks and roads that a build finds in its images: true, the same whatever the threads and interruptions and where
// blocks meet, counted over the dates, and behind what is known.
#include "tools/common/map_features.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/imgproc.hpp>
#include <span>

#include "builder/build.h"
#include "builder/error.h"
#include "builder/ingest/window.h"
#include "builder/roads/road_extraction.h"
#include "landfix/landfix.hpp"
#include "tiles/road.h"
#include "tools/common/open_pack.h"
#include "tools/synth/world.h"

namespace landfix {
namespace {

namespace fs = std::filesystem;

// Four blocks of 1024 m meet in its middle.
constexpr double kWest_m = 500736 - 350, kSouth_m = 5400576 - 350, kSize_m = 700;

std::vector<char> bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// One place on two dates.
class MapFeatures : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::temp_directory_path() / ("landfix_map_features_" + std::to_string(getpid()));
    draw("summer", synth::Season::kSummer, 2020);
    draw("autumn", synth::Season::kAutumn, 2018);
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }

  static synth::WorldOptions world(synth::Season season, int year) {
    synth::WorldOptions options;
    options.seed = 77;
    options.west_m = kWest_m;
    options.south_m = kSouth_m;
    options.size_m = kSize_m;
    options.gsd_m = 1;
    options.season = season;
    options.year = year;
    return options;
  }
  static void draw(const char* name, synth::Season season, int year) {
    synth::write_world(world(season, year), folder_ / name);
  }
  static BuildOptions options(const std::string& pack, const std::vector<std::string>& images = {"summer"}) {
    BuildOptions o;
    for (const std::string& name : images) o.images.push_back({.path = folder_ / name / "ortho.tif"});
    o.layers = {"landmarks", "roads"};
    o.output = folder_ / pack;
    o.force = true;
    return o;
  }
  static BuildSummary run(const BuildOptions& o) {
    Progress silent;
    return build(o, silent);
  }
  static std::vector<Landmark> landmarks_of(const BuildOptions& o) {
    const Pack pack = tools::open_pack(o.output.string());
    return tools::find_landmarks(pack, tools::everywhere(pack), o.output.string());
  }
  static inline fs::path folder_;
};

size_t buildings_near(std::span<const Landmark> found, double east_m, double north_m, double reach_m) {
  return size_t(std::ranges::count_if(found, [&](const Landmark& m) {
    return m.landmark_class == LF_BUILDING && std::hypot(m.east_m - east_m, m.north_m - north_m) <= reach_m;
  }));
}

TEST_F(MapFeatures, BuildingsOfTheWorldAreInThePack) {
  const BuildOptions o = options("one.lfpack");
  run(o);
  const std::vector<Landmark> found = landmarks_of(o);
  const synth::World drawn(world(synth::Season::kSummer, 2020));
  size_t known = 0, hit = 0;
  const synth::Rectangle inside = drawn.extent().grown(-20);
  for (const synth::Building& b : drawn.labels(inside).buildings) {
    if (!inside.contains(b.centre)) continue;
    ++known;
    hit += buildings_near(found, b.centre.x, b.centre.y, 3) > 0;
  }
  ASSERT_GT(known, 20u);
  EXPECT_GE(double(hit), 0.8 * double(known)) << "of a world that no model has seen";
  size_t right = 0, buildings = 0;
  for (const Landmark& m : found) {
    if (m.landmark_class != LF_BUILDING) continue;
    ++buildings;
    EXPECT_GT(m.distinctiveness_m, 0);
    EXPECT_LE(m.distinctiveness_m, 512);
    EXPECT_EQ(m.epochs_seen, 1);
    right += std::ranges::any_of(drawn.labels(drawn.extent()).buildings, [&](const synth::Building& b) {
      return std::hypot(b.centre.x - m.east_m, b.centre.y - m.north_m) <= 5;
    });
  }
  EXPECT_GE(double(right), 0.8 * double(buildings));
}

// Fields beyond what find_landmarks sees whole, through the journal and the last pass.
TEST_F(MapFeatures, BroadFieldsOfTheWorldAreInThePack) {
  const BuildOptions o = options("broad.lfpack");
  run(o);
  const synth::World drawn(world(synth::Season::kSummer, 2020));
  const std::vector<synth::Field> fields = drawn.labels(drawn.extent()).fields;
  const auto is_field = [&](const Landmark& m) {
    return std::ranges::any_of(fields, [&](const synth::Field& f) {
      std::vector<cv::Point2f> near;
      for (const synth::Point& p : f.outline) near.emplace_back(float(p.x - m.east_m), float(p.y - m.north_m));
      const cv::Moments moments = cv::moments(near);
      return std::hypot(moments.m10, moments.m01) <= 10 * std::abs(moments.m00);
    });
  };
  size_t broad = 0, right = 0;
  for (const Landmark& m : landmarks_of(o)) {
    if (m.landmark_class != LF_FIELD || m.length_m < 125 || m.confidence < 0.5) continue;
    ++broad;
    right += is_field(m);
  }
  EXPECT_GE(broad, 3u);
  EXPECT_GE(double(right), 0.5 * double(broad)) << "within 10 m; 0.6 of all in worlds that nothing was fitted on";
}

TEST_F(MapFeatures, TheSameBytesWhateverTheThreadsAndInterruptions) {
  BuildOptions one = options("threads1.lfpack"), three = options("threads3.lfpack"), halted = options("halted.lfpack");
  one.threads = 1, three.threads = 3;
  run(one);
  run(three);
  EXPECT_EQ(bytes_of(one.output), bytes_of(three.output));
  for (const size_t survived : {size_t(1), size_t(4)}) {  // of four blocks and the last pass
    std::atomic<bool> stop = false;
    halted.stop = &stop;
    halted.after_job = [&](size_t done) { stop = stop || done == survived; };
    EXPECT_THROW(run(halted), Interrupted);
    halted.stop = nullptr, halted.after_job = {};
    EXPECT_GE(run(halted).resumed_jobs, survived);
    EXPECT_EQ(bytes_of(halted.output), bytes_of(one.output)) << survived;
  }
}

// The graph of the pack is that of the image as a whole, but for what lies at its rim, where a build sees no data and
// the whole image is mirrored.
TEST_F(MapFeatures, BlocksLeaveNoSeamsInRoads) {
  const BuildOptions o = options("seams.lfpack");
  run(o);
  const Pack pack = tools::open_pack(o.output.string());
  const tools::RoadSet in_pack = tools::find_roads(pack, tools::everywhere(pack), o.output.string());
  const fs::path image = folder_ / "summer/ortho.tif";
  const features::GridImage whole =
      ingest::load_image({.path = image}, ingest::standard_zone_of(image), std::nullopt, landmarks::kRoadGsd_m);
  const tiles::RoadGraph graph = landmarks::extract_roads(whole, landmarks::default_road_model());
  const auto is_inside = [](double east_m, double north_m) {
    constexpr double kRim_m = 120;
    return east_m > kWest_m + kRim_m && east_m < kWest_m + kSize_m - kRim_m && north_m > kSouth_m + kRim_m &&
           north_m < kSouth_m + kSize_m - kRim_m;
  };
  const auto intersections = tools::find_intersections(pack, tools::everywhere(pack), o.output.string());
  size_t compared = 0;
  for (const tiles::RoadNode& node : graph.nodes) {
    if (node.kind != tiles::RoadNodeKind::kIntersection || !is_inside(node.east_m, node.north_m)) continue;
    ++compared;
    EXPECT_TRUE(std::ranges::any_of(
        intersections,
        [&](const Intersection& i) { return std::hypot(i.east_m - node.east_m, i.north_m - node.north_m) < 0.5; }))
        << node.east_m << " " << node.north_m;
  }
  EXPECT_GT(compared, 3u);
  EXPECT_FALSE(in_pack.roads.empty());
}

TEST_F(MapFeatures, DatesThatShowALandmarkAreCounted) {
  const BuildOptions o = options("dates.lfpack", {"summer", "autumn"});
  run(o);
  const std::vector<Landmark> found = landmarks_of(o);
  const auto buildings = std::ranges::count(found, uint8_t(LF_BUILDING), &Landmark::landmark_class);
  const auto twice = std::ranges::count_if(
      found, [](const Landmark& m) { return m.landmark_class == LF_BUILDING && m.epochs_seen == 2; });
  ASSERT_GT(buildings, 20);
  EXPECT_GE(double(twice), 0.7 * double(buildings));
  EXPECT_TRUE(std::ranges::all_of(found, [](const Landmark& m) { return m.epochs_seen == 1 || m.epochs_seen == 2; }));
  const Pack pack = tools::open_pack(o.output.string());
  EXPECT_EQ(pack.info().epoch_count, 2u);
}

TEST_F(MapFeatures, KnownOnesComeFirst) {
  BuildOptions o = options("known.lfpack");
  o.vectors = {{(folder_ / "summer/buildings.geojson").string(), {}, {}},
               {(folder_ / "summer/roads.geojson").string(), {}, {}}};
  run(o);
  const std::vector<Landmark> all = landmarks_of(o);
  size_t known = 0, trees = 0;
  for (const Landmark& m : all) {
    known += m.source == 1;
    trees += m.landmark_class == LF_TREE;
    if (m.source != 1) continue;
    EXPECT_EQ(std::ranges::count_if(all,
                                    [&](const Landmark& other) {
                                      return other.source == -1 && other.landmark_class == m.landmark_class &&
                                             std::hypot(other.east_m - m.east_m, other.north_m - m.north_m) < 4.5;
                                    }),
              0);
  }
  EXPECT_GT(known, 20u);
  EXPECT_GT(trees, 20u) << "what the vectors do not tell of is found";
  const Pack pack = tools::open_pack(o.output.string());
  for (const Road& road : tools::find_roads(pack, tools::everywhere(pack), o.output.string()).roads)
    EXPECT_EQ(road.source, 2) << "known roads are taken alone";
}

TEST_F(MapFeatures, AModelThatIsNoneIsRefused) {
  BuildOptions o = options("refused.lfpack");
  o.landmark_model = (folder_ / "summer/ortho.tif.json").string();
  try {
    run(o);
    FAIL() << "the build went on";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kBadInput);
    EXPECT_NE(std::string(error.what()).find("ortho.tif.json"), std::string::npos) << error.what();
  }
  EXPECT_FALSE(fs::exists(o.output));
}

}  // namespace
}  // namespace landfix
