// What builds say of how well places can be navigated by: from several dates and from one, by every matcher that the
// pack serves, with reasons; the same bytes whatever the threads and interruptions.
#include "builder/map_navigability.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <iterator>

#include "builder/build.h"
#include "runtime/nav/pack_map.h"
#include "tests/builder/ingest_fixture.h"
#include "tests/nav/scene.h"
#include "tools/common/navigability_map.h"
#include "tools/common/open_pack.h"
#include "tools/synth/world.h"

namespace landfix {
namespace {

using ingest::Sketch;
using tiles::Finder;
using tiles::Navigability;
using tiles::Reason;

constexpr tiles::Footprint kView{128, 64};  // at 4 m: 32 px searched over ±16
constexpr double kGsd_m = 4;
constexpr int kSide_px = 224;  // 14 nodes of 64 m a side, from a corner of nodes on
constexpr double kWest_m = 64 * 7800, kNorth_m = 64 * 81000;

cv::Mat fields(uint64_t seed, uint64_t season) { return nav::testing::countryside(kSide_px, seed, season); }

class MapNavigability : public ingest::Ingest {
 protected:
  // A file of an image (CV_8UC1, 3 or 4) or heights (CV_32FC1).
  std::string draw(const std::string& name, const cv::Mat& image, double gsd_m = kGsd_m) const {
    Sketch sketch;
    const double geotransform[6] = {kWest_m, gsd_m, 0, kNorth_m, 0, -gsd_m};
    std::copy(geotransform, geotransform + 6, sketch.geotransform);
    sketch.width = image.cols, sketch.height = image.rows, sketch.bands = image.channels();
    if (image.depth() == CV_32F) sketch.type = GDT_Float32;
    sketch.value = [&](int band, int column, int row) {
      return image.depth() == CV_32F ? double(image.at<float>(row, column)) : double(image.ptr(row, column)[band - 1]);
    };
    return write(name, sketch);
  }

