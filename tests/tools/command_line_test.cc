// The program as its users meet it: the road from images to a flight, and every kind of bad input with its exit code
// and the words that say what to do.
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "schemas/pack_generated.h"
#include "tests/builder/ingest_fixture.h"
#include "tests/pack/draw.h"
#include "tests/pack/patch.h"
#include "tests/pack/small_map.h"

namespace landfix {
namespace {

namespace fs = std::filesystem;
using ingest::Sketch;
using nlohmann::json;
using Bytes = std::vector<uint8_t>;

// Exit codes as docs/command-line.md states them.
constexpr int kDone = 0, kUsage = 2, kBadInput = 3, kBadPack = 4, kUntrusted = 5, kNoData = 6, kIo = 7;

struct Outcome {
  int code = -1;  ///< exit code; minus the signal that killed the program
  std::string out, err;
};

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Runs in the folder; no file may grow beyond the limit.
Outcome run_in(const fs::path& folder, std::vector<std::string> arguments, rlim_t file_limit = RLIM_INFINITY,
               const std::string& out = "") {
  arguments.insert(arguments.begin(), LANDFIX_PROGRAM);
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const std::string out_file = out.empty() ? (folder / "stdout").string() : out, err_file = folder / "stderr";
  const pid_t child = fork();
  if (child == 0) {
    const rlimit limit{file_limit, file_limit};
    const int flags = O_WRONLY | O_CREAT | O_TRUNC;
    if (chdir(folder.c_str()) == 0 && dup2(open(out_file.c_str(), flags, 0600), 1) == 1 &&
        dup2(open(err_file.c_str(), flags, 0600), 2) == 2 && setrlimit(RLIMIT_FSIZE, &limit) == 0)
      execv(LANDFIX_PROGRAM, argv.data());
    _exit(126);
  }
  int status = 0;
  waitpid(child, &status, 0);
  Outcome outcome;
  outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  if (out.empty()) outcome.out = text_of(out_file);
  outcome.err = text_of(err_file);
  return outcome;
}

void expect_words(const std::string& text, const std::vector<std::string>& words) {
  for (const std::string& word : words) EXPECT_NE(text.find(word), std::string::npos) << word << " in: " << text;
}

/// The program says one line: who speaks, and all of these words.
void expect_refusal(const Outcome& outcome, int code, const std::vector<std::string>& words) {
  EXPECT_EQ(outcome.code, code) << outcome.err;
  const size_t last = outcome.err.rfind('\n', outcome.err.size() - 2);
  const std::string line = last == std::string::npos ? outcome.err : outcome.err.substr(last + 1);
  EXPECT_EQ(line.rfind("landfix: ", 0), 0u) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  expect_words(line, words);
}

/// What most tests ask about: a world of 300 m, and the map of it. Zone 33N, south-western corner at 500 km, 5400 km.
struct World {
  tests::TemporaryFolder folder;
  Outcome synth, build;
  World() {
    synth = run_in(folder.file(""), {"synth", "-o", "world", "--size-m", "300", "--gsd", "0.5", "--seed", "5"});
    build = run_in(folder.file(""), build_arguments("map.lfpack"));
  }
  static std::vector<std::string> build_arguments(const std::string& output) {
    return {"build", "world/ortho.tif", "--dem", "world/dtm.tif", "--dem-datum", "ellipsoid", "-o", output};
  }
};

constexpr char kPlace[] = "500150,5000150";  // in the map that draw_map() draws

/// Every test has a folder of its own.
class CommandLine : public ingest::Ingest {
 protected:
  /// A small pack of a gray layer alone, where the pack's contents do not matter: quicker than the world's.
  void draw_map() const { write_pack("map.lfpack", tests::small_pack()); }
  Outcome run(const std::vector<std::string>& arguments, rlim_t file_limit = RLIM_INFINITY) const {
    return run_in(folder_, arguments, file_limit);
  }
  void expect_done(const std::vector<std::string>& arguments) const {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, kDone) << arguments[0] << ": " << outcome.err;
  }
  json json_of(const std::vector<std::string>& arguments) const {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, kDone) << outcome.err;
    return json::parse(outcome.out);
  }
  Bytes bytes(const std::string& name) const { return tests::read_file(folder_ / name); }
  void write_pack(const std::string& name, const Bytes& data) const { tests::write_file(folder_ / name, data); }
  /// All files but those that the test itself makes.
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_))
      if (const std::string name = entry.path().filename(); name != "stdout" && name != "stderr") names.push_back(name);
    std::sort(names.begin(), names.end());
    return names;
  }
};

