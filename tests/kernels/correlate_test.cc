// All kernels and both methods against the definition.
#include "runtime/kernels/correlate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "runtime/kernels/method.h"
#include "tests/kernels/image.h"

namespace landfix::kernels {
namespace {

using tests::Image;
using tests::random_image;
using tests::sum_at;

constexpr int32_t kUntouched = std::numeric_limits<int32_t>::min();

int below(std::mt19937& random, int end) { return int(random() % unsigned(end)); }

/// The first planes of all channels: an image of zeros and ones.
std::vector<PlaneView> plus_planes(const Image& image) {
  std::vector<PlaneView> planes;
  for (size_t i = 0; i < image.planes().size(); i += 2) planes.push_back(image.planes()[i]);
  return planes;
}

struct Case {
  Image window, patch;
  Shifts shifts;
};

/// Sizes around the words' and registers' edges; densities from empty to full.
Case random_case(std::mt19937& random) {
  constexpr double kDensities[] = {0, 0.05, 0.5, 0.9, 1};
  const int channels = 1 + below(random, kMaxChannels);
  const int widths[] = {1 + below(random, 63), 62 + below(random, 5), 1 + below(random, 200)};
  const int width = widths[below(random, 3)], height = 1 + below(random, 24);
  const int window_width = width + below(random, random() % 4 == 0 ? 150 : 40);
  const int window_height = height + below(random, 14);
  Case c{random_image(channels, window_width, window_height, kDensities[below(random, 5)], random, below(random, 3)),
         random_image(channels, width, height, kDensities[below(random, 5)], random, below(random, 3)),
         {}};
  c.shifts = all_shifts(c.window.planes()[0], c.patch.planes()[0]);
  if (random() % 2 == 0) {
    c.shifts.begin_x = below(random, c.shifts.end_x);
    c.shifts.end_x -= below(random, c.shifts.width());
    c.shifts.begin_y = below(random, c.shifts.end_y);
    c.shifts.end_y -= below(random, c.shifts.height());
  }
  return c;
}

std::string describe(const Case& c) {
  return "window " + std::to_string(c.window.width()) + " x " + std::to_string(c.window.height()) + ", patch " +
         std::to_string(c.patch.width()) + " x " + std::to_string(c.patch.height()) + ", " +
         std::to_string(c.patch.channels()) + " channels, shifts " + std::to_string(c.shifts.begin_x) + " to " +
         std::to_string(c.shifts.end_x) + ", " + std::to_string(c.shifts.begin_y) + " to " +
         std::to_string(c.shifts.end_y);
}

/// Sums by definition, with `gap` elements after every row but the last that must stay as they are.
std::vector<int32_t> expected_sums(const Case& c, int gap) {
  std::vector<int32_t> sums;
  for (int y = c.shifts.begin_y; y < c.shifts.end_y; ++y) {
    if (y != c.shifts.begin_y) sums.insert(sums.end(), size_t(gap), kUntouched);
    for (int x = c.shifts.begin_x; x < c.shifts.end_x; ++x) sums.push_back(sum_at(c.window, c.patch, x, y));
  }
  return sums;
}

void expect_all_agree(const std::vector<PlaneView>& window, const std::vector<PlaneView>& patch, bool signs,
                      const Case& c, const std::vector<int32_t>& expected, int gap, Workspace& workspace) {
  for (const Kernel kernel : available_kernels()) {
    for (const std::optional<Method> method :
         {std::optional(Method::kBits), std::optional(Method::kTables), std::optional<Method>()}) {
      std::vector<int32_t> sums(expected.size(), kUntouched);
      ASSERT_EQ(
          correlate(window, patch, signs, c.shifts, sums, size_t(c.shifts.width() + gap), workspace, kernel, method),
          Status::kOk);
      ASSERT_TRUE(sums == expected) << name_of(kernel) << (signs ? ", ternary, " : ", counts, ")
                                    << (method ? (*method == Method::kBits ? "bits, " : "tables, ") : "either, ")
                                    << describe(c);
    }
  }
}

TEST(Correlate, AllKernelsEqualTheDefinition) {
  std::mt19937 random(1);
  Workspace workspace;
  for (int i = 0; i < 2500; ++i) {
    const Case c = random_case(random);
    const int gap = below(random, 3);
    ASSERT_NO_FATAL_FAILURE(
        expect_all_agree(c.window.planes(), c.patch.planes(), true, c, expected_sums(c, gap), gap, workspace));
  }
}

TEST(CountCommon, AllKernelsEqualTheDefinition) {
  std::mt19937 random(2);
  Workspace workspace;
  const auto ones = [](const Image& image) {
    return Image(image.channels(), image.width(), image.height(),
                 [&](int c, int x, int y) { return image.at(c, x, y) == 1 ? 1 : 0; });
  };
  for (int i = 0; i < 1000; ++i) {
    const Case c = random_case(random);
    const Case counted{ones(c.window), ones(c.patch), c.shifts};
    const int gap = below(random, 3);
    ASSERT_NO_FATAL_FAILURE(expect_all_agree(plus_planes(c.window), plus_planes(c.patch), false, c,
                                             expected_sums(counted, gap), gap, workspace));
  }
}

/// The largest sums: all pixels alike, then all of opposite sign, through all bands and strips.
TEST(Correlate, LargestSums) {
  for (const int channels : {1, 2, 3, kMaxChannels}) {
    for (const auto& [width, height] : {std::pair(kMaxPatchSide, 3), std::pair(3, kMaxPatchSide), std::pair(300, 65)}) {
      for (const int sign : {1, -1}) {
        const Case c{Image(channels, width + 130, height + 2, [](int, int, int) { return 1; }),
                     Image(channels, width, height, [&](int, int, int) { return sign; }),
                     {0, 131, 0, 3}};
        const std::vector<int32_t> expected(131 * 3, sign * channels * width * height);
        Workspace workspace;
        ASSERT_NO_FATAL_FAILURE(expect_all_agree(c.window.planes(), c.patch.planes(), true, c, expected, 0, workspace));
      }
    }
  }
}

TEST(Correlate, WidePatchOfOddSize) {
  std::mt19937 random(3);
  const Case c{random_image(2, 1400, 40, 0.6, random), random_image(2, 1023, 31, 0.6, random), {5, 260, 1, 9}};
  Workspace workspace;
  expect_all_agree(c.window.planes(), c.patch.planes(), true, c, expected_sums(c, 0), 0, workspace);
}

TEST(Correlate, PeakIsWhereThePatchWasTaken) {
  std::mt19937 random(4);
  const Image window = random_image(2, 100, 90, 0.7, random);
  const Image patch(2, 50, 40, [&](int c, int x, int y) { return window.at(c, 23 + x, 31 + y); });
  const Shifts shifts = all_shifts(window.planes()[0], patch.planes()[0]);
  std::vector<int32_t> sums(size_t(shifts.width() * shifts.height()));
  Workspace workspace;
  ASSERT_EQ(correlate_ternary(window.planes(), patch.planes(), shifts, sums, size_t(shifts.width()), workspace),
            Status::kOk);
  const auto peak = std::ranges::max_element(sums) - sums.begin();
  EXPECT_EQ(peak % shifts.width(), 23);
  EXPECT_EQ(peak / shifts.width(), 31);
  // At the peak every pixel agrees: as many as are not zero.
  EXPECT_EQ(sums[size_t(peak)], sum_at(patch, patch, 0, 0));
}

TEST(Correlate, PixelOfBothSignsCountsAsZero) {
  const uint64_t both = 1, none = 0;
  const PlaneView set = {&both, 1, 1, 1}, clear = {&none, 1, 1, 1};
  const std::vector<PlaneView> odd = {set, set}, plus = {set, clear};
  for (const Kernel kernel : available_kernels()) {
    for (const Method method : {Method::kBits, Method::kTables}) {
      int32_t sum = kUntouched;
      Workspace workspace;
      ASSERT_EQ(correlate(odd, plus, true, {0, 1, 0, 1}, {&sum, 1}, 1, workspace, kernel, method), Status::kOk);
      EXPECT_EQ(sum, 0);
      ASSERT_EQ(correlate(plus, plus, true, {0, 1, 0, 1}, {&sum, 1}, 1, workspace, kernel, method), Status::kOk);
      EXPECT_EQ(sum, 1);
    }
  }
}

TEST(Correlate, WorkspaceGrowsOnlyForLargerCalls) {
  std::mt19937 random(6);
  const Image window = random_image(2, 130, 130, 0.5, random), patch = random_image(2, 64, 64, 0.5, random);
  std::vector<int32_t> sums(67 * 67);
  Workspace workspace;
  for (const Method method : {Method::kBits, Method::kTables})
    ASSERT_EQ(
        correlate(window.planes(), patch.planes(), true, {0, 67, 0, 67}, sums, 67, workspace, best_kernel(), method),
        Status::kOk);
  const size_t size = workspace.size();
  const std::byte* const memory = workspace.reserve(size);
  for (int i = 1; i <= 67; ++i)
    ASSERT_EQ(correlate_ternary(window.planes(), patch.planes(), {0, i, 0, i}, sums, 67, workspace), Status::kOk);
  EXPECT_EQ(workspace.size(), size);
  EXPECT_EQ(workspace.reserve(size), memory);
}

TEST(Correlate, NoShiftsAreNoError) {
  const Image window(1, 10, 10, [](int, int, int) { return 1; }), patch(1, 20, 5, [](int, int, int) { return 1; });
  const Shifts none = all_shifts(window.planes()[0], patch.planes()[0]);
  EXPECT_EQ(none.width(), 0) << "the patch is wider than the window";
  Workspace workspace;
  EXPECT_EQ(correlate_ternary(window.planes(), patch.planes(), none, {}, 0, workspace), Status::kOk);
}

class BadArguments : public testing::Test {
 protected:
  /// The status of a call that differs from a good one only by what was changed in here; nothing may be written.
  Status status() {
    std::vector<int32_t> sums(size_t(sums_), kUntouched);
    const Status s = correlate_ternary(window_, patch_, shifts_, sums, stride_, workspace_, kernel_);
    EXPECT_EQ(s == Status::kOk, std::ranges::count(sums, kUntouched) != std::ssize(sums));
    return s;
  }