  // Three dates of one place, in the order of the argument.
  BuildOptions fields_of(const std::vector<std::string>& dates) const {
    BuildOptions o = options({});
    for (size_t i = 0; i < dates.size(); ++i)
      o.images.push_back({.path = draw(dates[i] + ".tif", fields(3, i)), .date = dates[i]});
    return o;
  }
  BuildOptions options(const std::vector<std::string>& images) const {
    BuildOptions o;
    for (const std::string& image : images) o.images.push_back({.path = image});
    o.layers = {"orientation", "gray"};
    o.footprints = {kView};
    o.output = path("map.lfpack");
    o.force = true;
    return o;
  }
  static BuildSummary run(const BuildOptions& o) {
    Progress silent;
    return build(o, silent);
  }
  std::string bytes(const BuildOptions& o) const {
    std::ifstream file(o.output, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  // What the pack of a build says.
  static tools::NavigabilityMap judged(const BuildOptions& o, const tiles::Footprint& footprint = kView) {
    run(o);
    return {tools::open_pack(o.output.string()), footprint, o.output.string()};
  }
  // The place so many pixels of 4 m from the north-western corner.
  static Navigability at(const tools::NavigabilityMap& map, double column, double row) {
    return map.at(kWest_m + kGsd_m * column, kNorth_m - kGsd_m * row).value();
  }
};

double chance(const Navigability& place, Finder finder) { return place.fix_probability[size_t(finder)]; }

TEST_F(MapNavigability, EveryPlaceIsJudgedByWhatThePackServes) {
  BuildOptions o = fields_of({"2018-07-16", "2016-08-16", "2014-07-20"});
  o.layers = {"orientation", "gray", "edge"};
  const tools::NavigabilityMap map = judged(o);
  ASSERT_EQ(map.columns(), 14);
  ASSERT_EQ(map.rows(), 14);
  int found = 0;
  for (int row = 0; row < 14; ++row)
    for (int column = 0; column < 14; ++column) {
      const std::optional<Navigability> place = map.node(column, row);
      const bool corner = column % 13 == 0 && row % 13 == 0;  // less than half of the view is shown with its directions
      ASSERT_EQ(place.has_value(), !corner);
      if (corner) continue;
      EXPECT_EQ(place->dates, 3u);
      EXPECT_EQ(place->newest_day, nav::day_of("2018-07-16"));
      for (const Finder finder : {Finder::kAuto, Finder::kOrientation, Finder::kGray, Finder::kEdge}) {
        EXPECT_GT(chance(*place, finder), 0) << column << " " << row << " " << int(finder);
        EXPECT_LT(chance(*place, finder), 1);
      }
      EXPECT_TRUE(std::isnan(chance(*place, Finder::kContour))) << "a layer that the pack lacks";
      EXPECT_NEAR(place->false_probability, 0.1 * (1 - chance(*place, Finder::kAuto)), 0.004) << "one miss in ten";
      EXPECT_GE(place->major_m, place->minor_m);
      EXPECT_EQ(place->has(Reason::kNoData), column % 13 == 0 || row % 13 == 0) << "views of two nodes a side";
      EXPECT_FALSE(place->has(Reason::kOneDate));
      found += chance(*place, Finder::kOrientation) > 0.8;
    }
  EXPECT_GT(found, 120) << "of 192: seasons change colours and some edges, and places are found nevertheless";
}

TEST_F(MapNavigability, TheSameBytesWhateverTheThreadsAndInterruptions) {
  BuildOptions one = fields_of({"2018-07-16", "2016-08-16"}), two = one, halted = one;
  one.threads = 1, two.threads = 2;
  two.output = path("two.lfpack"), halted.output = path("halted.lfpack");
  run(one);
  run(two);
  EXPECT_EQ(bytes(one), bytes(two));
  std::atomic<bool> stop = false;
  halted.stop = &stop;
  halted.after_job = [&](size_t done) { stop = stop || done == 1; };
  EXPECT_THROW(run(halted), Interrupted);
  halted.stop = nullptr, halted.after_job = {};
  EXPECT_GE(run(halted).resumed_jobs, 1u);
  EXPECT_EQ(bytes(halted), bytes(one));
}

// Blocks of 4 m have 4096 m a side; the corner of four of them is put in the middle of the images.
TEST_F(MapNavigability, BlocksLeaveNoSeams) {
  BuildOptions o = options({});
  const double west_m = 4096 * 122 - 64 * 7, north_m = 4096 * 1265 + 64 * 7;
  for (int i = 0; i < 2; ++i) {
    const std::string file = draw(std::to_string(i) + ".tif", fields(3, uint64_t(i)));
    const GDALDatasetUniquePtr moved(GDALDataset::Open(file.c_str(), GDAL_OF_UPDATE));
    double there[6] = {west_m, kGsd_m, 0, north_m, 0, -kGsd_m};
    moved->SetGeoTransform(there);
    o.images.push_back({.path = file, .date = i == 0 ? "2018-07-16" : "2016-08-16"});
  }
  const tools::NavigabilityMap across = judged(o);
  const tools::NavigabilityMap inside = judged(fields_of({"2018-07-16", "2016-08-16"}));
  ASSERT_EQ(across.columns(), 14);
  for (int row = 0; row < 14; ++row)
    for (int column = 0; column < 14; ++column) {
      const std::optional<Navigability> a = across.node(column, row), b = inside.node(column, row);
      ASSERT_EQ(a.has_value(), b.has_value());
      if (!a) continue;
      EXPECT_EQ(chance(*a, Finder::kOrientation), chance(*b, Finder::kOrientation)) << column << " " << row;
      EXPECT_EQ(a->major_m, b->major_m);
      EXPECT_FALSE(std::isnan(chance(*a, Finder::kGray)));
    }
}

TEST_F(MapNavigability, OneDateSaysSo) {
  BuildOptions o = options({draw("undated.tif", fields(3, 0))});
  const Navigability place = at(judged(o), 112, 112);
  EXPECT_TRUE(place.has(Reason::kOneDate));
  EXPECT_EQ(place.dates, 1u);
  EXPECT_FALSE(place.newest_day);
  EXPECT_FALSE(place.has(Reason::kDatesDisagree));
  EXPECT_GT(chance(place, Finder::kAuto), 0.2);
  EXPECT_LT(chance(place, Finder::kAuto), 0.95) << "what will change is not known";
}

TEST_F(MapNavigability, OneDateIsDrawnAlikeByAnyNumberOfThreads) {
  BuildOptions one = options({draw("undated.tif", fields(3, 0))}), two = one;
  one.threads = 1, two.threads = 2;
  two.output = path("two.lfpack");
  run(one);
  run(two);
  EXPECT_EQ(bytes(one), bytes(two));
}

TEST_F(MapNavigability, NodesLieAtMostHalfAViewApart) {
  BuildOptions o = fields_of({"2018-07-16", "2016-08-16"});
  constexpr tiles::Footprint kSmall{64, 64};  // matched at 4 m as well
  o.footprints = {kView, kSmall};
  const tools::NavigabilityMap wide = judged(o), close{tools::open_pack(o.output.string()), kSmall, "close"};
  EXPECT_EQ(wide.spacing_m(), 64);
  EXPECT_EQ(close.spacing_m(), 32);
  ASSERT_EQ(wide.columns(), 14);
  ASSERT_EQ(close.columns(), 28);
  ASSERT_EQ(close.rows(), 28);
  for (int i = 1; i < 27; ++i) {
    ASSERT_TRUE(close.node(i, i)) << i;
    EXPECT_FALSE(close.node(i, i)->has(Reason::kNoData)) << "the whole view of two nodes a side is shown";
    EXPECT_EQ(close.at(kWest_m + 32 * (i + 0.5), kNorth_m - 32 * (i + 0.5))->major_m, close.node(i, i)->major_m);
  }
  o.footprints = {kView};
  EXPECT_EQ(chance(*judged(o).node(5, 5), Finder::kAuto), chance(*wide.node(5, 5), Finder::kAuto))
      << "the same whatever else is judged";
}

TEST_F(MapNavigability, GrayImagesAreJudgedInGray) {
  BuildOptions o = options({});
  for (uint64_t i = 0; i < 2; ++i) {
    cv::Mat gray;
    cv::extractChannel(fields(3, i), gray, 1);
    o.images.push_back({.path = draw(std::to_string(i) + ".tif", gray), .date = i == 0 ? "2018-07-16" : "2016-08-16"});
  }
  o.layers = {"gray"};
  const Navigability place = at(judged(o), 112, 112);
  EXPECT_EQ(chance(place, Finder::kAuto), chance(place, Finder::kGray)) << "the only matcher that this pack serves";
  EXPECT_TRUE(std::isnan(chance(place, Finder::kOrientation)));
  EXPECT_GT(chance(place, Finder::kGray), 0.05);
}

TEST_F(MapNavigability, EvenGroundIsPoorGround) {
  cv::Mat half = fields(3, 0);
  half.colRange(0, kSide_px / 2).setTo(cv::Scalar(80, 120, 90));
  const tools::NavigabilityMap map = judged(options({draw("half.tif", half)}));
  const Navigability even = at(map, 56, 112), textured = at(map, 168, 112);
  EXPECT_TRUE(even.has(Reason::kUniform));
  EXPECT_LT(chance(even, Finder::kOrientation), 0.2);
  EXPECT_LT(chance(even, Finder::kGray), 0.5);
  EXPECT_EQ(even.rival_m, 0) << "nothing looks like it, as it looks like nothing";
  EXPECT_FALSE(textured.has(Reason::kUniform));
  EXPECT_GT(chance(textured, Finder::kOrientation), chance(even, Finder::kOrientation) + 0.3);
}

TEST_F(MapNavigability, WhatRepeatsSaysWhere) {
  cv::Mat rows, image;
  cv::repeat(fields(3, 0).colRange(0, 14), 1, 16, rows);  // 56 m
  image = rows.colRange(0, kSide_px).clone();
  const Navigability place = at(judged(options({draw("rows.tif", image)})), 112, 112);
  EXPECT_TRUE(place.has(Reason::kRepeats));
  EXPECT_NEAR(place.rival_m, 56, 3);
  EXPECT_NEAR(std::abs(std::sin(place.rival_bearing_rad)), 1, 0.05) << "to the east or to the west";
  EXPECT_NE(tools::reasons_text(place).find("looks like the place 5"), std::string::npos) << tools::reasons_text(place);
}

TEST_F(MapNavigability, WhereNothingIsShownNothingIsSaid) {
  cv::Mat cut = fields(3, 0);
  cut.rowRange(0, 96).setTo(cv::Scalar::all(0));  // six rows of nodes
  BuildOptions o = options({draw("cut.tif", cut)});
  o.images[0].nodata = 0;
  const tools::NavigabilityMap map = judged(o);
  EXPECT_FALSE(map.node(7, 3)) << "no view of 128 m there shows anything";
  EXPECT_FALSE(map.node(7, 5)) << "a quarter of its view is left";
  ASSERT_TRUE(map.node(7, 6)) << "three quarters";
  EXPECT_TRUE(map.node(7, 6)->has(Reason::kNoData));
  EXPECT_FALSE(map.node(7, 8)->has(Reason::kNoData));
}

TEST_F(MapNavigability, AMapTooSmallForAViewIsStillAMap) {
  const BuildOptions o = options({draw("small.tif", cv::Mat(fields(3, 0), {0, 0, 24, 24}))});  // 96 m; a view is 128 m
  run(o);
  const Pack pack = tools::open_pack(o.output.string());
  EXPECT_TRUE(pack.verify(true));
  EXPECT_FALSE(pack.find_layer("navigability/128/64"));
}

TEST_F(MapNavigability, WaterIsKnownByItsInfrared) {
  cv::Mat image(kSide_px, kSide_px, CV_8UC4), colours = fields(3, 0), nir(kSide_px, kSide_px, CV_8U, cv::Scalar(160));
  nir.colRange(0, 80).setTo(15);  // five columns of nodes
  const int from_to[] = {0, 0, 1, 1, 2, 2, 3, 3};
  cv::mixChannels(std::vector{colours, nir}, std::vector{image}, from_to, 4);
  BuildOptions o = options({draw("lake.tif", image)});
  o.images[0].bands = "red,green,blue,nir";
  const tools::NavigabilityMap map = judged(o);
  EXPECT_TRUE(at(map, 40, 112).has(Reason::kWater));
  EXPECT_FALSE(at(map, 150, 112).has(Reason::kWater));
  const tools::NavigabilityMap without = judged(options({draw("colours.tif", colours)}));
  EXPECT_FALSE(at(without, 40, 112).has(Reason::kWater)) << "colours alone do not tell";
}

TEST_F(MapNavigability, StrongReliefIsThatOfTheView) {
  cv::Mat heights(kSide_px, kSide_px, CV_32F, cv::Scalar(400));
  for (int x = kSide_px / 2; x < kSide_px; ++x) heights.col(x).setTo(400 + 2 * (x - kSide_px / 2));  // 1 in 2
  BuildOptions o = options({draw("fields.tif", fields(3, 0))});
  o.elevation = ingest::SourceOptions{.path = draw("heights.tif", heights), .datum = "ellipsoid"};
  const tools::NavigabilityMap map = judged(o);
  EXPECT_FALSE(at(map, 56, 112).has(Reason::kRelief));
  // 64 m over a view of 128 m: a standard deviation of 64 / sqrt(12) = 18 m, of which 128 / 12 = 11 m are strong.
  EXPECT_TRUE(at(map, 168, 112).has(Reason::kRelief));
}

TEST_F(MapNavigability, ShadowsAreDarkerThanWhatIsAroundThem) {
  constexpr int kSide = 512;  // pixels of 1 m
  cv::RNG random(9);
  cv::Mat image(kSide, kSide, CV_8UC3);
  random.fill(image, cv::RNG::UNIFORM, 110, 150);
  for (int y = 0; y < kSide; y += 16)  // in the west, of 16 x 16 m, 10 x 10 lie in shadow
    for (int x = 0; x < kSide / 2; x += 16) image(cv::Rect(x, y, 10, 10)) *= 0.3;
  BuildOptions o = options({draw("shadows.tif", image, 1)});
  const tools::NavigabilityMap map = judged(o);
  EXPECT_TRUE(map.at(kWest_m + 112, kNorth_m - 256)->has(Reason::kShadow)) << "39 %";
  EXPECT_FALSE(map.at(kWest_m + 400, kNorth_m - 256)->has(Reason::kShadow));
}

// A drawn world at 1 m, where landmarks are sought: the wood is where its trees are.
TEST_F(MapNavigability, WoodsAndLandmarksAreThoseOfTheWorld) {
  synth::WorldOptions world;
  world.seed = 77, world.gsd_m = 1, world.size_m = 512;
  world.west_m = 64 * 7833, world.south_m = 64 * 84381;
  synth::write_world(world, folder_ / "world");
  BuildOptions o = options({path("world/ortho.tif")});
  o.layers = {"orientation", "landmarks"};
  const tools::NavigabilityMap map = judged(o);
  const std::vector<synth::Tree> trees = synth::World(world).labels(synth::World(world).extent()).trees;
  int in_woods = 0, outside = 0;
  unsigned landmarks = 0;
  for (int row = 1; row + 1 < map.rows(); ++row)
    for (int column = 1; column + 1 < map.columns(); ++column) {
      // In the three nodes a side that a view of two is rounded to.
      const auto near = std::ranges::count_if(trees, [&](const synth::Tree& tree) {
        const double east_m = tree.position.x - map.east_of(column), north_m = tree.position.y - map.north_of(row);
        return std::max(std::abs(east_m), std::abs(north_m)) < 96;
      });
      const Navigability place = map.node(column, row).value();
      if (near > 700 || near < 300) {
        EXPECT_EQ(place.has(Reason::kWood), near > 700) << column << " " << row << ": " << near;
      }
      in_woods += near > 700, outside += near < 300;
      EXPECT_TRUE(place.landmarks > 1 || place.diversity == 0) << "one landmark is of one class";
      landmarks += place.landmarks;
    }
  EXPECT_GT(in_woods, 12);
  EXPECT_GT(outside, 6);
  EXPECT_GT(landmarks, 10u);
}

TEST_F(MapNavigability, RefusesWhatCannotBeJudged) {
  BuildOptions o = options({draw("fields.tif", fields(3, 0))});
  o.footprints = {{48, 160}};
  ingest::expect_error(ExitCode::kUsage, {"48/160", "fewer than 16 pixels", "64 m"}, [&] { run(o); });
  // At 16 m, the coarsest level that is matched: 512 pixels are 8192 m. At 4 m they are 2048 m.
  for (const tiles::Footprint far : {tiles::Footprint{9000, 4000}, {1e6, 160}, {160, 1969}, {160, 1e70}}) {
    o.footprints = {far};
    ingest::expect_error(ExitCode::kUsage, {"--navigability", far.template_m > 160 ? "8192 m" : "2048 m"},
                         [&] { run(o); });
  }
  o.footprints = {kView};
  o.layers = {"overview"};
  ingest::expect_error(ExitCode::kUsage, {"--navigability", "orientation, gray"}, [&] { run(o); });
}

}  // namespace
}  // namespace landfix
