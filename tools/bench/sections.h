// The sections of the benchmark, in the order in which they run; the same arguments for all.
#pragma once

#include "tools/bench/data.h"
#include "tools/bench/report.h"

namespace landfix::bench {

/// Machine, versions and load.
void describe_setup(const Options& options, Report& report);

/// Opening a pack: time, and memory of the mapping.
void bench_opening(const Data& data, const Options& options, Report& report);

/// Random windows of 512×512 px from the pack, by memcpy from its mapping, and by GDAL from the other files.
void bench_windows(const Data& data, const Options& options, Report& report);

/// Single questions to an open pack, in nanoseconds.
void bench_lookups(const Data& data, const Options& options, Report& report);

/// Normalized cross-correlation of runtime/nav against cv::matchTemplate.
void bench_correlation(const Data& data, const Options& options, Report& report);

/// Ternary correlation of runtime/kernels against cv::matchTemplate; needs no data.
void bench_kernels(const Data& data, const Options& options, Report& report);

/// Registration by every matcher, and the search of position, rotation and scale, on one core; makes its own data.
void bench_registration(const Data& data, const Options& options, Report& report);

/// How fast all raster layers are made of imagery of several dates, and how large they are; makes its own data.
void bench_layers(const Data& data, const Options& options, Report& report);

/// Landmarks and roads: finding them in a map and in a camera's image, their bytes in a pack, queries; makes its own
/// data.
void bench_landmarks(const Data& data, const Options& options, Report& report);

/// Building a pack against making a COG and a tile pyramid of the same image; on a real image too where LANDFIX_DATA
/// names the folder.
void bench_build_time(const Data& data, const Options& options, Report& report);

}  // namespace landfix::bench
