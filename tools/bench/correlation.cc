// Normalized cross-correlation of runtime/nav against OpenCV's, on windows of the pack.
#include <fmt/format.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

#include "builder/error.h"
#include "runtime/nav/ncc.h"
#include "runtime/nav/pack_map.h"
#include "tools/bench/sections.h"
#include "tools/bench/timing.h"
#include "tools/common/open_pack.h"

namespace landfix::bench {
namespace {

using features::GridImage;

constexpr int kPlaces = 40;
constexpr double kAllowed = 1e-3;

struct Size {
  int patch_px, search_px;  ///< the patch is sought up to search_px to each side
};
constexpr Size kSizes[] = {{64, 32}, {128, 40}, {128, 128}, {256, 64}, {256, 256}};

/// A window of the map around a random place, as the localizer gets it.
GridImage random_window(const Pack& pack, int side_px, std::mt19937_64& random) {
  const lf_info map = pack.info();
  const auto between = [&](double low, double high) {
    return std::floor(low + (high - low) * double(random() >> 11) * 0x1p-53);
  };
  const double west = between(map.west_m, map.east_m - side_px), south = between(map.south_m, map.north_m - side_px);
  GridImage window;
  const nav::Status status =
      nav::PackMap(pack).read(nav::MapLayer::kGray, west, south, west + side_px, south + side_px, 1, window);
  if (status != nav::Status::kOk)
    throw Error(ExitCode::kBadPack, "the benchmark's pack cannot be read: " + std::string(nav::to_text(status)));
  return window;
}

/// The middle of a window as a camera sees it: less contrast, brighter, with noise.
GridImage patch_of(const GridImage& window, const Size& size, std::mt19937_64& random) {
  const cv::Rect middle(size.search_px, size.search_px, size.patch_px, size.patch_px);
  GridImage patch{window.pixels(middle).clone(), {}, 0, 0, window.gsd_m};
  for (uint8_t& pixel : cv::Mat_<uint8_t>(patch.pixels)) pixel = uint8_t(24 + pixel * 4 / 5 + int(random() % 13) - 6);
  return patch;
}

void compare(const Pack& pack, const Size& size, Report& report) {
  std::mt19937_64 random(11);
  nav::Ncc matcher;
  std::vector<double> ours, theirs;
  double worst = 0;
  for (int i = 0; i < kPlaces; ++i) {
    const GridImage window = random_window(pack, size.patch_px + 2 * size.search_px, random);
    const GridImage patch = patch_of(window, size, random);
    GridImage surface;
    cv::Mat expected;
    nav::Status status{};
    ours.push_back(time_of([&] { status = matcher.match(patch, window, surface); }));
    theirs.push_back(time_of([&] { cv::matchTemplate(window.pixels, patch.pixels, expected, cv::TM_CCOEFF_NORMED); }));
    worst = status == nav::Status::kOk ? std::max(worst, cv::norm(surface.pixels, expected, cv::NORM_INF)) : INFINITY;
  }
  const std::string name = fmt::format("{} px over +-{}", size.patch_px, size.search_px);
  report.measured(name + ": landfix, median", median(ours) * 1e3, "ms");
  report.measured(name + ": cv::matchTemplate over landfix", median(theirs) / median(ours), "x");
  report.equal(name + ": largest difference", worst, "", kAllowed);
}

}  // namespace

void bench_correlation(const Data& d, const Options&, Report& report) {
  report.section(
      "correlation",
      fmt::format("{} windows of the pack, patch from the middle with gain, offset and noise; one thread each",
                  kPlaces));
  cv::setNumThreads(1);
  const Pack pack = tools::open_pack(d.pack.string());
  for (const Size& size : kSizes) compare(pack, size, report);
}

}  // namespace landfix::bench
