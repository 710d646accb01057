#include "runtime/kernels/kernel.h"

#include <array>

#include "runtime/kernels/engine.h"

namespace landfix::kernels {
namespace {

#if defined(__x86_64__)
// The compilers' support library also looks at XCR0: whether the operating system keeps the wide registers.
bool runs_avx2() { return __builtin_cpu_supports("avx2"); }
bool runs_avx512() {
  return runs_avx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512vpopcntdq");
}
#else
bool runs_avx2() { return false; }
bool runs_avx512() { return false; }
#endif

struct Available {
  std::array<Kernel, 4> kernels{};
  size_t count = 0;
  Available() {
    for (const Kernel kernel : {Kernel::kScalar, Kernel::kNeon, Kernel::kAvx2, Kernel::kAvx512})
      if (engine_of(kernel) != nullptr) kernels[count++] = kernel;
  }
};

}  // namespace

const Engine* engine_of(Kernel kernel) {
  switch (kernel) {
    case Kernel::kScalar:
      return scalar_engine();
    case Kernel::kNeon:
      return neon_engine();  // every aarch64 has it
    case Kernel::kAvx2:
      return runs_avx2() ? avx2_engine() : nullptr;
    case Kernel::kAvx512:
      return runs_avx512() ? avx512_engine() : nullptr;
  }
  return nullptr;
}

const char* name_of(Kernel kernel) noexcept {
  switch (kernel) {
    case Kernel::kScalar:
      return "scalar";
    case Kernel::kNeon:
      return "neon";
    case Kernel::kAvx2:
      return "avx2";
    case Kernel::kAvx512:
      return "avx512";
  }
  return "unknown";
}

std::span<const Kernel> available_kernels() noexcept {
  static const Available available;
  return {available.kernels.data(), available.count};
}

Kernel best_kernel() noexcept { return available_kernels().back(); }

}  // namespace landfix::kernels
