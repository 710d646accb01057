// Correlation by AND and popcount: for every column of shifts the window is shifted once to the patch's words, then
// each shift is a run over memory. Sum of products = pixels where both are set - 2 * those of unlike sign.
#pragma once

#include "runtime/kernels/engine.h"

namespace landfix::kernels {

/// Rows of a word column, `shift` (0 to 63) pixels further right.
template <class Isa>
void shift_column(const uint64_t* __restrict low, const uint64_t* __restrict high, int shift, int rows,
                  uint64_t* __restrict out) {
  for (int y = 0; y < rows; ++y) out[y] = low[y] >> shift | high[y] << 1 << (63 - shift);
}

/// The window from pixel column `x` on, in the patch's words.
template <class Isa>
void shift_window(const Problem& p, int x, const SignedBits& shifted) {
  const int rows = p.shifts_y - 1 + p.patch_height;
  for (int c = 0; c < p.channels; ++c) {
    for (int k = 0; k < p.patch.columns; ++k) {
      const int64_t from = int64_t(c * p.window.columns + k + x / 64) * p.window.column_size;
      const int64_t to = int64_t(c * p.patch.columns + k) * shifted.column_size;
      const int64_t next = from + p.window.column_size;
      shift_column<Isa>(p.window.nonzero + from, p.window.nonzero + next, x % 64, rows, shifted.nonzero + to);
      shift_column<Isa>(p.window.negative + from, p.window.negative + next, x % 64, rows, shifted.negative + to);
    }
  }
}

/// The sums of kShifts neighbouring rows of shifts, from row y on.
template <class Isa, int kShifts>
void sum_rows(const Problem& p, const SignedBits& shifted, int y, int32_t* sums, int64_t row_stride) {
  typename Isa::Count counts[kShifts];
  for (int k = 0; k < p.channels * p.patch.columns; ++k) {
    const uint64_t* patch_nonzero = p.patch.nonzero + int64_t(k) * p.patch.column_size;
    const uint64_t* patch_negative = p.patch.negative + int64_t(k) * p.patch.column_size;
    const uint64_t* nonzero = shifted.nonzero + int64_t(k) * shifted.column_size + y;
    const uint64_t* negative = shifted.negative + int64_t(k) * shifted.column_size + y;
    for (int row = 0; row < p.patch_height; row += Isa::kWords) {
      const typename Isa::Bits set = Isa::load(patch_nonzero + row), minus = Isa::load(patch_negative + row);
      for (int i = 0; i < kShifts; ++i)
        counts[i].add(Isa::load(nonzero + row + i), Isa::load(negative + row + i), set, minus);
    }
    for (int i = 0; i < kShifts; ++i) counts[i].widen();
  }
  for (int i = 0; i < kShifts; ++i) sums[i * row_stride] = counts[i].total();
}

template <class Isa>
void correlate_by_bits(const Problem& p, const SignedBits& shifted, int32_t* sums, int64_t row_stride) {
  constexpr int kTogether = 4;
  for (int x = 0; x < p.shifts_x; ++x) {
    shift_window<Isa>(p, x, shifted);
    int y = 0;
    for (; y + kTogether <= p.shifts_y; y += kTogether)
      sum_rows<Isa, kTogether>(p, shifted, y, sums + y * row_stride + x, row_stride);
    for (; y < p.shifts_y; ++y) sum_rows<Isa, 1>(p, shifted, y, sums + y * row_stride + x, row_stride);
  }
}

}  // namespace landfix::kernels
