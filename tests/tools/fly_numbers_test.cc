// The numbers that a flight without GNSS must reach: over a synthetic world in another sun than its map's, with blur,
// gain and noise, by gray values alone and by orientation.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tests/tools/memory_map.h"
#include "tools/fly/summary.h"
#include "tools/synth/world.h"

namespace landfix::fly {
namespace {

constexpr double kSize = 840;

double degrees(double deg) { return deg * M_PI / 180; }

/// A village with woods and fields; the map shows it in the morning, the scenes two and six hours later.
class FlightNumbers : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    synth::WorldOptions morning;
    morning.seed = 7;
    morning.size_m = kSize;
    const double north_m = morning.south_m + kSize;
    middle_east_m_ = morning.west_m + kSize / 2, middle_north_m_ = north_m - kSize / 2;
    const synth::Window pixels{morning.west_m, north_m, int(kSize / 0.5), int(kSize / 0.5), 0.5};
    const synth::Window posts{morning.west_m, north_m, int(kSize), int(kSize), 1.0};
    const synth::World world(morning);
    const features::GridImage heights = world.dsm(posts), map = world.ortho(pixels);
    constexpr nav::MapLayer kLayers[] = {nav::MapLayer::kGray, nav::MapLayer::kOrientation};
    gray_map_ = new MemoryMap(map, heights);
    map_ = new MemoryMap(map, heights, kLayers);
    const auto scene_at = [&](double sun_moved_deg) {
      synth::WorldOptions later = morning;
      later.sun_azimuth_deg = morning.sun_azimuth_deg + sun_moved_deg;
      later.sun_elevation_deg = 50;
      return new terrain::Scene(synth::World(later).ortho(pixels), heights);
    };
    noon_ = scene_at(30);
    evening_ = scene_at(85);
    route_ = new Route(Route::loop(middle_east_m_, middle_north_m_, 1000, 40));
  }
  static void TearDownTestSuite() {
    delete route_;
    delete evening_;
    delete noon_;
    delete map_;
    delete gray_map_;
  }

  static Summary fly_pooled(const terrain::Scene& scene, const MemoryMap& map, FlightOptions options, int flights) {
    options.image_interval_s = 1;
    options.camera = nav::camera_from_field_of_view(400, 300, degrees(60));
    options = with_known_errors(options);
    std::vector<std::vector<Record>> all;
    for (int i = 0; i < flights; ++i) all.push_back(fly(scene, map, *route_, options, uint64_t(i) + 1));
    return summarize(all);
  }

  static double middle_east_m_, middle_north_m_;
  static MemoryMap *gray_map_, *map_;
  static terrain::Scene *noon_, *evening_;
  static Route* route_;
};
double FlightNumbers::middle_east_m_ = 0, FlightNumbers::middle_north_m_ = 0;
MemoryMap* FlightNumbers::gray_map_ = nullptr;
MemoryMap* FlightNumbers::map_ = nullptr;
terrain::Scene* FlightNumbers::noon_ = nullptr;
terrain::Scene* FlightNumbers::evening_ = nullptr;
Route* FlightNumbers::route_ = nullptr;

TEST_F(FlightNumbers, SixtyMetresUp) {
  const Summary s =
      fly_pooled(*noon_, *gray_map_, {}, 3);  // 0.5 degrees white and 0.3 degrees constant, drift 2.5 %: the defaults
  RecordProperty("summary", to_json(s).dump());
  EXPECT_LT(s.rms_m, 1.5);
  EXPECT_LT(s.max_m, 4.0);
  EXPECT_GE(s.inside_3_sigma, 0.97);
  EXPECT_GT(s.dead_reckoning_final_m, 15);  // what odometry alone comes to: about 2.5 % of 920 m
}

TEST_F(FlightNumbers, ThreeHundredMetresUpWithOneDegreeOfNoise) {
  FlightOptions options;
  options.agl_m = 305;
  options.sensors.attitude_noise_rad = degrees(1);
  const Summary s = fly_pooled(*noon_, *gray_map_, options, 2);
  RecordProperty("summary", to_json(s).dump());
  EXPECT_LT(s.rms_m, 5.0);
  EXPECT_GE(s.inside_3_sigma, 0.97);
}

TEST_F(FlightNumbers, SixtyMetresUpWithTheShadowsElsewhere) {
  const Summary s = fly_pooled(*evening_, *map_, {}, 2);
  RecordProperty("summary", to_json(s).dump());
  EXPECT_LT(s.rms_m, 1.5);
  EXPECT_LT(s.max_m, 4.0);
  EXPECT_GE(s.inside_3_sigma, 0.97);
}

TEST_F(FlightNumbers, ColdStartsWithTheShadowsElsewhereAreSureByOrientation) {
  // Views of 39 × 29 m, known to 40 m: gray values, in another light, leave doubt that the gate must not let through;
  // orientation leaves none. Neither may be wrong.
  const nav::Camera camera = nav::camera_from_field_of_view(160, 120, degrees(36));
  std::map<nav::Method, int> fixes;
  for (int i = 0; i < 12; ++i) {
    const double east = middle_east_m_ - 180 + 120 * (i % 4), north = middle_north_m_ + 180 - 120 * (i / 4);
    const terrain::Pose truth{east, north, *evening_->height_below(east, north) + 60, {0, 0, 0.4 * i}};
    const cv::Mat image = evening_->render(camera, truth).image;
    for (const nav::Method method : {nav::Method::kOrientation, nav::Method::kGray}) {
      nav::LocalizerOptions options;
      options.method = method;
      options.gate = nav::Gate::kStandard;
      nav::Localizer localizer(*map_, options);
      ASSERT_EQ(localizer.start(east + 28, north - 35, 40), nav::Status::kOk);
      const nav::Fix fix = localizer.update(image, camera, truth.attitude, truth.height_m, 0);
      if (fix.status != nav::Status::kOk) continue;
      ++fixes[method];
      EXPECT_LT(std::hypot(fix.east_m - east, fix.north_m - north), 2) << nav::name_of(method) << " " << i;
    }
  }
  RecordProperty("orientation", fixes[nav::Method::kOrientation]);
  RecordProperty("gray", fixes[nav::Method::kGray]);
  EXPECT_GE(fixes[nav::Method::kOrientation], 11);
  EXPECT_LE(fixes[nav::Method::kGray], 6);
}

TEST_F(FlightNumbers, SixtyMetresUpWithTheHeadingThreeDegreesOff) {
  // Odometry, turned by that heading, drifts 5 % of the distance to the side: the image has to tell.
  FlightOptions options;
  options.sensors.heading_bias_rad = degrees(3);
  const Summary s = fly_pooled(*noon_, *map_, options, 1);
  RecordProperty("summary", to_json(s).dump());
  EXPECT_LT(s.rms_m, 1.5);
  EXPECT_LT(s.max_m, 4.0);
  EXPECT_GE(s.inside_3_sigma, 0.97);
}

}  // namespace
}  // namespace landfix::fly
