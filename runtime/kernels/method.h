// The two ways to correlate, for tests and benchmarks that ask for one; correlate.h chooses.
#pragma once

#include <optional>

#include "runtime/kernels/correlate.h"

namespace landfix::kernels {

enum class Method {
  kBits,    ///< AND and popcount, shift after shift: for few shifts
  kTables,  ///< tables of groups of pixels, many shifts at once: for wide searches
};

/// correlate_ternary where `signs` is set, else count_common.
Status correlate(std::span<const PlaneView> window, std::span<const PlaneView> patch, bool signs, const Shifts& shifts,
                 std::span<int32_t> sums, size_t row_stride, Workspace& workspace, Kernel kernel,
                 std::optional<Method> method) noexcept;

}  // namespace landfix::kernels
