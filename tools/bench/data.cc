#include "tools/bench/data.h"

#include <cpl_error.h>
#include <fmt/format.h>
#include <gdal_priv.h>

#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "builder/error.h"
#include "runtime/features/gray.h"
#include "tools/bench/process.h"
#include "tools/common/files.h"
#include "tools/common/grid_image_io.h"
#include "tools/synth/world.h"

namespace landfix::bench {
namespace {

namespace fs = std::filesystem;

// No multiple of the tile size and, against 256, with a common divisor of only 4: tiles repeat every 64 periods, which
// is never.
constexpr int kPeriod_m = 3100;
constexpr double kHeightGsd_m = 2;

// Against 256 with a common divisor of only 4, as above.
constexpr int kSeasonsSide_m = 2100;
struct Season {
  const char* name;
  int year;
  synth::Season season;
  double sun_azimuth_deg, sun_elevation_deg;
};
constexpr Season kMapSeasons[] = {{"spring", 2018, synth::Season::kSpring, 150, 45},
                                  {"summer", 2019, synth::Season::kSummer, 165, 55},
                                  {"autumn", 2020, synth::Season::kAutumn, 200, 35}};
constexpr Season kCameraSeason = {"camera", 2022, synth::Season::kSummer, 230, 40};

/// What the files depend on.
nlohmann::json parameters_of(const Options& o) {
  return {{"size_px", o.size_px}, {"period_m", kPeriod_m}, {"height_gsd_m", kHeightGsd_m}, {"format", 2}};
}

/// Empties the folder where it holds data of other parameters.
void open_folder(const Options& o) {
  fs::create_directories(o.work);
  const fs::path file = o.work / "parameters.json";
  const std::string wanted = parameters_of(o).dump() + "\n";
  std::ifstream in(file);
  if (std::string(std::istreambuf_iterator<char>(in), {}) == wanted) return;
  for (const char* name : {"world", "gray.tif", "rgb.vrt", "gray.vrt", "heights.vrt", "map.lfpack", "raw.tif",
                           "cog.tif", "map.mbtiles", "seasons"})
    fs::remove_all(o.work / name);
  tools::write_text(file.string(), wanted);
}

/// The gray values of an RGB file, read with GDAL alone: what a pack of the file must hold.
void write_gray(const fs::path& rgb, const fs::path& gray, const tiles::Zone& zone) {
  const GDALDatasetUniquePtr data(GDALDataset::Open(rgb.c_str(), GDAL_OF_RASTER | GDAL_OF_VERBOSE_ERROR));
  double transform[6];
  if (!data || data->GetGeoTransform(transform) != CE_None)
    throw Error(ExitCode::kIo, rgb.string() + ": " + CPLGetLastErrorMsg());
  const int width = data->GetRasterXSize(), height = data->GetRasterYSize();
  features::GridImage image{cv::Mat(height, width, CV_8UC3), {}, transform[0], transform[3], transform[1]};
  if (data->RasterIO(GF_Read, 0, 0, width, height, image.pixels.data, width, height, GDT_Byte, 3, nullptr, 3, 3 * width,
                     1, nullptr) != CE_None)
    throw Error(ExitCode::kIo, rgb.string() + ": " + CPLGetLastErrorMsg());
  image.pixels = features::gray_from_rgb(image.pixels);
  tools::write_grid_image(gray.string(), image, zone);
}

using Command = std::vector<std::string>;

/// Makes `file` under another name, so that a run that was killed leaves nothing that looks finished. `commands`: what
/// to run, from the name to write to.
void make(const fs::path& file, const std::function<std::vector<Command>(const std::string& part)>& commands) {
  if (fs::exists(file)) return;
  say("making " + file.string());
  const fs::path part = file.parent_path() / ("part_" + file.filename().string());
  fs::remove(part);
  for (const Command& command : commands(part)) run(command, file.string() + ".log");
  fs::rename(part, file);
}

void make_world(const fs::path& folder) {
  const fs::path world = folder / "world", gray = folder / "gray.tif";
  synth::WorldOptions o;
  o.size_m = kPeriod_m;
  o.gsd_m = 1;
  o.dem_gsd_m = kHeightGsd_m;
  if (!fs::exists(world / "ortho.tif")) {
    say("drawing " + world.string());
    synth::write_world(o, world);
  }
  if (!fs::exists(gray)) write_gray(world / "ortho.tif", gray, {o.zone, !o.south});
}

fs::path draw(const Season& season, const fs::path& folder) {
  synth::WorldOptions o;
  o.seed = 2;
  o.size_m = kSeasonsSide_m;
  o.gsd_m = 1;
  o.dem_gsd_m = kHeightGsd_m;
  o.season = season.season;
  o.year = season.year;
  o.sun_azimuth_deg = season.sun_azimuth_deg;
  o.sun_elevation_deg = season.sun_elevation_deg;
  const fs::path world = folder / season.name, ortho = world / "ortho.tif";
  if (!fs::exists(ortho)) {
    say("drawing " + world.string());
    synth::write_world(o, world);
  }
  return ortho;
}

bool is_newer(const fs::path& file, const fs::path& than) {
  return fs::exists(file) && fs::last_write_time(file) > fs::last_write_time(than);
}

}  // namespace

void say(const std::string& text) { fmt::print(stderr, "landfix_bench: {}\n", text); }

void repeat(const fs::path& source, int width_px, int height_px, const fs::path& output) {
  run({LANDFIX_REPEAT_SCRIPT, source, std::to_string(width_px), std::to_string(height_px), output},
      output.string() + ".log");
}

Data make_data(const Options& o) {
  open_folder(o);
  make_world(o.work);
  const Data d{o.work / "rgb.vrt", o.work / "heights.vrt", o.work / "map.lfpack",
               o.work / "raw.tif", o.work / "cog.tif",     o.work / "map.mbtiles"};
  const fs::path gray = o.work / "gray.vrt";
  const int height_px = int(o.size_px / kHeightGsd_m);
  repeat(o.work / "world/ortho.tif", o.size_px, o.size_px, d.rgb);
  repeat(o.work / "gray.tif", o.size_px, o.size_px, gray);
  repeat(o.work / "world/dsm.tif", height_px, height_px, d.heights);

  if (!is_newer(d.pack, o.landfix)) fs::remove(d.pack);
  using Commands = std::vector<Command>;
  make(d.pack, [&](const std::string& part) -> Commands {
    return {{o.landfix, "build", d.rgb, "--dem", d.heights, "--dem-datum", "ellipsoid", "--layers", kPackLayers, "-o",
             part}};
  });
  make(d.raw, [&](const std::string& part) -> Commands {
    return {{"gdal_translate", "-q", "-co", "TILED=YES", "-co", "BLOCKXSIZE=256", "-co", "BLOCKYSIZE=256", gray, part}};
  });
  make(d.cog, [&](const std::string& part) -> Commands {
    return {{"gdal_translate", "-q", "-of", "COG", "-co", "COMPRESS=JPEG", "-co", "NUM_THREADS=ALL_CPUS", gray, part}};
  });
  make(d.mbtiles, [&](const std::string& part) -> Commands {
    return {{"gdal_translate", "-q", "-of", "MBTILES", "-co", "TILE_FORMAT=JPEG", gray, part},
            {"gdaladdo", "-q", "-r", "average", part}};
  });
  return d;
}

Seasons make_seasons(const Options& o) {
  open_folder(o);
  const fs::path folder = o.work / "seasons";
  Seasons s{{}, draw(kCameraSeason, folder), folder / "map.lfpack"};
  for (const Season& season : kMapSeasons)
    s.images.push_back({draw(season, folder), synth::date_of(season.year, season.season)});
  if (!is_newer(s.pack, o.landfix)) fs::remove(s.pack);
  make(s.pack, [&](const std::string& part) -> std::vector<Command> {
    Command build = {o.landfix, "build", "--layers", "gray,edge,contour,orientation", "-o", part};
    for (const Seasons::Image& image : s.images) build.push_back(image.file);
    return {build};
  });
  return s;
}

}  // namespace landfix::bench