/// The folder shows the world, and holds a copy of its map.
class WithMap : public CommandLine {
 protected:
  void SetUp() override {
    static const World world;
    CommandLine::SetUp();
    ASSERT_EQ(world.build.code, kDone) << world.synth.err << world.build.err;
    fs::create_symlink(world.folder.file("world"), folder_ / "world");
    fs::copy_file(world.folder.file("map.lfpack"), folder_ / "map.lfpack");
  }
};

/// One band of a raster, as numbers.
struct Band {
  int width, height;
  double geotransform[6];
  std::string crs;
  std::vector<float> values;

  Band(const std::string& path, int band) {
    const GDALDatasetUniquePtr file(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER));
    if (!file) throw std::runtime_error(path);
    width = file->GetRasterXSize(), height = file->GetRasterYSize();
    file->GetGeoTransform(geotransform);
    if (const auto* reference = file->GetSpatialRef())
      if (const char* code = reference->GetAuthorityCode(nullptr)) crs = code;
    values.resize(size_t(width) * size_t(height));
    EXPECT_EQ(file->GetRasterBand(band)->RasterIO(GF_Read, 0, 0, width, height, values.data(), width, height,
                                                  GDT_Float32, 0, 0, nullptr),
              CE_None);
  }
  /// At a place on the grid, pixels being areas.
  float at(double east_m, double north_m) const {
    const auto column = size_t((east_m - geotransform[0]) / geotransform[1]);
    const auto row = size_t((north_m - geotransform[3]) / geotransform[5]);
    return values.at(row * size_t(width) + column);
  }
};

std::string place_of(const json& position) {
  return position["longitude_deg"].dump() + "," + position["latitude_deg"].dump();
}

// --- the road --------------------------------------------------------------------------------------------------------

TEST_F(WithMap, InfoSaysWhatThePackHolds) {
  const json info = json_of({"info", "--json", "map.lfpack"});
  EXPECT_EQ(info["format"], "1.3");
  EXPECT_EQ(info["zone"], "33N");
  EXPECT_EQ(info["epsg"], 32633);
  EXPECT_EQ(info["file_length"], fs::file_size(path("map.lfpack")));
  EXPECT_EQ(info["public_key"], nullptr);
  EXPECT_EQ(info["has_heights"], true);
  const json box = {500'000.0, 5'400'000.0, 500'300.0, 5'400'300.0};  // where synth was told to draw
  EXPECT_EQ(
      json({info["bounds"]["west_m"], info["bounds"]["south_m"], info["bounds"]["east_m"], info["bounds"]["north_m"]}),
      box);
  EXPECT_NEAR(info["bounds"]["west_deg"], 15, 1e-9);  // the middle of zone 33
  std::map<std::string, double> finest_gsd_m;
  for (const json& layer : info["layers"]) finest_gsd_m[layer["name"]] = layer["levels"][0]["gsd_m"];
  // Gray as the image, height as the DTM, overview four times coarser than the image.
  EXPECT_EQ(finest_gsd_m, (std::map<std::string, double>{{"gray", 0.5},
                                                         {"overview", 2},
                                                         {"edge", 0.5},
                                                         {"contour", 0.5},
                                                         {"orientation", 0.5},
                                                         {"height", 1},
                                                         {"landmarks", 8},
                                                         {"roads", 8}}));
  ASSERT_EQ(info["sources"].size(), 2u);
  EXPECT_EQ(info["sources"][0]["capture_date"], "2020-07-15");
  EXPECT_EQ(info["sources"][1]["vertical_datum"], "ellipsoid");
  EXPECT_EQ(info, json_of({"query", "--manifest", "map.lfpack"}));
  expect_words(run({"info", "map.lfpack"}).out, {"grid 33N (EPSG:32633), 300 x 300 m", "2020-07-15", "overview"});

  // And that much is checked.
  size_t tiles = 0;
  for (const json& layer : info["layers"])
    for (const json& level : layer["levels"]) tiles += level["tiles"].get<size_t>();
  const json deep = json_of({"verify", "--deep", "--json", "map.lfpack"});
  EXPECT_EQ(deep["ok"], true);
  EXPECT_EQ(deep["deep"], true);
  EXPECT_EQ(deep["tiles"], tiles);
  EXPECT_EQ(deep["signed"], false);
  EXPECT_EQ(deep["trusted"], false);
}

