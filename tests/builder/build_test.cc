// The pipeline on drawn GeoTIFFs: what ends up in the pack, and that nothing but the inputs decides about its bytes.
#include "builder/build.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <landfix/landfix.hpp>
#include <map>
#include <numbers>
#include <opencv2/core.hpp>

#include "builder/catalog/catalog.h"
#include "runtime/features/contour.h"
#include "runtime/features/edge.h"
#include "tests/builder/ingest_fixture.h"

namespace landfix {
namespace {

namespace fs = std::filesystem;
using tiles::Codec;

using ingest::expect_error;
using ingest::Sketch;

// Images lie on the 1 m grid of zone 36N; column 0 begins at this easting and row 0 ends at this northing.
constexpr double kWest = 600'000, kNorth = 3'500'000;

// Texture that differs from pixel to pixel and never repeats across tiles.
int texture(int column, int row) {
  const uint32_t h = (uint32_t(column) * 2654435761u) ^ (uint32_t(row) * 2246822519u);
  return 1 + int((h >> 13) % 255);
}

// Pixels (column, row) and on, of which `value` draws all bands; 0 is no data in an image, -9999 in a DEM.
Sketch image(int column, int row, int width, int height, std::function<int(int column, int row)> value) {
  Sketch s;
  s.crs = "EPSG:32636";
  const double geotransform[6] = {kWest + column, 1, 0, kNorth - row, 0, -1};
  std::copy(geotransform, geotransform + 6, s.geotransform);
  s.width = width;
  s.height = height;
  s.value = [=](int, int x, int y) { return value(column + x, row + y); };
  s.finish = [](GDALDataset& file) {
    for (int b = 1; b <= file.GetRasterCount(); ++b)
      file.GetRasterBand(b)->SetNoDataValue(file.GetRasterBand(b)->GetRasterDataType() == GDT_Byte ? 0 : -9999);
  };
  return s;
}

// The same as heights with pixels of 2 m.
Sketch dem(int column, int row, int width, int height, std::function<int(int column, int row)> value) {
  Sketch s = image(column, row, width, height, std::move(value));
  s.geotransform[1] = 2;
  s.geotransform[5] = -2;
  s.bands = 1;
  s.type = GDT_Float32;
  return s;
}

std::vector<uint8_t> bytes_of_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class BuildTest : public ingest::Ingest {
 protected:
  BuildOptions options(const std::vector<fs::path>& images, const std::string& output = "out.lfpack") const {
    BuildOptions o;
    for (const fs::path& image : images) o.images.push_back({image.string(), {}, {}, {}});
    o.output = folder_ / output;
    o.threads = 2;
    o.layers = {"gray", "overview"};
    return o;
  }
  static BuildSummary build_silently(const BuildOptions& o) {
    Progress silent;
    return build(o, silent);
  }
  static void expect_failure(const BuildOptions& o, ExitCode code, const std::vector<std::string>& words) {
    expect_error(code, words, [&] { build_silently(o); });
  }
  fs::path journal() const { return folder_ / "out.lfpack.build"; }
  fs::path once(const std::string& name, const Sketch& sketch) const {
    return fs::exists(path(name)) ? path(name) : write(name, sketch);
  }
  fs::path town() const { return once("town.tif", image(-37, 11, 1800, 1300, texture)); }
  // Terrain under and around the town, in metres above the ellipsoid.
  fs::path hills() const {
    return once("hills.tif", dem(-200, -200, 1400, 1100, [](int x, int y) { return 200 + (x + y) / 16; }));
  }
  BuildOptions town_with_hills(const std::string& output = "out.lfpack") const {
    BuildOptions o = options({town()}, output);
    o.elevation = ingest::SourceOptions{hills().string(), {}, {}, "ellipsoid"};
    o.layers = {"gray", "overview", "height"};
    return o;
  }
  // The town in a western part, and an older image under all of it.
  BuildOptions two_dates(const std::string& output = "out.lfpack") const {
    const auto older = [](int x, int y) { return texture(x / 2 + 9000, y / 2); };
    BuildOptions o = options(
        {once("older.tif", image(-37, 11, 1500, 700, older)), once("newer.tif", image(-37, 11, 700, 700, texture))},
        output);
    o.images[0].date = "2009-08-18";
    o.images[1].date = "2018-07-16";
    o.layers.clear();
    return o;
  }
};

// Pixels of a layer of bytes, by the runtime: a rectangle of pixels of `gsd_m`, columns and rows counted in them.
cv::Mat read_bytes(const Pack& pack, const char* name, double gsd_m, int column, int row, int width, int height) {
  const auto layer = pack.find_layer(name);
  EXPECT_TRUE(layer) << layer.text();
  const auto region = pack.box(*layer, kWest + column * gsd_m, kNorth - (row + height) * gsd_m,
                               kWest + (column + width) * gsd_m, kNorth - row * gsd_m, gsd_m);
  EXPECT_TRUE(region) << region.text();
  cv::Mat out(int(region->height), int(region->width), CV_8UC1);
  EXPECT_EQ(pack.read(*region, {out.data, out.total()}, out.step), LF_OK);
  return out;
}

cv::Mat read_gray(const Pack& pack, int column, int row, int width, int height) {
  return read_bytes(pack, "gray", 1, column, row, width, height);
}

// Source pixels lie exactly on the grid, so resampling must hand them through: across tiles, jobs and the image's edge.
TEST_F(BuildTest, ShowsTheImagePixelByPixelWithoutSeams) {
  const BuildSummary summary = build_silently(options({town()}));
  EXPECT_EQ(summary.zone, (tiles::Zone{36, true}));
  EXPECT_EQ(summary.gsd_m, 1);
  const auto pack = Pack::open((folder_ / "out.lfpack").c_str());
  ASSERT_TRUE(pack) << pack.text();
  const auto checked = pack->verify(true);
  ASSERT_TRUE(checked) << checked.text();
  EXPECT_EQ(*checked, summary.tiles);
  const cv::Mat gray = read_gray(*pack, -37, 11, 1800, 1300);
  ASSERT_EQ(gray.size(), cv::Size(1800, 1300));
  int wrong = 0;
  for (int y = 0; y < gray.rows; ++y)
    for (int x = 0; x < gray.cols; ++x) wrong += gray.at<uint8_t>(y, x) != texture(x - 37, y + 11);
  EXPECT_EQ(wrong, 0);
  EXPECT_FALSE(fs::exists(journal()));
  // 1800 x 1300 m are no larger than a tile from 8 m per pixel on (2048 m a side): levels 0 to 3, overview from 2 on.
  ASSERT_EQ(summary.layers.size(), 2u);
  EXPECT_EQ(summary.layers[0].levels.back().level, 3);
  EXPECT_EQ(summary.layers[1].levels.front().level, 2);
  EXPECT_EQ(summary.layers[1].levels.back().level, 3);
  ASSERT_FALSE(summary.warnings.empty());
  EXPECT_NE(summary.warnings[0].find("--plane-height"), std::string::npos)
      << summary.warnings[0];  // there are no heights
}

TEST_F(BuildTest, GivesTheSameBytesWithAnyNumberOfThreads) {
  BuildOptions one = two_dates("one.lfpack"), four = two_dates("four.lfpack");
  one.elevation = four.elevation = ingest::SourceOptions{hills().string(), {}, {}, "ellipsoid"};
  one.threads = 1;
  four.threads = 4;
  const BuildSummary summary = build_silently(one);
  build_silently(four);
  ASSERT_EQ(summary.layers.size(), 9u);
  EXPECT_EQ(summary.layers[6].levels.front().level, 1);  // heights of 2 m under imagery of 1 m
  EXPECT_EQ(bytes_of_file(one.output), bytes_of_file(four.output));
}

TEST_F(BuildTest, PutsKnownLandmarksAndRoadsIntoThePack) {
  const auto geojson = [&](const std::string& name, const char* type, const char* coordinates) {
    return write_text(name, fmt::format(R"({{"type":"FeatureCollection","crs":{{"type":"name","properties":{{"name":)"
                                        R"("urn:ogc:def:crs:EPSG::32636"}}}},"features":[{{"type":"Feature",)"
                                        R"("properties":{{}},"geometry":{{"type":"{}","coordinates":{}}}}}]}})",
                                        type, coordinates));
  };
  const std::string houses = geojson("buildings.geojson", "Polygon",
                                     "[[[600100,3499900],[600140,3499900],[600140,3499880],[600100,3499880],"
                                     "[600100,3499900]]]");
  const std::string streets = geojson("streets.geojson", "LineString", "[[600100,3499800],[600300,3499800]]");
  BuildOptions o = options({town()});
  o.layers = {"gray", "landmarks", "roads"};
  o.vectors = {{houses, {}, {}}, {streets, {}, {}}};
  const BuildSummary summary = build_silently(o);
  EXPECT_EQ(summary.features, (std::vector<std::string>{"landmarks: 1 buildings", "roads: 0.2 km, 0 intersections"}));
  ASSERT_EQ(summary.layers.size(), 3u);
  const auto pack = Pack::open(o.output.c_str());
  ASSERT_TRUE(pack) << pack.text();
  EXPECT_TRUE(pack->verify(true));
  EXPECT_TRUE(pack->find_layer("landmarks"));
  EXPECT_TRUE(pack->find_layer("roads"));
  const std::vector<uint8_t> bytes = bytes_of_file(o.output);
  // A run that is stopped after its first job continues with the same bytes.
  std::atomic<bool> stop = false;
  o.force = true, o.stop = &stop;
  o.after_job = [&](size_t) { stop = true; };
  EXPECT_THROW(build_silently(o), Interrupted);
  o.stop = nullptr, o.after_job = {};
  EXPECT_GT(build_silently(o).resumed_jobs, 0u);
  EXPECT_EQ(bytes_of_file(o.output), bytes);
  o.layers = {"gray", "roads"};
  EXPECT_EQ(build_silently(o).layers.size(), 2u) << "--layers leaves landmarks out";
  o.vectors.clear();
  o.gsd_m = 2;
  expect_failure(o, ExitCode::kUsage, {"--layers roads", "1 m or finer", "--vectors"});
}

TEST_F(BuildTest, OfMoreLandmarksThanATileHoldsTheMostDistinctAreKept) {
  std::string trees;
  for (int i = 0; i < 70'000; ++i)
    trees +=
        fmt::format(R"({}{{"type":"Feature","properties":{{"radius_m":{}}},"geometry":{{"type":"Point",)"
                    R"("coordinates":[{},{}]}}}})",
                    i ? "," : "", i == 69'999 ? 40 : 2, 600'100.125 + 5 * (i % 300), 3'499'900.125 - 5 * (i / 300));
  BuildOptions o = options({town()});
  o.layers = {"gray", "landmarks"};
  o.vectors = {{write_text("trees.geojson", R"({"type":"FeatureCollection","crs":{"type":"name","properties":{"name":)"
                                            R"("urn:ogc:def:crs:EPSG::32636"}},"features":[)" +
                                                trees + "]}"),
                {},
                {}}};
  const BuildSummary summary = build_silently(o);
  EXPECT_EQ(summary.features, std::vector<std::string>{"landmarks: 65536 trees"});
  EXPECT_TRUE(std::ranges::any_of(summary.warnings, [](const std::string& warning) {
    return warning.find("65536 of 70000 landmarks are kept") != std::string::npos;
  })) << fmt::format("{}", fmt::join(summary.warnings, "; "));
  const auto pack = Pack::open(o.output.c_str());
  ASSERT_TRUE(pack) << pack.text();
  EXPECT_TRUE(pack->verify(true));
}

TEST_F(BuildTest, GivesTheSameBytesFromAnotherFolder) {
  BuildOptions here = options({town()});
  here.layers.clear();
  build_silently(here);
  fs::create_directories(folder_ / "elsewhere");
  fs::copy(town(), folder_ / "elsewhere" / "town.tif");
  BuildOptions there = options({folder_ / "elsewhere" / "town.tif"}, "elsewhere/other.lfpack");
  there.layers.clear();
  build_silently(there);
  EXPECT_EQ(bytes_of_file(folder_ / "out.lfpack"), bytes_of_file(folder_ / "elsewhere/other.lfpack"));
}

// 6 jobs make the tiles at 1 m, the others those at 2 m and the coarser levels. The kills fall among the first, among
// the halved levels and among the last.
TEST_F(BuildTest, ContinuesAfterAKillAndGivesTheSameBytes) {
  BuildOptions undisturbed = town_with_hills("undisturbed.lfpack");
  undisturbed.layers.clear();
  size_t jobs = 0;
  undisturbed.after_job = [&](size_t done) { jobs = done; };
  build_silently(undisturbed);
  for (const size_t survived : {size_t(4), size_t(9), jobs - 15}) {
    BuildOptions o = town_with_hills();
    const std::string program = fs::read_symlink("/proc/self/exe").string();
    const int status = std::system(fmt::format("exec '{}' --killed-after {} '{}' '{}' '{}'", program, survived,
                                               town().string(), hills().string(), o.output.string())
                                       .c_str());
    ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) << status;
    EXPECT_FALSE(fs::exists(o.output));
    EXPECT_TRUE(fs::exists(journal()));
  }
  BuildOptions last = town_with_hills();
  last.layers.clear();
  const BuildSummary summary = build_silently(last);
  EXPECT_EQ(summary.resumed_jobs, jobs - 2);  // 4, 9 and jobs - 15 of the runs before
  EXPECT_EQ(bytes_of_file(folder_ / "out.lfpack"), bytes_of_file(undisturbed.output));
  EXPECT_FALSE(fs::exists(journal()));
}

TEST_F(BuildTest, StartsOverWhereAParameterChanged) {
  BuildOptions stopped = options({town()});
  stopped.after_job = [](size_t) { throw Error(ExitCode::kIo, "stop"); };
  expect_failure(stopped, ExitCode::kIo, {"stop"});
  BuildOptions other = options({town()});
  other.jpeg_quality = 50;
  EXPECT_EQ(build_silently(other).resumed_jobs, 0u);
}

TEST_F(BuildTest, LeavesOnlyTheJournalWhenItFailsAndSaysHowToContinue) {
  BuildOptions failing = options({town()});
  failing.after_job = [](size_t done) {
    if (done == 3) throw Error(ExitCode::kIo, "the cable was pulled");
  };
  expect_failure(failing, ExitCode::kIo, {"the cable was pulled", journal().string(), "the same command continues"});
  EXPECT_TRUE(fs::exists(journal()));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 2);  // the image and the journal
  EXPECT_EQ(build_silently(options({town()})).resumed_jobs, 3u);
}

TEST_F(BuildTest, StopsWhenAskedToAndContinues) {
  std::atomic<bool> stop = false;
  BuildOptions stopped = options({town()});
  stopped.threads = 1;
  stopped.stop = &stop;
  stopped.after_job = [&](size_t done) { stop = done == 2; };
  Progress silent;
  EXPECT_THROW(build(stopped, silent), Interrupted);
  EXPECT_FALSE(fs::exists(stopped.output));
  EXPECT_GE(build_silently(options({town()})).resumed_jobs, 2u);
}

// A limit on the size of files stands for a full disk. The spool of this image needs 48 · 64 KiB for the base level
// alone.
TEST_F(BuildTest, FailsCleanlyOnAFullDisk) {
  const BuildOptions o = options({town()});
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto previous = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{2'000'000, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
  expect_failure(o, ExitCode::kIo, {"tiles.spool", "free space", "the same command continues"});
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, previous);
  EXPECT_FALSE(fs::exists(o.output));
  EXPECT_FALSE(fs::exists(o.output.string() + ".part"));
  EXPECT_GT(build_silently(o).resumed_jobs, 0u);
}

TEST_F(BuildTest, KeepsASecondBuildAwayFromTheSameOutput) {
  const catalog::Catalog held(journal(), "another build");
  expect_failure(options({town()}), ExitCode::kIo, {journal().string(), "another build"});
}

TEST_F(BuildTest, ReplacesAPackOnlyByForce) {
  BuildOptions o = options({town()});
  std::ofstream(o.output) << "precious";
  expect_failure(o, ExitCode::kUsage, {o.output.string(), "--force"});
  EXPECT_EQ(fs::file_size(o.output), 8u);
  EXPECT_FALSE(fs::exists(journal()));
  o.force = true;
  build_silently(o);
  EXPECT_TRUE(Pack::open(o.output.c_str()));
}

// The newer image covers the western half and has a hole; the older one all.
TEST_F(BuildTest, ShowsTheNewestDateThatHasData) {
  const auto hole = [](int x, int y) { return x > 50 && x < 90 && y > 50 && y < 90; };
  const fs::path old_image = write("old.tif", image(0, 0, 600, 300, [](int, int) { return 40; }));
  const fs::path new_image =
      write("new.tif", image(0, 0, 300, 300, [hole](int x, int y) { return hole(x, y) ? 0 : 90; }));
  BuildOptions o = options({old_image, new_image});
  o.images[0].date = "2009-08-18";
  o.images[1].date = "2018-07-16";
  build_silently(o);
  const auto pack = Pack::open(o.output.c_str());
  ASSERT_TRUE(pack);
  const cv::Mat gray = read_gray(*pack, 0, 0, 600, 300);
  EXPECT_EQ(gray.at<uint8_t>(10, 10), 90);
  EXPECT_EQ(gray.at<uint8_t>(70, 70), 40);
  EXPECT_EQ(gray.at<uint8_t>(10, 299), 90);
  EXPECT_EQ(gray.at<uint8_t>(10, 300), 40);
  ASSERT_EQ(pack->info().source_count, 2u);
  EXPECT_STREQ(pack->source(0)->capture_date, "2009-08-18");
}

TEST_F(BuildTest, StoresEqualTilesOnce) {
  // 8 x 8 whole tiles: easting 600064 is 2344 and northing 3499776 is 13671 times 256.
  const fs::path lake = write("lake.tif", image(64, 224, 2048, 2048, [](int, int) { return 77; }));
  BuildOptions o = options({lake});
  o.layers = {"gray"};
  const BuildSummary summary = build_silently(o);
  EXPECT_EQ(summary.layers[0].levels[0].tiles, 64u);
  EXPECT_GE(summary.tiles - summary.stored_tiles, 63u);
  EXPECT_LT(summary.file_bytes, 64u * 65536u / 2);
}

TEST_F(BuildTest, HeightsComeBackToTheCentimetre) {
  build_silently(town_with_hills());
  const auto pack = Pack::open((folder_ / "out.lfpack").c_str());
  ASSERT_TRUE(pack);
  // At the centre of the DEM's pixel (column 500, row 400): 200 + (300 + 200) / 16 = 231, cut off, as at its
  // neighbours.
  const auto height = pack->height(kWest - 200 + 2 * 500 + 1, kNorth + 200 - 2 * 400 - 1);
  ASSERT_TRUE(height);
  EXPECT_TRUE(height->from_layer);
  EXPECT_NEAR(height->height_m, 231, 0.02);
}

TEST_F(BuildTest, StoresOnlyTilesThatTheAreaTouches) {
  // Eastings 599963 to 601763 touch the columns 2343 to 2350 of tiles, northings 3498689 to 3499989 the rows 13666 to
  // 13671.
  EXPECT_EQ(build_silently(options({town()}, "all.lfpack")).layers[0].levels[0].tiles, 8u * 6u);
  // A box of 100 m around the corner of four tiles at easting 601088 and northing 3499008.
  const auto pack = Pack::open((folder_ / "all.lfpack").c_str());
  ASSERT_TRUE(pack);
  const auto south_west = pack->geodetic_from_grid(601'038, 3'498'958),
             north_east = pack->geodetic_from_grid(601'138, 3'499'058);
  ASSERT_TRUE(south_west && north_east);
  constexpr double kDegrees = 180 / std::numbers::pi;
  BuildOptions o = options({town()});
  o.layers = {"gray", "edge", "orientation"};
  o.bbox = fmt::format("{},{},{},{}", south_west->longitude_rad * kDegrees, south_west->latitude_rad * kDegrees,
                       north_east->longitude_rad * kDegrees, north_east->latitude_rad * kDegrees);
  for (const LayerSummary& layer : build_silently(o).layers) {
    EXPECT_EQ(layer.levels[0].tiles, 4u) << layer.name;
    EXPECT_EQ(layer.levels.size(), 1u) << layer.name;  // the area is no larger than a tile
  }
  // Tiles are stored whole: what a tile shows does not depend on the area.
  const auto part = Pack::open(o.output.c_str());
  ASSERT_TRUE(part);
  EXPECT_EQ(part->info().west_m, 600'832);  // 2347 tiles of 256 m
  const cv::Mat gray = read_gray(*part, 832, 992 - 256, 512, 512);
  EXPECT_EQ(cv::countNonZero(gray != read_gray(*pack, 832, 992 - 256, 512, 512)), 0);
  EXPECT_EQ(gray.at<uint8_t>(0, 0), texture(832, 992 - 256));
}

// What the town shows at 2^level metres, by the definition: gray values, 0 where fewer than two of four have data.
cv::Mat halved_town(int level, int column, int row, int width, int height) {
  cv::Mat out(height, width, CV_8UC1);
  if (level == 0) {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const int c = column + x, r = row + y;
        out.at<uint8_t>(y, x) = c >= -37 && c < 1763 && r >= 11 && r < 1311 ? uint8_t(texture(c, r)) : uint8_t(0);
      }
    return out;
  }
  const cv::Mat fine = halved_town(level - 1, 2 * column, 2 * row, 2 * width, 2 * height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      int sum = 0, count = 0;
      for (int i = 0; i < 4; ++i)
        if (const int v = fine.at<uint8_t>(2 * y + i / 2, 2 * x + i % 2)) sum += v, ++count;
      out.at<uint8_t>(y, x) = count < 2 ? uint8_t(0) : uint8_t((sum + count / 2) / count);
    }
  return out;
}

TEST_F(BuildTest, MakesEveryLevelOfEdgesAndContoursFromTheSources) {
  BuildOptions o = options({town()});
  o.layers = {"edge", "contour"};
  o.codecs = {{"edge", Codec::kRaw}, {"contour", Codec::kRaw}};  // to read without preparing
  build_silently(o);
  const auto pack = Pack::open(o.output.c_str());
  ASSERT_TRUE(pack) << pack.text();
  ASSERT_TRUE(pack->verify(true));
  for (int level = 0; level <= 3; ++level) {
    const int side = 1 << level;
    const cv::Rect part(-40 / side, 8 / side, 1808 / side, 1308 / side);  // the image and a little more
    const cv::Mat gray = halved_town(level, part.x, part.y, part.width, part.height);
    cv::Mat edges, mask, known, distance;
    features::edge(gray, gray, edges);
    features::contours(gray, gray, {}, mask, known);
    features::contour_distance(mask, known, {}, distance);
    const auto read = [&](const char* layer) {
      return read_bytes(*pack, layer, side, part.x, part.y, part.width, part.height);
    };
    EXPECT_EQ(cv::countNonZero(read("edge") != edges), 0) << level;
    EXPECT_EQ(cv::countNonZero(read("contour") != distance), 0) << level;
    EXPECT_GT(cv::countNonZero(edges), gray.rows * gray.cols * 9 / 10) << level;
  }
}

TEST_F(BuildTest, FusesTheDatesAndSaysWhichWentIntoATile) {
  const BuildOptions o = two_dates();
  const BuildSummary summary = build_silently(o);
  ASSERT_EQ(summary.layers.size(), 8u);  // with `agreement`, without heights
  const auto pack = Pack::open(o.output.c_str());
  ASSERT_TRUE(pack) << pack.text();
  ASSERT_TRUE(pack->verify(true));
  EXPECT_EQ(pack->info().epoch_count, 2u);
  EXPECT_STREQ(pack->epoch(0)->date, "2018-07-16");
  const auto epochs = [&](const char* layer, int level, int column) {
    std::vector<uint16_t> out(8);
    const int side = 256 << level;
    const auto count = pack->tile_epochs(*pack->find_layer(layer), level, int((kWest + column) / side),
                                         int((kNorth - 300) / side), out);
    EXPECT_TRUE(count) << count.text();
    out.resize(count ? *count : 0);
    return out;
  };
  using Set = std::vector<uint16_t>;
  for (const int level : {0, 1}) {
    EXPECT_EQ(epochs("orientation", level, 200), (Set{0, 1}));
    EXPECT_EQ(epochs("gray", level, 200), (Set{0}));  // the newest hides the other
    EXPECT_EQ(epochs("orientation", level, 1200), (Set{1}));
    EXPECT_EQ(epochs("edge", level, 1200), (Set{1}));
  }
  EXPECT_EQ(epochs("agreement", 2, 200), (Set{0, 1}));
}

TEST_F(BuildTest, MakesAgreementOnlyOfTwoDates) {
  BuildOptions o = options({town()});
  o.layers = {"agreement"};
  expect_failure(o, ExitCode::kUsage, {"agreement", "2 dates", "--date"});
}

TEST_F(BuildTest, KnowsSetsOfLayers) {
  BuildOptions o = two_dates();
  o.set = "standard";
  o.elevation = ingest::SourceOptions{hills().string(), {}, {}, "ellipsoid"};
  const BuildSummary summary = build_silently(o);
  std::map<std::string, Codec> made;
  for (const LayerSummary& layer : summary.layers) made[layer.name] = layer.codec;
  EXPECT_EQ(made, (std::map<std::string, Codec>{{"gray", Codec::kJpeg},
                                                {"overview", Codec::kJpeg},
                                                {"contour", Codec::kZstd},
                                                {"orientation", Codec::kContext},
                                                {"agreement", Codec::kZstd},
                                                {"height", Codec::kZstd},
                                                {"landmarks", Codec::kVector},
                                                {"roads", Codec::kVector}}));
  EXPECT_TRUE(Pack::open(o.output.c_str())->verify(true));
  BuildOptions both = two_dates("both.lfpack");
  both.set = "standard";
  both.layers = {"gray"};
  expect_failure(both, ExitCode::kUsage, {"--set", "--layers"});
  both.set = "tiny";
  both.layers.clear();
  expect_failure(both, ExitCode::kUsage, {"tiny", "all, standard"});
}

// The older image says that it lies 3 m further east than it does.
TEST_F(BuildTest, MeasuresShiftsAndRemovesThemWhenAskedTo) {
  const auto blocks = [](int x, int y) { return texture(x / 7 + 500, y / 7 + 500); };
  BuildOptions o = options({write("new.tif", image(0, 0, 500, 500, blocks)),
                            write("old.tif", image(0, 0, 500, 500, [=](int x, int y) { return blocks(x - 3, y); }))});
  o.images[0].date = "2018-07-16";
  o.images[1].date = "2009-08-18";
  const auto parameter = [&] {
    const auto pack = Pack::open(o.output.c_str());
    for (uint32_t i = 0; i < pack->info().parameter_count; ++i)
      if (const auto p = pack->parameter(i); p->first == "shift.old.tif") return std::string(p->second);
    return std::string();
  };
  const BuildSummary measured = build_silently(o);
  ASSERT_EQ(measured.shifts.size(), 1u);
  EXPECT_EQ(measured.shifts[0].image, "old.tif");
  EXPECT_NEAR(measured.shifts[0].alignment.east_m, 3, 0.1);
  EXPECT_NEAR(measured.shifts[0].alignment.north_m, 0, 0.1);
  EXPECT_FALSE(measured.shifts[0].removed);
  EXPECT_NE(parameter().find("m east"), std::string::npos) << parameter();
  EXPECT_EQ(parameter().find("removed"), std::string::npos);
  o.align = true;
  o.force = true;
  o.layers = {"agreement"};
  o.codecs = {{"agreement", Codec::kRaw}};
  EXPECT_TRUE(build_silently(o).shifts[0].removed);
  EXPECT_NE(parameter().find("removed"), std::string::npos) << parameter();
  const auto pack = Pack::open(o.output.c_str());
  EXPECT_LE(pack->info().west_m, kWest - 2);
  // On the same ground at last: the dates agree.
  const auto layer = pack->find_layer("agreement");
  const auto region = pack->box(*layer, kWest + 100, kNorth - 300, kWest + 300, kNorth - 100, 4);
  cv::Mat both(int(region->height), int(region->width), CV_8UC2), agreement;
  ASSERT_EQ(pack->read(*region, {both.data, both.total() * 2}, both.step), LF_OK);
  cv::extractChannel(both, agreement, 0);
  EXPECT_GT(cv::mean(agreement)[0], 245);
}

// Three images of one name, in folders of their own: the second and the third lie 3 m and 5 m too far east.
TEST_F(BuildTest, TellsImagesOfOneNameApart) {
  const auto blocks = [](int x, int y) { return texture(x / 7 + 500, y / 7 + 500); };
  BuildOptions o = options({});
  for (const auto& [folder, shift_m, date] :
       {std::tuple("a", 0, "2018-07-16"), std::tuple("b", 3, "2014-07-16"), std::tuple("c", 5, "2009-08-18")}) {
    fs::create_directories(path(folder));
    const fs::path file =
        write(std::string(folder) + "/ortho.tif",
              image(0, 0, 500, 500, [&, shift = shift_m](int x, int y) { return blocks(x - shift, y); }));
    o.images.push_back({.path = file.string(), .date = date, .nodata = 255});
  }
  const BuildSummary summary = build_silently(o);
  ASSERT_EQ(summary.shifts.size(), 2u);
  EXPECT_EQ(summary.shifts[0].image, "ortho.tif#2");
  EXPECT_EQ(summary.shifts[1].image, "ortho.tif#3");
  EXPECT_NEAR(summary.shifts[1].alignment.east_m, 5, 0.1);
  const auto pack = Pack::open(o.output.c_str());
  std::map<std::string, std::string> parameters;
  for (uint32_t i = 0; i < pack->info().parameter_count; ++i) {
    const auto p = pack->parameter(i);
    EXPECT_TRUE(parameters.emplace(p->first, p->second).second) << p->first << " stands there twice";
    EXPECT_EQ(std::string(p->second).find(folder_.string()), std::string::npos) << p->second;
  }
  EXPECT_NE(parameters["shift.ortho.tif#2"].find("lies 3.0"), std::string::npos) << parameters["shift.ortho.tif#2"];
  EXPECT_NE(parameters["shift.ortho.tif#3"].find("by comparison with ortho.tif ("), std::string::npos)
      << parameters["shift.ortho.tif#3"];
  EXPECT_EQ(parameters["nodata.ortho.tif"], "255");
  EXPECT_EQ(parameters["nodata.ortho.tif#3"], "255");
}

TEST_F(BuildTest, RefusesADemThatDoesNotOverlap) {
  BuildOptions o = options({town()});
  o.elevation = ingest::SourceOptions{
      write("far.tif", dem(90'000, 0, 50, 50, [](int, int) { return 100; })), {}, {}, "ellipsoid"};
  expect_failure(o, ExitCode::kNoData, {"far.tif"});
  EXPECT_FALSE(fs::exists(o.output));
  EXPECT_FALSE(fs::exists(journal()));
}

TEST_F(BuildTest, RefusesADemOfUnknownDatum) {
  BuildOptions o = options({town()});
  o.elevation = ingest::SourceOptions{hills().string(), {}, {}, {}};
  expect_failure(o, ExitCode::kBadInput, {"hills.tif", "--dem-datum"});
}

TEST_F(BuildTest, RefusesAnAreaWithoutData) {
  const BuildOptions o = options({write("empty.tif", image(0, 0, 300, 300, [](int, int) { return 0; }))});
  expect_failure(o, ExitCode::kBadInput, {"no data"});
  EXPECT_FALSE(fs::exists(o.output));
  EXPECT_FALSE(fs::exists(journal()));
}

TEST_F(BuildTest, RefusesOptionsThatItCannotServe) {
  const auto refuses = [&](ExitCode code, const std::string& word, const std::function<void(BuildOptions&)>& change) {
    BuildOptions o = options({town()});
    change(o);
    expect_failure(o, code, {word});
  };
  refuses(ExitCode::kUsage, "image", [](BuildOptions& o) { o.images.clear(); });
  refuses(ExitCode::kUsage, "nearest is 0.5", [](BuildOptions& o) { o.gsd_m = 0.6; });
  refuses(ExitCode::kUsage, "gray, overview, edge, contour, orientation, agreement, height",
          [](BuildOptions& o) { o.layers = {"grey"}; });
  refuses(ExitCode::kUsage, "--dem", [](BuildOptions& o) { o.layers = {"height"}; });
  refuses(ExitCode::kUsage, "no such layer", [](BuildOptions& o) { o.codecs["grey"] = Codec::kRaw; });
  refuses(ExitCode::kUsage, "--codec orientation=raw: this layer is not built; built are gray, overview",
          [](BuildOptions& o) { o.codecs["orientation"] = Codec::kRaw; });
  refuses(ExitCode::kUsage, "--codec height=zstd: this layer is not built, it needs heights; give them with --dem",
          [](BuildOptions& o) { o.layers.clear(), o.codecs["height"] = Codec::kZstd; });
  refuses(ExitCode::kUsage,
          "gray=context: context needs pixels of single bits, as orientation has them; expected one "
          "of raw, jpeg, zstd",
          [](BuildOptions& o) { o.codecs["gray"] = Codec::kContext; });
  refuses(ExitCode::kUsage,
          "orientation=jpeg: jpeg needs 8-bit pixels of 1 or 3 channels; expected one of raw, zstd, "
          "context",
          [](BuildOptions& o) { o.layers = {"orientation"}, o.codecs["orientation"] = Codec::kJpeg; });
  refuses(ExitCode::kUsage, "1 to 100", [](BuildOptions& o) { o.jpeg_quality = 0; });
  refuses(ExitCode::kUsage, "0 or more", [](BuildOptions& o) { o.georegistration_error_m = -1.0; });
  refuses(ExitCode::kUsage, "at most one", [](BuildOptions& o) { o.bbox = "1,2,3,4", o.area_file = "a.geojson"; });
  refuses(ExitCode::kIo, "missing.geojson", [](BuildOptions& o) { o.area_file = "missing.geojson"; });
}

TEST_F(BuildTest, EncodesLayersAsAsked) {
  BuildOptions o = town_with_hills();
  o.codecs = {{"gray", Codec::kJpeg}, {"height", Codec::kZstd}, {"overview", Codec::kZstd}};
  build_silently(o);
  const auto pack = Pack::open(o.output.c_str());
  ASSERT_TRUE(pack);
  EXPECT_TRUE(pack->verify(true));
  BuildOptions wrong = town_with_hills("wrong.lfpack");
  wrong.codecs = {{"height", Codec::kJpeg}};
  expect_failure(wrong, ExitCode::kUsage, {"height=jpeg"});
}

TEST(ProgressTest, WritesPlainLinesWhereThereIsNoTerminal) {
  std::FILE* file = std::tmpfile();
  ASSERT_NE(file, nullptr);
  Progress progress = Progress::to(file);
  progress.begin("tiles", "Mpx", 100);
  progress.advance(99);  // within the first second: no line yet
  progress.say("warning: something");
  progress.end();
  std::rewind(file);
  std::string text(1000, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file));
  std::fclose(file);
  EXPECT_EQ(text.find("warning: something\ntiles: 100 %, "), 0u) << text;
  EXPECT_NE(text.find("Mpx/s"), std::string::npos) << text;
  EXPECT_EQ(text.find('\r'), std::string::npos);
}

TEST(ProgressTest, DrawsABarOnATerminalAndClearsItForMessages) {
  std::FILE* file = std::tmpfile();
  ASSERT_NE(file, nullptr);
  Progress progress(file, Progress::Style::kBar);
  progress.begin("tiles", "Mpx", 100);
  progress.skip(40);  // done by an earlier run
  progress.advance(20);
  progress.say("a message");
  std::rewind(file);
  std::string text(1000, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file));
  std::fclose(file);
  EXPECT_NE(text.find("[##################............] 60 %"), std::string::npos) << text;  // 18 of 30
  EXPECT_NE(text.find(" left\r\033[Ka message\n"), std::string::npos) << text;
}

// The process that ContinuesAfterAKill kills: --killed-after JOBS IMAGE DEM OUTPUT.
void build_and_die(char** arguments) {
  BuildOptions o;
  o.images = {{arguments[1], {}, {}, {}}};
  o.elevation = ingest::SourceOptions{arguments[2], {}, {}, "ellipsoid"};
  o.output = arguments[3];
  o.threads = 2;
  o.after_job = [jobs = std::stoul(arguments[0])](size_t done) {
    if (done == jobs) std::raise(SIGKILL);
  };
  Progress silent;
  build(o, silent);
}

}  // namespace
}  // namespace landfix

int main(int argc, char** argv) {
  if (argc == 6 && std::string(argv[1]) == "--killed-after") {
    landfix::build_and_die(argv + 2);
    return 0;
  }
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
