// The pipeline on drawn GeoTIFFs: what ends up in the pack, and that nothing but the inputs decides about its bytes.
#include "builder/build.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <landfix/landfix.hpp>
#include <numbers>
#include <opencv2/core.hpp>

#include "builder/catalog/catalog.h"
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
    return o;
  }
};

// All gray pixels of a rectangle of 1 m pixels, by the runtime.
cv::Mat read_gray(const Pack& pack, int column, int row, int width, int height) {
  const auto layer = pack.find_layer("gray");
  EXPECT_TRUE(layer) << layer.text();
  const auto region = pack.box(*layer, kWest + column, kNorth - row - height, kWest + column + width, kNorth - row, 1);
  EXPECT_TRUE(region) << region.text();
  cv::Mat out(int(region->height), int(region->width), CV_8UC1);
  EXPECT_EQ(pack.read(*region, {out.data, out.total()}, out.step), LF_OK);
  return out;
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
  BuildOptions one = town_with_hills("one.lfpack"), four = town_with_hills("four.lfpack");
  one.threads = 1;
  four.threads = 4;
  const BuildSummary summary = build_silently(one);
  build_silently(four);
  ASSERT_EQ(summary.layers.size(), 3u);
  EXPECT_EQ(summary.layers[2].levels.front().level, 1);  // heights of 2 m under imagery of 1 m
  EXPECT_EQ(bytes_of_file(one.output), bytes_of_file(four.output));
}

TEST_F(BuildTest, GivesTheSameBytesFromAnotherFolder) {
  build_silently(options({town()}));
  fs::create_directories(folder_ / "elsewhere");
  fs::copy(town(), folder_ / "elsewhere" / "town.tif");
  build_silently(options({folder_ / "elsewhere" / "town.tif"}, "elsewhere/other.lfpack"));
  EXPECT_EQ(bytes_of_file(folder_ / "out.lfpack"), bytes_of_file(folder_ / "elsewhere/other.lfpack"));
}

// 6 jobs make the tiles at 1 m, the others those at 2 m and the coarser levels. The kills fall among the first and
// among the last.
TEST_F(BuildTest, ContinuesAfterAKillAndGivesTheSameBytes) {
  BuildOptions undisturbed = town_with_hills("undisturbed.lfpack");
  size_t jobs = 0;
  undisturbed.after_job = [&](size_t done) { jobs = done; };
  build_silently(undisturbed);
  for (const size_t survived : {size_t(4), jobs - 6}) {
    const BuildOptions o = town_with_hills();
    const std::string program = fs::read_symlink("/proc/self/exe").string();
    const int status = std::system(fmt::format("exec '{}' --killed-after {} '{}' '{}' '{}'", program, survived,
                                               town().string(), hills().string(), o.output.string())
                                       .c_str());
    ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) << status;
    EXPECT_FALSE(fs::exists(o.output));
    EXPECT_TRUE(fs::exists(journal()));
  }
  const BuildSummary summary = build_silently(town_with_hills());
  EXPECT_EQ(summary.resumed_jobs, jobs - 2);  // 4 of the first run and jobs - 6 of the second
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
  o.layers = {"gray"};
  o.bbox = fmt::format("{},{},{},{}", south_west->longitude_rad * kDegrees, south_west->latitude_rad * kDegrees,
                       north_east->longitude_rad * kDegrees, north_east->latitude_rad * kDegrees);
  EXPECT_EQ(build_silently(o).layers[0].levels[0].tiles, 4u);
  // Tiles are stored whole: what a tile shows does not depend on the area.
  const auto part = Pack::open(o.output.c_str());
  ASSERT_TRUE(part);
  EXPECT_EQ(part->info().west_m, 600'832);  // 2347 tiles of 256 m
  const cv::Mat gray = read_gray(*part, 832, 992 - 256, 512, 512);
  EXPECT_EQ(cv::countNonZero(gray != read_gray(*pack, 832, 992 - 256, 512, 512)), 0);
  EXPECT_EQ(gray.at<uint8_t>(0, 0), texture(832, 992 - 256));
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
  refuses(ExitCode::kUsage, "gray, overview, height", [](BuildOptions& o) { o.layers = {"grey"}; });
  refuses(ExitCode::kUsage, "--dem", [](BuildOptions& o) { o.layers = {"height"}; });
  refuses(ExitCode::kUsage, "no such layer", [](BuildOptions& o) { o.codecs["grey"] = Codec::kRaw; });
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
