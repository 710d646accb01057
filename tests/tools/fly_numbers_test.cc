// The numbers that a flight without GNSS must reach: over a synthetic world in another sun than its map's, with blur,
// gain and noise.
#include <gtest/gtest.h>

#include <cmath>

#include "runtime/features/gray.h"
#include "tests/tools/memory_map.h"
#include "tools/fly/summary.h"
#include "tools/synth/world.h"

namespace landfix::fly {
namespace {

constexpr double kSize = 840;

double degrees(double deg) { return deg * M_PI / 180; }

/// A village with woods and fields; the map shows it in the morning, the scene two hours later.
class FlightNumbers : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    synth::WorldOptions morning;
    morning.seed = 7;
    morning.size_m = kSize;
    synth::WorldOptions noon = morning;
    noon.sun_azimuth_deg = morning.sun_azimuth_deg + 30;
    noon.sun_elevation_deg = 50;
    const double north_m = morning.south_m + kSize;
    const synth::Window pixels{morning.west_m, north_m, int(kSize / 0.5), int(kSize / 0.5), 0.5};
    const synth::Window posts{morning.west_m, north_m, int(kSize), int(kSize), 1.0};
    const synth::World world(morning);
    features::GridImage map = world.ortho(pixels);
    map.pixels = features::gray_from_rgb(map.pixels);
    const features::GridImage heights = world.dsm(posts);
    map_ = new MemoryMap(map, heights);
    scene_ = new terrain::Scene(synth::World(noon).ortho(pixels), heights);
    route_ = new Route(Route::loop(morning.west_m + kSize / 2, north_m - kSize / 2, 1000, 40));
  }
  static void TearDownTestSuite() {
    delete route_;
    delete scene_;
    delete map_;
  }

  static Summary fly_pooled(FlightOptions options, int flights) {
    options.image_interval_s = 1;
    options.camera = nav::camera_from_field_of_view(400, 300, degrees(60));
    options = with_known_errors(options);
    std::vector<std::vector<Record>> all;
    for (int i = 0; i < flights; ++i) all.push_back(fly(*scene_, *map_, *route_, options, uint64_t(i) + 1));
    return summarize(all);
  }

  static MemoryMap* map_;
  static terrain::Scene* scene_;
  static Route* route_;
};
MemoryMap* FlightNumbers::map_ = nullptr;
terrain::Scene* FlightNumbers::scene_ = nullptr;
Route* FlightNumbers::route_ = nullptr;

TEST_F(FlightNumbers, SixtyMetresUp) {
  const Summary s = fly_pooled({}, 3);  // 0.5 degrees white and 0.3 degrees constant, drift 2.5 %: the defaults
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
  const Summary s = fly_pooled(options, 2);
  RecordProperty("summary", to_json(s).dump());
  EXPECT_LT(s.rms_m, 5.0);
  EXPECT_GE(s.inside_3_sigma, 0.97);
}

}  // namespace
}  // namespace landfix::fly
