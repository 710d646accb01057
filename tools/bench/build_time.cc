// Building a pack against what else people make of an orthophoto.
#include <fmt/format.h>
#include <gdal_priv.h>

#include <cstdlib>

#include "builder/error.h"
#include "tools/bench/process.h"
#include "tools/bench/sections.h"

namespace landfix::bench {
namespace {

namespace fs = std::filesystem;

struct Image {
  std::string name;
  fs::path file;
  fs::path heights;  ///< metres above the ellipsoid; empty: none
};

double megapixels(const fs::path& image) {
  const GDALDatasetUniquePtr data(GDALDataset::Open(image.c_str(), GDAL_OF_RASTER));
  if (!data) throw Error(ExitCode::kIo, image.string() + ": cannot be opened");
  return double(data->GetRasterXSize()) * data->GetRasterYSize() / 1e6;
}

/// Wall seconds of a program that makes `result`, which is removed before and after.
double time_making(const fs::path& result, const std::vector<std::string>& command) {
  say("timing " + command[0] + " -> " + result.string());
  fs::remove_all(result);
  const double seconds = run(command, result.string() + ".log");
  fs::remove_all(result);
  return seconds;
}

void compare(const Image& image, const Options& o, Report& report) {
  const fs::path pack = o.work / "timed.lfpack", cog = o.work / "timed.tif", tiles = o.work / "timed_tiles";
  std::vector<std::string> build = {o.landfix, "build", image.file, "-o", pack};
  if (image.heights.empty())
    build.insert(build.end(), {"--layers", "gray,overview"});
  else
    build.insert(build.end(), {"--layers", kPackLayers, "--dem", image.heights, "--dem-datum", "ellipsoid"});
  const double t_pack = time_making(pack, build);
  const double t_cog = time_making(cog, {"gdal_translate", "-q", "-of", "COG", "-co", "COMPRESS=JPEG", "-co",
                                         "NUM_THREADS=ALL_CPUS", image.file, cog});
  const double t_tiles = time_making(tiles, {"gdal2tiles.py", "-q", "--processes=2", "-w", "none", image.file, tiles});
  const std::string what = fmt::format("{}, {:.0f} Mpx: ", image.name, megapixels(image.file));
  report.measured(what + "landfix build", t_pack, "s");
  report.measured(what + "gdal_translate -of COG (JPEG)", t_cog, "s");
  report.measured(what + "gdal2tiles.py --processes=2", t_tiles, "s");
  report.measured(what + "landfix faster than the COG", t_cog / t_pack, "x");
  report.at_least(what + "landfix faster than gdal2tiles.py", t_tiles / t_pack, "x", 5);
}

/// RGB and heights from the drawn world, the RGB as one uncompressed file: what all programs read at the least cost.
Image drawn_image(const Options& o) {
  const fs::path vrt = o.work / "timed_rgb.vrt", heights = o.work / "timed_heights.vrt", rgb = o.work / "timed_rgb.tif";
  repeat(o.work / "world/ortho.tif", o.build_size_px, o.build_size_px, vrt);
  repeat(o.work / "world/dsm.tif", o.build_size_px / 2, o.build_size_px / 2, heights);
  run({"gdal_translate", "-q", "-co", "TILED=YES", vrt, rgb}, rgb.string() + ".log");
  return {"drawn", rgb, heights};
}

}  // namespace

void bench_build_time(const Data&, const Options& o, Report& report) {
  report.section(
      "building",
      "wall time of the programs as a user runs them, all cores, one run each, input in the page cache; landfix: gray, "
      "overview and, where there is a DEM, height, all levels; gdal2tiles: its default levels");
  compare(drawn_image(o), o, report);
  const char* folder = std::getenv("LANDFIX_DATA");
  const fs::path real = fs::path(folder ? folder : "") / "hura_il/hura_0.5m_13km2.tif";
  if (folder && fs::exists(real)) compare({"hura_il", real, {}}, o, report);
}

}  // namespace landfix::bench
