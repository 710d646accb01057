// Popcount by look-ups of half bytes (Mula, Kurz, Lemire 2018, "Faster population counts using AVX2 instructions").
#include "runtime/kernels/engine.h"

#if defined(__AVX2__)
#include <immintrin.h>

#include "runtime/kernels/by_bits.h"
#include "runtime/kernels/by_tables.h"
#endif

namespace landfix::kernels {
#if defined(__AVX2__)
namespace {

struct Avx2 {
  static constexpr int kWords = 4, kBytes = 32;
  using Bits = __m256i;
  static Bits load(const uint64_t* from) { return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from)); }

  struct Count {
    __m256i pairs = _mm256_setzero_si256();  ///< 16 bits, each at most 16 more per add()
    __m256i sums = _mm256_setzero_si256();   ///< 32 bits

    void add(Bits nonzero, Bits negative, Bits patch_nonzero, Bits patch_negative) {
      const __m256i ones = _mm256_setr_epi8(0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4, 0, 1, 1, 2, 1, 2, 2, 3, 1,
                                            2, 2, 3, 2, 3, 3, 4);
      const __m256i minus_two = _mm256_sub_epi8(_mm256_setzero_si256(), _mm256_add_epi8(ones, ones));
      const __m256i both = _mm256_and_si256(nonzero, patch_nonzero);
      const __m256i unlike = _mm256_and_si256(both, _mm256_xor_si256(negative, patch_negative));
      const __m256i bytes = _mm256_add_epi8(look_up(ones, both), look_up(minus_two, unlike));
      pairs = _mm256_add_epi16(pairs, _mm256_maddubs_epi16(_mm256_set1_epi8(1), bytes));
    }
    void widen() {
      sums = _mm256_add_epi32(sums, _mm256_madd_epi16(pairs, _mm256_set1_epi16(1)));
      pairs = _mm256_setzero_si256();
    }
    int32_t total() const {
      __m128i s = _mm_add_epi32(_mm256_castsi256_si128(sums), _mm256_extracti128_si256(sums, 1));
      s = _mm_add_epi32(s, _mm_shuffle_epi32(s, 0x4e));
      s = _mm_add_epi32(s, _mm_shuffle_epi32(s, 0xb1));
      return _mm_cvtsi128_si32(s);
    }
    /// The sum of the table's values for both halves of every byte.
    static __m256i look_up(__m256i table, __m256i bits) {
      const __m256i half = _mm256_set1_epi8(15);
      return _mm256_add_epi8(_mm256_shuffle_epi8(table, _mm256_and_si256(bits, half)),
                             _mm256_shuffle_epi8(table, _mm256_and_si256(_mm256_srli_epi16(bits, 4), half)));
    }
  };
};

}  // namespace

const Engine* avx2_engine() {
  static constexpr Engine kEngine = {Avx2::kBytes, correlate_by_bits<Avx2>, correlate_by_tables<Avx2>, 0.42, 0.38};
  return &kEngine;
}

#else
const Engine* avx2_engine() { return nullptr; }
#endif

}  // namespace landfix::kernels
