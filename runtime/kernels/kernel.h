// Which instruction sets there are code for, and which of them this processor runs. Decided once, by asking the
// processor and the operating system (wide registers must be saved by it); nothing else has a say.
#pragma once

#include <span>

namespace landfix::kernels {

enum class Kernel { kScalar, kNeon, kAvx2, kAvx512 };

/// "scalar", "neon", "avx2" or "avx512"; never null.
const char* name_of(Kernel kernel) noexcept;

/// Kernels that this processor runs, slowest first; always kScalar at least. All give the same results.
std::span<const Kernel> available_kernels() noexcept;

Kernel best_kernel() noexcept;

}  // namespace landfix::kernels
