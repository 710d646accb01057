// Popcount by VPOPCNTDQ, three-input logic in one instruction.
#include "runtime/kernels/engine.h"

#if defined(__AVX512VPOPCNTDQ__)
#include <immintrin.h>

#include "runtime/kernels/by_bits.h"
#include "runtime/kernels/by_tables.h"
#endif

namespace landfix::kernels {
#if defined(__AVX512VPOPCNTDQ__)
namespace {

struct Avx512 {
  static constexpr int kWords = 8, kBytes = 32;
  using Bits = __m512i;
  static Bits load(const uint64_t* from) { return _mm512_loadu_si512(from); }

  struct Count {
    __m512i both_set = _mm512_setzero_si512(), unlike_signs = _mm512_setzero_si512();

    void add(Bits nonzero, Bits negative, Bits patch_nonzero, Bits patch_negative) {
      const __m512i both = _mm512_and_si512(nonzero, patch_nonzero);
      const __m512i unlike = _mm512_ternarylogic_epi64(both, negative, patch_negative, kAndXor);
      both_set = _mm512_add_epi64(both_set, _mm512_popcnt_epi64(both));
      unlike_signs = _mm512_add_epi64(unlike_signs, _mm512_popcnt_epi64(unlike));
    }
    void widen() {}
    int32_t total() const {
      return int32_t(_mm512_reduce_add_epi64(_mm512_sub_epi64(both_set, _mm512_slli_epi64(unlike_signs, 1))));
    }
    static constexpr int kAndXor = 0xf0 & (0xcc ^ 0xaa);
  };
};

}  // namespace

const Engine* avx512_engine() {
  static constexpr Engine kEngine = {Avx512::kBytes, correlate_by_bits<Avx512>, correlate_by_tables<Avx512>, 0.15,
                                     0.35};
  return &kEngine;
}

#else
const Engine* avx512_engine() { return nullptr; }
#endif

}  // namespace landfix::kernels
