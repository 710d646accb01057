// Landmarks and roads: how fast they are found in a map and in a camera's image, what they take in a pack, how fast a
// vehicle finds them there.
#include <fmt/format.h>

#include <numeric>
#include <opencv2/core/utility.hpp>
#include <random>

#include "builder/build.h"
#include "builder/ingest/window.h"
#include "builder/landmarks/extraction.h"
#include "builder/landmarks/landmark_model.h"
#include "builder/roads/road_candidates.h"
#include "runtime/features/landmark_classifier.h"
#include "schemas/pack_layout.h"
#include "tools/bench/process.h"
#include "tools/bench/sections.h"
#include "tools/bench/timing.h"
#include "tools/common/map_features.h"
#include "tools/common/open_pack.h"

namespace landfix::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kThreads = 2;
constexpr double kBytesPerLandmark = 5, kKilobytesPerKm2 = 4, kCameraImage_ms = 150;
constexpr int kSeed = 31, kSize_m = 3000;
const cv::Size kCamera_px{1280, 960};
constexpr int kCameraImages = 5, kWindowStep = 2;
constexpr int kQueries = 1000;
constexpr double kRadius_m = 120;

/// Bytes of a layer with its entries in the directory.
double bytes_of(const BuildSummary& summary, const std::string& name) {
  double bytes = 0;
  for (const LayerSummary& layer : summary.layers)
    if (layer.name == name)
      for (const LevelSummary& level : layer.levels)
        bytes += double(level.bytes) + double(level.tiles) * sizeof(schema::TileRecord);
  return bytes;
}

void measure_queries(const Pack& pack, Report& report) {
  const uint32_t landmarks = *pack.find_layer("landmarks"), roads = *pack.find_layer("roads");
  const lf_info map = pack.info();
  for (const uint32_t layer : {landmarks, roads})
    tools::check(pack.prepare(*pack.box(layer, map.west_m, map.south_m, map.east_m, map.north_m, 8)), "prepare");
  std::mt19937_64 random(5);
  const auto between = [&](double low, double high) { return low + (high - low) * double(random() >> 11) * 0x1p-53; };
  std::vector<double> of_landmarks, of_intersections;
  double found = 0;
  std::vector<Landmark> some(4096);
  std::vector<Intersection> crossings(4096);
  for (int i = 0; i < kQueries; ++i) {
    const double east = between(map.west_m, map.east_m), north = between(map.south_m, map.north_m);
    FeatureQuery query;
    query.ellipse = Ellipse{east, north, kRadius_m * kRadius_m, 0, kRadius_m * kRadius_m, 1};
    size_t count = 0;
    of_landmarks.push_back(
        processor_time_of([&] { tools::check(pack.find_landmarks(landmarks, query, some, count), "landmarks"); }));
    found += double(count);
    of_intersections.push_back(processor_time_of(
        [&] { tools::check(pack.find_intersections(roads, query, crossings, count), "intersections"); }));
  }
  const std::string where = fmt::format(" within {:.0f} m, median", kRadius_m);
  report.measured("landmarks" + where, 1e6 * median(of_landmarks), "us");
  report.measured("intersections" + where, 1e6 * median(of_intersections), "us");
  report.measured("landmarks found each time", found / kQueries, "");
}

/// One image as the vehicle sees it after rectification, 1 m a pixel, on one core.
void measure_camera(const fs::path& image, Report& report) {
  const features::GridImage map = ingest::load_image({.path = image}, ingest::standard_zone_of(image), std::nullopt, 1);
  const cv::Rect middle((map.pixels.cols - kCamera_px.width) / 2, (map.pixels.rows - kCamera_px.height) / 2,
                        kCamera_px.width, kCamera_px.height);
  const features::GridImage seen{map.pixels(middle).clone(), {}, 0, 0, 1};
  const cv::Rect all({}, kCamera_px);
  features::LandmarkClassifier classifier(landmarks::default_landmark_model());
  cv::Mat labels, confidence;
  cv::setNumThreads(1);
  std::vector<double> classes, objects, places;
  for (int i = 0; i < kCameraImages; ++i) {
    classes.push_back(processor_time_of([&] {
      classifier.prepare(seen.pixels, seen.valid);
      classifier.scan(kWindowStep, labels, confidence);
    }));
    objects.push_back(
        processor_time_of([&] { landmarks::find_landmarks(seen, all, landmarks::default_object_model()); }));
    places.push_back(processor_time_of(
        [&] { landmarks::find_road_places(seen.pixels, seen.valid, all, landmarks::default_road_model()); }));
  }
  cv::setNumThreads(-1);
  const std::string what = fmt::format("image of {}x{} px at 1 m, one core: ", kCamera_px.width, kCamera_px.height);
  report.at_most(what + "classes of windows every 4 m", 1e3 * median(classes), "ms", kCameraImage_ms);
  report.measured(what + "landmarks", 1e3 * median(objects), "ms");
  report.measured(what + "places on roads", 1e3 * median(places), "ms");
}

}  // namespace

void bench_landmarks(const Data&, const Options& o, Report& report) {
  report.section("landmarks and roads",
                 fmt::format("a drawn world of {} km a side at 0.5 m, searched at 1 m by {} threads; bytes with the "
                             "directory's; {} random places; processor time",
                             kSize_m / 1000, kThreads, kQueries));
  const fs::path world = o.work / "landmarks", pack = o.work / "landmarks.lfpack";
  if (!fs::exists(world / "ortho.tif"))
    run({o.landfix, "synth", "--seed", std::to_string(kSeed), "--size-m", std::to_string(kSize_m), "--gsd", "0.5", "-o",
         world},
        world.string() + ".log");
  BuildOptions options;
  options.images.push_back({.path = world / "ortho.tif"});
  options.layers = {"landmarks", "roads"};
  options.output = pack;
  options.force = true;
  options.threads = kThreads;
  Progress silent;
  say("timing landfix build -> " + pack.string());
  const BuildSummary summary = landfix::build(options, silent);
  const Pack built = tools::open_pack(pack.string());
  report.measured("landmarks and roads of a map", summary.seconds / summary.area_km2, "s/km2");
  const tools::FeatureCounts counts =
      tools::count_features(built, *built.layer(*built.find_layer("landmarks")), pack.string());
  const double count = double(std::accumulate(counts.of_class.begin(), counts.of_class.end(), size_t(0)));
  report.measured("landmarks", count / summary.area_km2, "/km2");
  report.at_most("a landmark in the pack", bytes_of(summary, "landmarks") / count, "bytes", kBytesPerLandmark);
  report.at_most("landmarks and roads in the pack",
                 (bytes_of(summary, "landmarks") + bytes_of(summary, "roads")) / 1e3 / summary.area_km2, "kB/km2",
                 kKilobytesPerKm2);
  measure_queries(built, report);
  measure_camera(world / "ortho.tif", report);
  fs::remove(pack);
}

}  // namespace landfix::bench