TEST_F(WithMap, ThreadsLeaveTheBytes) {
  for (const std::string threads : {"1", "2"}) {
    std::vector<std::string> arguments = World::build_arguments("threads" + threads + ".lfpack");
    arguments.insert(arguments.end(), {"--threads", threads});
    expect_done(arguments);
    EXPECT_EQ(bytes("threads" + threads + ".lfpack"), bytes("map.lfpack")) << threads;
  }
}

TEST_F(WithMap, BuildSummaryIsATable) {
  const std::string out = run({"build", "world/ortho.tif", "--layers", "gray,contour,orientation", "--codec",
                               "orientation=context", "-o", "table.lfpack"})
                              .out;
  // Every row has "tiles" at the same column, whatever the names and codecs.
  std::set<size_t> columns;
  std::istringstream lines(out);
  int rows = 0;
  for (std::string line; std::getline(lines, line);)
    if (line.rfind("  ", 0) == 0 && line.find(" tiles ") != std::string::npos && line.find(" m") != std::string::npos &&
        line.find("equal") == std::string::npos)
      columns.insert(line.find(" tiles ")), ++rows;
  EXPECT_EQ(rows, 3) << out;
  EXPECT_EQ(columns.size(), 1u) << out;
}

TEST_F(WithMap, BuildReplacesAPackByForceOnly) {
  const Bytes before = bytes("map.lfpack");
  std::vector<std::string> arguments = {"build", "world/ortho.tif", "-o", "map.lfpack"};
  expect_refusal(run(arguments), kUsage, {"map.lfpack", "exists already", "--force"});
  EXPECT_EQ(bytes("map.lfpack"), before);
  arguments.push_back("--force");
  const Outcome forced = run(arguments);
  EXPECT_EQ(forced.code, kDone);
  expect_words(forced.err, {"no heights", "--dem", "plane"});
  EXPECT_EQ(json_of({"info", "--json", "map.lfpack"})["has_heights"], false);
}

