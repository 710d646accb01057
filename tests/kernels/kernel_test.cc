#include "runtime/kernels/kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace landfix::kernels {
namespace {

// An empty list would leave best_kernel() without an answer, and the differential test without anything to compare.
TEST(Kernel, ScalarIsAlwaysThere) {
  const auto kernels = available_kernels();
  ASSERT_FALSE(kernels.empty());
  EXPECT_EQ(kernels.front(), Kernel::kScalar);
  EXPECT_EQ(kernels.back(), best_kernel());
}

TEST(Kernel, NoneIsListedTwice) {
  std::vector<Kernel> kernels(available_kernels().begin(), available_kernels().end());
  std::ranges::sort(kernels);
  EXPECT_EQ(std::ranges::adjacent_find(kernels), kernels.end());
}

// What the processor says must be what is offered.
TEST(Kernel, WideOnesAreListedWhereTheProcessorHasThem) {
  const auto has = [](Kernel kernel) { return std::ranges::count(available_kernels(), kernel) == 1; };
#if defined(__x86_64__)
  EXPECT_EQ(has(Kernel::kAvx2), __builtin_cpu_supports("avx2") != 0);
  EXPECT_EQ(has(Kernel::kAvx512), __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
                                      __builtin_cpu_supports("avx512vpopcntdq"));
  EXPECT_FALSE(has(Kernel::kNeon));
#elif defined(__aarch64__)
  EXPECT_TRUE(has(Kernel::kNeon));
  EXPECT_FALSE(has(Kernel::kAvx2) || has(Kernel::kAvx512));
#else
  EXPECT_EQ(available_kernels().size(), 1u);
#endif
}

TEST(Kernel, NamesDiffer) {
  EXPECT_STREQ(name_of(Kernel::kScalar), "scalar");
  EXPECT_STREQ(name_of(Kernel::kNeon), "neon");
  EXPECT_STREQ(name_of(Kernel::kAvx2), "avx2");
  EXPECT_STREQ(name_of(Kernel::kAvx512), "avx512");
  EXPECT_STREQ(name_of(Kernel(99)), "unknown");
}

}  // namespace
}  // namespace landfix::kernels
