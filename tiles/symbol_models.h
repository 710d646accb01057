// Symbols and numbers on top of the arithmetic coder, for vector tiles: schemas/FORMAT.md section 3.6. `code` takes the
// value to encode and returns it; with a decoder it returns the value that was coded, whatever it is given.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "tiles/arithmetic_coder.h"

namespace landfix::tiles {

/// Symbols of `kBits` bits, the highest first; each in the context of those above it, but for the last `kEvenBits`.
template <int kBits, int kEvenBits = 0>
class SymbolModel {
 public:
  template <typename Coder>
  uint32_t code(Coder& coder, uint32_t symbol) {
    uint32_t known = 1;  // the bits so far behind a leading 1
    for (int bit = kBits - 1; bit >= 0; --bit) {
      const bool given = symbol >> bit & 1;
      known = known << 1 | uint32_t(bit >= kEvenBits ? coder.code(models_[known], given) : coder.code_even(given));
    }
    return known - (1u << kBits);
  }

 private:
  std::array<BitModel, size_t(1) << (kBits - kEvenBits)> models_;
};

/// Numbers from 0 to 2^32 - 2, small ones in few bits: n, the number of bits of value + 1 behind its leading 1, as n
/// ones and a zero (none after 31), each with a model of its place; then these bits, the first with a model of its n,
/// the others even.
class NumberModel {
 public:
  template <typename Coder>
  uint32_t code(Coder& coder, uint32_t value) {
    const uint32_t given_bits = uint32_t(std::bit_width(value + 1)) - 1;
    uint32_t bits = 0;
    while (bits < kMostBits && coder.code(lengths_[bits], bits < given_bits)) ++bits;
    uint32_t known = 1;
    for (uint32_t bit = bits; bit-- > 0;) {
      const bool given = (value + 1) >> bit & 1;
      known = known << 1 | uint32_t(bit + 1 == bits ? coder.code(firsts_[bits], given) : coder.code_even(given));
    }
    return known - 1;
  }

 private:
  static constexpr uint32_t kMostBits = 31;
  std::array<BitModel, kMostBits> lengths_;
  std::array<BitModel, kMostBits + 1> firsts_;
};

/// Numbers of either sign: 0, -1, 1, -2, 2, ... as 0, 1, 2, 3, 4, ...
class SignedNumberModel {
 public:
  template <typename Coder>
  int32_t code(Coder& coder, int32_t value) {
    const uint32_t folded = numbers_.code(coder, uint32_t(value) << 1 ^ uint32_t(value >> 31));
    return int32_t(folded >> 1 ^ (0u - (folded & 1)));
  }

 private:
  NumberModel numbers_;
};

}  // namespace landfix::tiles