TEST_F(WithMap, QueryGivesTheImageAndTheHeights) {
  const std::string place = "500150.2,5400150.2";  // its region ends within pixels
  const json gray = json_of(
      {"query", "map.lfpack", "--grid", place, "--sigma", "20", "-k", "3", "-o", "gray.tif", "--json"})["region"];
  // 3 sigma of 20 m to each side, pixels of 0.5 m.
  EXPECT_NEAR(gray["width_px"].get<int>(), 240, 1);
  EXPECT_NEAR(gray["height_px"].get<int>(), 240, 1);
  EXPECT_EQ(gray["valid_share"], 1.0);
  const Band tif(path("gray.tif"), 1);
  EXPECT_EQ(tif.crs, "32633");
  EXPECT_EQ(tif.width, gray["width_px"]);
  EXPECT_EQ(tif.geotransform[0], gray["west_m"].get<double>());
  EXPECT_EQ(tif.geotransform[3], gray["north_m"].get<double>());
  // The orthophoto lies on the pack's grid: resampling leaves it as it is, and gray is its luma.
  const Band red(path("world/ortho.tif"), 1), green(path("world/ortho.tif"), 2), blue(path("world/ortho.tif"), 3);
  for (double east = 500'095.25; east < 500'205; east += 10)
    for (double north = 5'400'095.25; north < 5'400'205; north += 10)
      EXPECT_EQ(tif.at(east, north), std::max(1.f, std::floor((299 * red.at(east, north) + 587 * green.at(east, north) +
                                                               114 * blue.at(east, north) + 500) /
                                                              1000)));

  const json answer = json_of(
      {"query", "map.lfpack", "--grid", place, "--layer", "height", "--sigma", "20", "-o", "height.tif", "--json"});
  const Band heights(path("height.tif"), 1), dtm(path("world/dtm.tif"), 1);
  EXPECT_EQ(answer["region"]["gsd_m"], 1.0);
  for (double east = 500'095.5; east < 500'205; east += 10)
    EXPECT_NEAR(heights.at(east, 5'400'160.5), dtm.at(east, 5'400'160.5), 0.006);  // stored in steps of 1 cm
  const json& position = answer["position"];
  EXPECT_NEAR(position["ground_height_m"], dtm.at(500'150.2, 5'400'150.2), 0.5);
  EXPECT_EQ(position["ground_height_from"], "height layer");
  EXPECT_NEAR(position["geoid_undulation_m"], 46.6, 0.5);  // EGM96 there, as GeoidEval says
  EXPECT_NEAR(position["scale"], 0.9996, 1e-6);

  // As longitude and latitude, the same place: the same region.
  const std::string at = place_of(position);
  EXPECT_EQ(json_of({"query", "map.lfpack", "--at", at, "--sigma", "20", "-k", "3", "--json"})["region"], gray);
  expect_done({"query", "map.lfpack", "--at", at, "--sigma", "20", "--layer", "overview", "-o", "overview.png"});
  const Band png(path("overview.png"), 4);
  EXPECT_NEAR(png.width, 60, 1);  // 120 m at 2 m
  EXPECT_EQ(png.values[0], 255);  // opaque where there is data
}

TEST_F(CommandLine, SignedPacksAreTrusted) {
  draw_map();
  expect_done({"keygen", "mission"});
  expect_done({"keygen", "other"});
  expect_refusal(run({"keygen", "mission"}), kBadInput, {"mission.key", "exists already", "another name"});
  EXPECT_EQ(fs::status(path("mission.key")).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  expect_done({"sign", "--key", "mission.key", "map.lfpack", "-o", "signed.lfpack"});
  const json signed_info = json_of({"info", "--json", "signed.lfpack"}),
             info = json_of({"info", "--json", "map.lfpack"});
  EXPECT_EQ(signed_info["root"], info["root"]);
  expect_words(text_of(path("mission.pub")), {signed_info["public_key"].get<std::string>()});
  const json trusted = json_of({"verify", "--json", "--key", "other.pub", "--key", "mission.pub", "signed.lfpack"});
  EXPECT_EQ(trusted["signed"], true);
  EXPECT_EQ(trusted["trusted"], true);
  expect_done({"query", "--key", "mission.pub", "signed.lfpack", "--grid", kPlace});

  // Every command that is given keys refuses what they did not sign.
  const std::string fly[] = {"--scene", "image.tif", "--scene-dem", "world/dtm.tif", "-o", "flight"};
  for (const auto& [key, pack, words] :
       {std::tuple<std::string, std::string, std::vector<std::string>>{
            "mission.pub", "map.lfpack", {"map.lfpack", "no signature", "landfix sign"}},
        {"other.pub", "signed.lfpack", {"signed.lfpack", "none of the trusted keys"}}}) {
    expect_refusal(run({"verify", "--key", key, pack}), kUntrusted, words);
    expect_refusal(run({"info", "--key", key, pack}), kUntrusted, words);
    expect_refusal(run({"query", "--key", key, pack, "--grid", kPlace}), kUntrusted, words);
    std::vector<std::string> flight = {"fly", "--key", key, "--map", pack};
    flight.insert(flight.end(), std::begin(fly), std::end(fly));
    expect_refusal(run(flight), kUntrusted, words);
  }
  Bytes forged = bytes("signed.lfpack");
  tests::Patch patch(forged);
  patch.header().signature[5] ^= 1;
  patch.rehash_page();
  write_pack("forged.lfpack", patch.bytes());
  expect_refusal(run({"verify", "--key", "mission.pub", "forged.lfpack"}), kUntrusted, {"forged.lfpack", "wrong"});

  expect_refusal(run({"verify", "--key", "mission.key", "signed.lfpack"}), kBadInput,
                 {"mission.key", "landfix-public-key"});
  expect_refusal(run({"verify", "--key", "none.pub", "signed.lfpack"}), kIo, {"none.pub"});
}

TEST_F(WithMap, AFlightLeavesATrackAndItsSummary) {
  const Outcome flight = run({"fly",
                              "--map",
                              "map.lfpack",
                              "--scene",
                              "world/ortho.tif",
                              "--scene-dem",
                              "world/dsm.tif",
                              "--scene-dem-datum",
                              "ellipsoid",
                              "--loop",
                              "300",
                              "--agl",
                              "60",
                              "--image-size",
                              "160,120",
                              "--gnss-until",
                              "3",
                              "--json",
                              "-o",
                              "flight"});
  ASSERT_EQ(flight.code, kDone) << flight.err;
  const json summary = json::parse(text_of(path("flight/summary.json")));
  EXPECT_EQ(json::parse(flight.out), summary);
  EXPECT_GT(fs::file_size(path("flight/tracks.png")), 1000u);
  std::istringstream track(text_of(path("flight/track.csv")));
  std::string line, cell;
  std::vector<std::string> names;
  std::getline(track, line);
  for (std::istringstream cells(line); std::getline(cells, cell, ',');) names.push_back(cell);
  double squares = 0, largest = 0, inside = 0, last_error_m = 0, last_drift_m = 0;
  int images = 0, fixes = 0;
  while (std::getline(track, line)) {
    std::map<std::string, std::string> row;
    size_t i = 0;
    for (std::istringstream cells(line); std::getline(cells, cell, ',');) row[names.at(i++)] = cell;
    EXPECT_EQ(row["gnss"] == "1", std::stod(row["time_s"]) < 3);
    if (row["gnss"] == "1") continue;
    last_error_m = std::stod(row["error_m"]);
    last_drift_m = std::stod(row["dead_reckoning_error_m"]);
    EXPECT_NEAR(last_error_m,
                std::hypot(std::stod(row["estimate_east_m"]) - std::stod(row["truth_east_m"]),
                           std::stod(row["estimate_north_m"]) - std::stod(row["truth_north_m"])),
                0.002);
    squares += last_error_m * last_error_m;
    largest = std::max(largest, last_error_m);
    inside += row["inside_3_sigma"] == "1";
    fixes += row["fix_status"] == "fix";
    ++images;
  }
  const json& result = summary["result"];
  ASSERT_GT(images, 20);  // 300 m at 15 m/s, less the 3 s with GNSS, two images a second
  EXPECT_EQ(result["images"], images);
  EXPECT_EQ(result["fixes"], fixes);
  EXPECT_NEAR(result["rms_m"], std::sqrt(squares / images), 0.001);
  EXPECT_NEAR(result["max_m"], largest, 0.001);
  EXPECT_NEAR(result["final_error_m"], last_error_m, 0.001);
  EXPECT_NEAR(result["dead_reckoning_final_error_m"], last_drift_m, 0.001);
  EXPECT_NEAR(result["share_inside_3_sigma"], inside / images, 1e-9);
  EXPECT_LT(largest, 8);  // the camera sees the map's own image; Conte's 8 m are far
}

TEST_F(CommandLine, HelpTeachesWithExamples) {
  const Outcome all = run({"--help"});
  EXPECT_EQ(all.code, kDone);
  for (const std::string command : {"build", "info", "verify", "query", "keygen", "sign", "synth", "fly", "eval"}) {
    expect_words(all.out, {command});
    const Outcome help = run({command, "--help"});
    EXPECT_EQ(help.code, kDone);
    expect_words(help.out, {"Example", "landfix " + command});
  }
  expect_words(all.out, {"fly, evaluate"});
  expect_words(run({"build", "--help"}).out, {"--set standard -o", "--align -o"});
  expect_words(run({"--version"}).out, {"landfix "});
}

// Options that may be repeated must not swallow what stands behind them.
TEST_F(WithMap, OptionsMayComeFirst) {
  expect_done({"keygen", "mission"});
  expect_done({"sign", "--key", "mission.key", "map.lfpack"});
  for (const std::string command : {"info", "verify"}) expect_done({command, "--key", "mission.pub", "map.lfpack"});
  expect_done({"query", "--at", "15.002,48.7545", "--key", "mission.pub", "map.lfpack", "--json"});
  expect_done({"query", "--bbox", "15.001,48.754,15.002,48.755", "map.lfpack"});
  expect_done(
      {"build", "--layers", "gray,overview", "--date", "ortho.tif=2021-05-04", "world/ortho.tif", "-o", "out.lfpack"});
  const json info = json_of({"info", "out.lfpack", "--json"});
  EXPECT_EQ(info["layers"].size(), 2u);
  EXPECT_EQ(info["sources"][0]["capture_date"], "2021-05-04");
}

// --- bad input -------------------------------------------------------------------------------------------------------

TEST_F(CommandLine, ImagesThatCannotBePlacedAreRefused) {
  Sketch nowhere, no_crs, local, rotated;
  nowhere.geotransform[1] = 0;
  nowhere.crs = no_crs.crs = "";
  local.crs = R"(LOCAL_CS["site",UNIT["metre",1]])";
  rotated.geotransform[2] = 0.1;
  write("nowhere.tif", nowhere), write("no_crs.tif", no_crs), write("local.tif", local), write("rotated.tif", rotated);
  const auto before = files();
  const auto build = [&](const std::string& image) { return run({"build", image, "-o", "out.lfpack"}); };
  expect_refusal(build("nowhere.tif"), kBadInput, {"nowhere.tif", "no georeference", "gdal_translate"});
  expect_refusal(build("no_crs.tif"), kBadInput, {"no_crs.tif", "missing", "-a_srs"});
  expect_refusal(build("local.tif"), kBadInput, {"local.tif", "unknown or local", "-a_srs"});
  expect_refusal(build("rotated.tif"), kBadInput, {"rotated.tif", "rotated", "gdalwarp"});
  expect_refusal(build("missing.tif"), kIo, {"missing.tif", "no such file"});
  write_text("text.tif", "hello");
  expect_refusal(build("text.tif"), kBadInput, {"text.tif", "not a raster"});
  fs::remove(path("text.tif"));
  EXPECT_EQ(files(), before);  // no pack, no half pack, nothing to continue
}

TEST_F(CommandLine, HeightsThatCannotBeUsedAreRefused) {
  Sketch far = ingest::slope();
  far.geotransform[0] += 10'000;
  write("image.tif", {}), write("far.tif", far), write("dem.tif", ingest::slope());
  const auto before = files();
  const auto build = [&](std::vector<std::string> dem) {
    dem.insert(dem.begin(), {"build", "image.tif", "-o", "out.lfpack", "--dem"});
    return run(dem);
  };
  expect_refusal(build({"far.tif", "--dem-datum", "egm96"}), kNoData, {"far.tif", "overlap"});
  expect_refusal(build({"dem.tif"}), kBadInput, {"dem.tif", "datum", "--dem-datum"});
  expect_refusal(build({"dem.tif", "--dem-datum", "sealevel"}), kUsage, {"sealevel", "egm96"});
  expect_refusal(build({"none.tif", "--dem-datum", "egm96"}), kIo, {"none.tif", "no such file"});
  EXPECT_EQ(files(), before);
}

TEST_F(WithMap, AFullDiskLeavesNoHalfPackAndABuildThatContinues) {
  const Bytes whole = bytes("map.lfpack");
  const auto before = files();
  // In the first tiles, after some of them, and while the pack itself is written.
  for (const rlim_t limit : {rlim_t(100'000), rlim_t(1'000'000), rlim_t(whole.size() - 4096)}) {
    const Outcome full = run(World::build_arguments("out.lfpack"), limit);
    expect_refusal(full, kIo, {"out.lfpack", "File too large", "free space", "the same command continues"});
    EXPECT_EQ(files(), (std::vector<std::string>{"map.lfpack", "out.lfpack.build", "world"})) << limit;
    const Outcome again = run(World::build_arguments("out.lfpack"));
    EXPECT_EQ(again.code, kDone) << again.err;
    if (limit > 100'000) expect_words(again.err, {"continuing: "});
    EXPECT_EQ(bytes("out.lfpack"), whole) << limit;
    fs::remove(path("out.lfpack"));
    EXPECT_EQ(files(), before);
  }
}

TEST_F(WithMap, WritingThatFailsIsSaid) {
  expect_done({"keygen", "mission"});
  const Bytes whole = bytes("map.lfpack");
  const auto before = files();
  const rlim_t limit = 50'000;
  expect_refusal(run({"sign", "--key", "mission.key", "map.lfpack"}, limit), kIo, {"map.lfpack", "cannot be written"});
  EXPECT_EQ(bytes("map.lfpack"), whole);
  for (const std::string name : {"region.png", "region.tif"})
    expect_refusal(run({"query", "map.lfpack", "--grid", "500150,5400150", "-o", name}, limit), kIo, {name});
  EXPECT_EQ(files(), before);
  expect_refusal(run({"synth", "-o", "drawn", "--size-m", "300", "--gsd", "0.5"}, limit), kIo, {"drawn/"});
  EXPECT_FALSE(fs::exists(path("drawn/ortho.tif")));
  expect_refusal(run_in(folder_, {"info", "map.lfpack"}, RLIM_INFINITY, "/dev/full"), kIo, {"standard output"});
  // So are folders that are not there.
  for (const std::string name : {"none/region.png", "none/region.tif"})
    expect_refusal(run({"query", "map.lfpack", "--grid", "500150,5400150", "-o", name}), kIo, {name});
  expect_refusal(run({"keygen", "none/mission"}), kIo, {"none/mission.key", "No such file"});
}

TEST_F(CommandLine, WhatIsNoPackOrTruncatedIsRefused) {
  write("image.tif", {});
  write_text("text.lfpack", std::string(10'000, 'x'));
  write_text("empty.lfpack", "");
  for (const std::string command : {"info", "verify"}) {
    expect_refusal(run({command, "text.lfpack"}), kBadPack, {"text.lfpack", "not a landfix pack"});
    expect_refusal(run({command, "image.tif"}), kBadPack, {"image.tif", "not a landfix pack"});
    expect_refusal(run({command, "empty.lfpack"}), kBadPack, {"empty.lfpack", "not a landfix pack"});
    expect_refusal(run({command, "none.lfpack"}), kIo, {"none.lfpack", "No such file"});
  }
  draw_map();
  const Bytes whole = bytes("map.lfpack");
  for (const size_t length : {size_t(100), size_t(4096), whole.size() / 2, whole.size() - 1}) {
    write_pack("cut.lfpack", {whole.begin(), whole.begin() + long(length)});
    expect_refusal(run({"verify", "cut.lfpack"}), kBadPack, {"cut.lfpack", "length", "copy it again"});
  }
}

TEST_F(CommandLine, AFlippedByteInAnySectionIsFound) {
  draw_map();
  tests::Patch patch(bytes("map.lfpack"));
  const schema::BlockRecord block = patch.blocks()[0];
  const schema::TileRecord tile = patch.tiles(block)[0];
  const std::map<std::string, size_t> sections = {{"header", 16},
                                                  {"manifest", patch.header().manifest_offset + 50},
                                                  {"block table", patch.header().block_table_offset + 20},
                                                  {"directory", block.offset + 40},
                                                  {"tile data", tile.offset + 1000}};
  expect_done({"keygen", "mission"});
  for (const auto& [section, at] : sections) {
    SCOPED_TRACE(section);
    Bytes flipped = bytes("map.lfpack");
    flipped[at] ^= 1;
    write_pack("flipped.lfpack", flipped);
    expect_refusal(run({"verify", "flipped.lfpack"}), kBadPack, {"flipped.lfpack", "damaged", "copy it again"});
    expect_refusal(run({"sign", "--key", "mission.key", "flipped.lfpack"}), kBadPack, {"flipped.lfpack", "damaged"});
    EXPECT_EQ(bytes("flipped.lfpack"), flipped);
  }
  // The tile's own damage reaches whoever looks at it.
  expect_refusal(run({"query", "flipped.lfpack", "--grid", kPlace, "--sigma", "300"}), kBadPack,
                 {"flipped.lfpack", "damaged"});
}

TEST_F(CommandLine, ANewerMajorVersionIsRefused) {
  draw_map();
  tests::Patch patch(bytes("map.lfpack"));
  patch.header().version_major = 2;
  patch.rehash_header();
  write_pack("newer.lfpack", patch.bytes());
  for (const std::string command : {"info", "verify"})
    expect_refusal(run({command, "newer.lfpack"}), kBadPack, {"newer.lfpack", "newer landfix", "update landfix"});
}

TEST_F(WithMap, ANewerMinorVersionOpensWithoutItsUnknownLayers) {
  tests::Patch patch(bytes("map.lfpack"));
  patch.header().version_minor = 9;
  // A type of pixels that version 1.0 does not know.
  auto* manifest = flatbuffers::GetMutableRoot<schema::Manifest>(patch.manifest().data());
  for (const schema::Layer* layer : *manifest->layers()) {
    if (layer->name()->str() != "height") continue;
    auto* table = reinterpret_cast<flatbuffers::Table*>(const_cast<schema::Layer*>(layer));
    ASSERT_TRUE(table->SetField<uint8_t>(schema::Layer::VT_PIXEL_TYPE, 99, 0));
  }
  patch.rehash_header();
  write_pack("newer.lfpack", patch.bytes());
  const json info = json_of({"info", "--json", "newer.lfpack"});
  EXPECT_EQ(info["format"], "1.9");
  std::vector<std::string> names;
  for (const json& layer : info["layers"]) names.push_back(layer["name"]);
  EXPECT_EQ(names,
            (std::vector<std::string>{"gray", "overview", "edge", "contour", "orientation", "landmarks", "roads"}));
  EXPECT_EQ(info["has_heights"], false);
  expect_done({"verify", "--deep", "newer.lfpack"});
  expect_done({"query", "newer.lfpack", "--grid", "500150,5400150"});
  expect_refusal(run({"query", "newer.lfpack", "--grid", "500150,5400150", "--layer", "height"}), kNoData,
                 {"newer.lfpack", "height", "no such layer", "landfix info"});
}

TEST_F(WithMap, AskingOutsideOfTheMapIsNoData) {
  const auto query = [&](const std::string& option, const std::string& value) {
    return run({"query", "map.lfpack", option, value, "--sigma", "10"});
  };
  const std::vector<std::string> words = {"map.lfpack", "no data there", "landfix info"};
  expect_refusal(query("--grid", "510000,5400150"), kNoData, words);
  expect_refusal(query("--at", "15.1,48.75"), kNoData, words);
  expect_refusal(query("--bbox", "15.1,48.75,15.101,48.751"), kNoData, words);
  expect_refusal(query("--bbox", "1,1,2,2"), kNoData, words);
  expect_refusal(query("--at", "-120,10"), kNoData, {"map.lfpack", "zone 33N", "longitude first"});
  expect_refusal(query("--grid", "1e12,0"), kNoData, {"map.lfpack", "outside"});
  expect_refusal(run({"fly", "--map", "map.lfpack", "--scene", "world/ortho.tif", "--scene-plane", "300", "--center",
                      "15.1,48.75", "--loop", "300", "-o", "flight"}),
                 kNoData, {});
}

TEST_F(CommandLine, NumbersThatAreNoneAreRefused) {
  draw_map();
  const auto query = [&](const std::vector<std::string>& where) {
    std::vector<std::string> arguments = {"query", "map.lfpack"};
    arguments.insert(arguments.end(), where.begin(), where.end());
    return run(arguments);
  };
  const auto with_covariance = [&](const std::string& c) { return query({"--grid", kPlace, "--covariance", c}); };
  for (const std::string c : {"nan,0,1", "1,nan,1", "1,0,inf", "-1,0,1", "1,2,1"})
    expect_refusal(with_covariance(c), kBadInput, {"--covariance " + c, "EE,EN,NN"});
  EXPECT_EQ(with_covariance("100,50,100").code, kDone);
  expect_refusal(query({"--grid", "nan,5000150"}), kBadInput, {"--grid nan", "metres"});
  expect_refusal(query({"--grid", kPlace, "--sigma", "nan"}), kBadInput, {"--sigma nan", "metres"});
  expect_refusal(query({"--at", "48.75,150"}), kBadInput, {"--at 48.75,150", "longitude, then latitude"});
  expect_refusal(query({"--bbox", "15.1,48.75,15,48.8"}), kBadInput, {"--bbox", "west, south, east and north"});
  expect_refusal(run({"synth", "-o", "drawn", "--size-m", "nan"}), kBadInput, {"size_m", "nan"});
}

TEST_F(CommandLine, WrongCommandLinesAreSaid) {
  write("image.tif", {});
  draw_map();
  const auto expect_usage = [&](const std::vector<std::string>& arguments, const std::vector<std::string>& words) {
    expect_refusal(run(arguments), kUsage, words);
  };
  expect_usage({}, {"command", "'landfix --help'"});
  expect_usage({"bild"}, {"bild", "'landfix --help'"});
  expect_usage({"--unknown"}, {"--unknown", "'landfix --help'"});
  expect_usage({"info", "map.lfpack", "--unknown"}, {"--unknown", "'landfix info --help'"});
  expect_usage({"synth", "-o", "drawn", "--unknown"}, {"--unknown", "'landfix synth --help'"});
  expect_usage({"build", "-o", "out.lfpack"}, {"image", "required"});
  expect_usage({"query", "map.lfpack"}, {"--at", "--grid", "--bbox"});
  expect_usage({"query", "map.lfpack", "--grid", kPlace, "-o", "region.jpg"}, {"region.jpg", ".png", ".tif"});
  expect_usage({"build", "image.tif", "--gsd", "0.3", "-o", "out.lfpack"}, {"--gsd 0.3", "powers of two", "0.25"});
  expect_usage({"build", "image.tif", "--codec", "gray=foo", "-o", "out.lfpack"},
               {"--codec gray=foo: expected raw, jpeg, zstd or context"});
  expect_usage({"build", "image.tif", "--date", "other.tif=2020-01-01", "-o", "out.lfpack"}, {"other.tif"});
}

}  // namespace
}  // namespace landfix
