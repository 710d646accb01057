#include <fmt/format.h>
#include <gdal.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <opencv2/core/utility.hpp>
#include <string>
#include <thread>

#include "landfix/landfix.h"
#include "tools/bench/sections.h"

namespace landfix::bench {
namespace {

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown";
}

std::string kernel() {
  utsname name{};
  uname(&name);
  return fmt::format("{} {} {}", name.sysname, name.release, name.machine);
}

}  // namespace

void describe_setup(const Options& o, Report& report) {
  report.setup("processor", processor());
  report.setup("cores", std::thread::hardware_concurrency());
  report.setup("last-level cache MiB", double(sysconf(_SC_LEVEL3_CACHE_SIZE)) / (1 << 20));
  report.setup("memory GiB", int(double(sysconf(_SC_PHYS_PAGES)) * double(sysconf(_SC_PAGESIZE)) / (1 << 30) + 0.5));
  report.setup("kernel", kernel());
  double load = 0;
  getloadavg(&load, 1);
  report.setup("load at start", std::round(load * 100) / 100);
  report.setup("landfix", lf_version());
  report.setup("GDAL", GDALVersionInfo("RELEASE_NAME"));
  report.setup("OpenCV", cv::getVersionString());
  report.setup("compiler", __VERSION__);
  report.setup("image",
               fmt::format("{0}x{0} px at 1 m, gray, {1:.0f} MB, {2:.0f} km2, a drawn world repeated", o.size_px,
                           double(o.size_px) * o.size_px / 1e6, double(o.size_px) * o.size_px / 1e6));
}

}  // namespace landfix::bench