  Image window_image_{2, 70, 20, [](int, int, int) { return 1; }};
  Image patch_image_{2, 60, 15, [](int, int, int) { return -1; }};
  std::vector<PlaneView> window_ = window_image_.planes(), patch_ = patch_image_.planes();
  Shifts shifts_{0, 11, 0, 6};
  int sums_ = 66;
  size_t stride_ = 11;
  Kernel kernel_ = best_kernel();
  Workspace workspace_;
};

TEST_F(BadArguments, TheGoodCallIsGood) { EXPECT_EQ(status(), Status::kOk); }

TEST_F(BadArguments, ShiftsOutsideOfTheWindow) {
  stride_ = 20;
  sums_ = 200;  // room for all of these
  for (const Shifts& shifts : {Shifts{-1, 11, 0, 6}, Shifts{0, 12, 0, 6}, Shifts{0, 11, -1, 6}, Shifts{0, 11, 0, 7},
                               Shifts{8, 4, 0, 6}, Shifts{0, 11, 5, 2}}) {
    shifts_ = shifts;
    EXPECT_EQ(status(), Status::kBadArgument);
  }
}

TEST_F(BadArguments, NoRoomForTheSums) {
  sums_ = 65;
  EXPECT_EQ(status(), Status::kBadArgument);
  sums_ = 66;
  stride_ = 10;
  EXPECT_EQ(status(), Status::kBadArgument) << "rows overlap";
  stride_ = std::numeric_limits<size_t>::max();
  EXPECT_EQ(status(), Status::kBadArgument);
}

TEST_F(BadArguments, ChannelsThatDoNotMatch) {
  patch_.resize(2);
  EXPECT_EQ(status(), Status::kBadArgument);
  window_.resize(2);
  EXPECT_EQ(status(), Status::kOk) << "one channel";
  window_.resize(1);
  patch_.resize(1);
  EXPECT_EQ(status(), Status::kBadArgument) << "half a channel";
  window_.clear();
  patch_.clear();
  EXPECT_EQ(status(), Status::kBadArgument);
  window_.assign(10, window_image_.planes()[0]);
  patch_.assign(10, patch_image_.planes()[0]);
  EXPECT_EQ(status(), Status::kBadArgument) << "five channels";
}

TEST_F(BadArguments, PlanesThatAreNone) {
  const auto refuses = [&](std::vector<PlaneView>& planes, auto change) {
    const std::vector<PlaneView> good = planes;
    change(planes[1]);
    EXPECT_EQ(status(), Status::kBadArgument);
    planes = good;
  };
  for (auto* planes : {&window_, &patch_}) {
    refuses(*planes, [](PlaneView& p) { p.words = nullptr; });
    refuses(*planes, [](PlaneView& p) { p.row_words = 0; });
    refuses(*planes, [](PlaneView& p) { p.width = -1; });
    refuses(*planes, [](PlaneView& p) { p.height -= 1; });
    refuses(*planes, [](PlaneView& p) { p.height = kMaxSide + 1; });
  }
  EXPECT_EQ(status(), Status::kOk);
}

TEST_F(BadArguments, PatchTooLargeOrEmpty) {
  for (PlaneView& p : patch_) p.width = 0;
  EXPECT_EQ(status(), Status::kBadArgument);
  const Image huge(1, kMaxPatchSide + 1, 1, [](int, int, int) { return 1; });
  window_ = patch_ = huge.planes();
  shifts_ = {0, 1, 0, 1};
  EXPECT_EQ(status(), Status::kBadArgument);
}

TEST_F(BadArguments, KernelOfAnotherProcessor) {
  for (const Kernel kernel : {Kernel::kScalar, Kernel::kNeon, Kernel::kAvx2, Kernel::kAvx512, Kernel(99)}) {
    kernel_ = kernel;
    EXPECT_EQ(status(), std::ranges::count(available_kernels(), kernel) ? Status::kOk : Status::kUnavailable);
  }
}

}  // namespace
}  // namespace landfix::kernels
