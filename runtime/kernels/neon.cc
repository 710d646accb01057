// Popcount of bytes by VCNT.
#include "runtime/kernels/engine.h"

#if defined(__aarch64__)
#include <arm_neon.h>

#include "runtime/kernels/by_bits.h"
#include "runtime/kernels/by_tables.h"
#endif

namespace landfix::kernels {
#if defined(__aarch64__)
namespace {

struct Neon {
  static constexpr int kWords = 2, kBytes = 16;
  using Bits = uint64x2_t;
  static Bits load(const uint64_t* from) { return vld1q_u64(from); }

  struct Count {
    int16x8_t pairs = vdupq_n_s16(0);  ///< each at most 16 more per add()
    int32x4_t sums = vdupq_n_s32(0);

    void add(Bits nonzero, Bits negative, Bits patch_nonzero, Bits patch_negative) {
      const uint64x2_t both = vandq_u64(nonzero, patch_nonzero);
      const uint64x2_t unlike = vandq_u64(both, veorq_u64(negative, patch_negative));
      pairs = vpadalq_s8(pairs, vsubq_s8(ones(both), vshlq_n_s8(ones(unlike), 1)));
    }
    void widen() {
      sums = vpadalq_s16(sums, pairs);
      pairs = vdupq_n_s16(0);
    }
    int32_t total() const { return vaddvq_s32(sums); }
    static int8x16_t ones(uint64x2_t bits) { return vcntq_s8(vreinterpretq_s8_u64(bits)); }
  };
};

}  // namespace

const Engine* neon_engine() {
  static constexpr Engine kEngine = {Neon::kBytes, correlate_by_bits<Neon>, correlate_by_tables<Neon>, 1.0, 0.5};
  return &kEngine;
}

#else
const Engine* neon_engine() { return nullptr; }
#endif

}  // namespace landfix::kernels
