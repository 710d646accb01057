// The benchmark's own data: a drawn world, repeated until it is large, as a map pack and as what users have instead;
// and another one at several dates.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace landfix::bench {

struct Options {
  std::filesystem::path work = "build/bench";  ///< data and logs
  std::filesystem::path output = "bench.json";
  std::string landfix = LANDFIX_PROGRAM;  ///< the program to time
  int size_px = 14400;                    ///< side of the image of windows and lookups, metres too
  int build_size_px = 8192;               ///< side of the image that is built
  int windows = 1000;
  uint64_t seed = 1;  ///< of the places where windows lie
};

/// One place drawn at several dates, 2100 m at 1 m, RGB.
struct Seasons {
  struct Image {
    std::filesystem::path file;
    std::string date;
  };
  std::vector<Image> images;     ///< what the map is made of
  std::filesystem::path camera;  ///< at another date, under another sun
  std::filesystem::path pack;    ///< of `images`: every layer for matching, as stored by default
};

/// Files of the same pixels, 1 m, UTM. Gray values are what the pack's gray layer must hold.
struct Data {
  std::filesystem::path rgb, heights;  ///< VRTs that repeat the world
  std::filesystem::path pack;          ///< gray (raw), overview, height
  std::filesystem::path raw;           ///< gray, uncompressed GeoTIFF in tiles of 256
  std::filesystem::path cog;           ///< gray, cloud-optimized GeoTIFF in JPEG
  std::filesystem::path mbtiles;       ///< gray, JPEG tiles in EPSG:3857
};

inline constexpr const char* kPackLayers = "gray,overview,height";

/// Makes what is missing or was made by other parameters; the pack also where the program is newer. Takes minutes the
/// first time. Throws Error.
Data make_data(const Options& options);

/// The same for the world of several dates.
Seasons make_seasons(const Options& options);

/// A VRT named `output` that repeats `source` to `width_px` x `height_px`.
void repeat(const std::filesystem::path& source, int width_px, int height_px, const std::filesystem::path& output);

/// Says what is going on, on stderr.
void say(const std::string& text);

}  // namespace landfix::bench
