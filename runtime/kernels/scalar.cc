// Plain C++, for every processor: 64-bit words, and what the compiler makes of its vector types.
#include "runtime/kernels/by_bits.h"
#include "runtime/kernels/by_tables.h"

namespace landfix::kernels {
namespace {

struct Scalar {
  static constexpr int kWords = 1, kBytes = 16;
  using Bits = uint64_t;
  static Bits load(const uint64_t* from) { return *from; }

  struct Count {
    int32_t sum = 0;
    void add(Bits nonzero, Bits negative, Bits patch_nonzero, Bits patch_negative) {
      const Bits both = nonzero & patch_nonzero;
      sum += ones(both) - 2 * ones(both & (negative ^ patch_negative));
    }
    void widen() {}
    int32_t total() const { return sum; }
  };

  /// Counts in pairs, nibbles and bytes of bits; a product sums the bytes.
  static int32_t ones(uint64_t bits) {
    bits -= bits >> 1 & 0x5555555555555555;
    bits = (bits & 0x3333333333333333) + (bits >> 2 & 0x3333333333333333);
    bits = (bits + (bits >> 4)) & 0x0f0f0f0f0f0f0f0f;
    return int32_t(bits * 0x0101010101010101 >> 56);
  }
};

}  // namespace

const Engine* scalar_engine() {
  static constexpr Engine kEngine = {Scalar::kBytes, correlate_by_bits<Scalar>, correlate_by_tables<Scalar>, 1.8, 0.25};
  return &kEngine;
}

}  // namespace landfix::kernels
