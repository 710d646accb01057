// Ternary correlation of runtime/kernels against OpenCV's correlation of floating-point images, by every kernel that
// this processor runs.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <random>

#include "builder/error.h"
#include "runtime/kernels/correlate.h"
#include "tools/bench/sections.h"
#include "tools/bench/timing.h"

namespace landfix::bench {
namespace {

using kernels::Kernel;
using kernels::Shifts;
using kernels::Status;

constexpr int kChannels = 2;
constexpr int kRounds = 40;
constexpr double kAllowed = 0.01;  // matchTemplate goes through floating-point spectra
constexpr double kFaster = 1.6;

struct Size {
  int patch_px, search_px;  ///< the patch is sought up to search_px to each side
  bool targets;
};
constexpr Size kSizes[] = {{128, 40, true}, {64, 64, false}, {256, 64, false}, {128, 3, false}};

/// Milliseconds that a kernel may take for 128 px over +-40 px.
std::optional<double> target_ms(Kernel kernel) {
  if (kernel == Kernel::kAvx512) return 1.2;
  if (kernel == Kernel::kAvx2) return 2.5;
  return std::nullopt;
}

/// A square ternary image, as planes and as OpenCV wants it.
struct Ternary {
  std::array<cv::Mat, kChannels> images;
  std::vector<std::vector<uint64_t>> words;
  std::vector<kernels::PlaneView> planes;
};

Ternary random_ternary(int side_px, std::mt19937& random) {
  Ternary t;
  const int row_words = kernels::words_for(side_px);
  for (cv::Mat& image : t.images) {
    cv::Mat_<int8_t> values(side_px, side_px);
    for (int8_t& value : values) value = int8_t(int(random() % 3) - 1);
    values.convertTo(image, CV_32F);
    std::array<std::vector<uint64_t>, 2> planes;
    for (auto& plane : planes) plane.resize(size_t(side_px) * size_t(row_words));
    if (kernels::pack_ternary(values[0], size_t(side_px), 1, side_px, side_px, planes[0].data(), planes[1].data(),
                              row_words) != Status::kOk)
      throw Error(ExitCode::kInternal, "random pixels that are not ternary");
    for (auto& plane : planes) t.words.push_back(std::move(plane));
  }
  for (const auto& plane : t.words) t.planes.push_back({plane.data(), side_px, side_px, row_words});
  return t;
}

/// The sum over the channels.
cv::Mat match_template(const Ternary& window, const Ternary& patch) {
  cv::Mat sum, of_channel;
  cv::matchTemplate(window.images[0], patch.images[0], sum, cv::TM_CCORR);
  for (size_t c = 1; c < kChannels; ++c) {
    cv::matchTemplate(window.images[c], patch.images[c], of_channel, cv::TM_CCORR);
    sum += of_channel;
  }
  return sum;
}

void compare(const Size& size, Report& report) {
  std::mt19937 random(7);
  const Ternary window = random_ternary(size.patch_px + 2 * size.search_px, random);
  const Ternary patch = random_ternary(size.patch_px, random);
  const Shifts shifts = kernels::all_shifts(window.planes[0], patch.planes[0]);
  cv::Mat_<int32_t> sums(shifts.height(), shifts.width());
  kernels::Workspace workspace;
  const auto correlate = [&](Kernel kernel) {
    if (kernels::correlate_ternary(window.planes, patch.planes, shifts, {sums[0], sums.total()}, sums.step1(),
                                   workspace, kernel) != Status::kOk)
      throw Error(ExitCode::kInternal, fmt::format("kernel {} refuses its arguments", kernels::name_of(kernel)));
  };
  // All in turn in every round: what else runs on the machine disturbs all of them alike.
  const auto available = kernels::available_kernels();
  std::vector<std::vector<double>> ours(available.size());
  std::vector<double> theirs;
  for (int round = 0; round < kRounds; ++round) {
    theirs.push_back(time_of([&] { match_template(window, patch); }));
    for (size_t i = 0; i < available.size(); ++i) ours[i].push_back(time_of([&] { correlate(available[i]); }));
  }
  const cv::Mat expected = match_template(window, patch);
  const std::string what = fmt::format("{} px over +-{}", size.patch_px, size.search_px);
  report.measured(what + ": cv::matchTemplate", median(theirs) * 1e3, "ms");
  for (size_t i = 0; i < available.size(); ++i) {
    const std::string name = fmt::format("{}: {}", what, kernels::name_of(available[i]));
    const double seconds = median(ours[i]);
    const std::optional<double> target = size.targets ? target_ms(available[i]) : std::nullopt;
    if (target) {
      report.at_most(name, seconds * 1e3, "ms", *target);
      report.at_least(name + ", matchTemplate over it", median(theirs) / seconds, "x", kFaster);
    } else {
      report.measured(name, seconds * 1e3, "ms");
      report.measured(name + ", matchTemplate over it", median(theirs) / seconds, "x");
    }
    correlate(available[i]);
    cv::Mat found;
    sums.convertTo(found, CV_32F);
    report.equal(name + ", largest difference", cv::norm(found, expected, cv::NORM_INF), "", kAllowed);
  }
}

}  // namespace

void bench_kernels(const Data&, const Options&, Report& report) {
  report.section(
      "kernels",
      fmt::format("sums of products of ternary images, {} channels, random pixels, for all shifts; median of "
                  "{} rounds, one thread; cv::matchTemplate: TM_CCORR, one call per channel",
                  kChannels, kRounds));
  cv::setNumThreads(1);
  for (const Size& size : kSizes) compare(size, report);
}

}  // namespace landfix::bench
