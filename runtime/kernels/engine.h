// What a kernel does, for correlate.cc alone: the two ways to correlate, once for every instruction set.
//
// The engines' files are compiled for processors that may not be there. So that no function of theirs can stand in for
// one of the same name elsewhere in the program, they use plain pointers and no library, and templates of types of
// their own. This header and those that they include keep to that.
#pragma once

#include <stdint.h>

namespace landfix::kernels {

enum class Kernel;  // kernel.h

/// Pixels as two bits, set where the pixel is not zero, and where it is -1. Words are ordered [channel][word
/// column][row], so that neighbours in memory are neighbouring rows.
struct SignedBits {
  uint64_t* nonzero = nullptr;
  uint64_t* negative = nullptr;
  int columns = 0;      ///< words per row and channel
  int column_size = 0;  ///< words from one column to the next: rows, and zeros after them
};

/// A correlation for shifts 0 <= x < shifts_x, 0 <= y < shifts_y.
struct Problem {
  SignedBits window, patch;
  int channels = 0;
  int patch_width = 0, patch_height = 0;
  int shifts_x = 0, shifts_y = 0;
};

/// A pixel's share of a table: slot = slot `parent` +- the window's `channel`, `column` pixels to the right.
struct TableStep {
  uint8_t parent = 0, channel = 0, column = 0;
  bool negative = false;
};

inline constexpr int kChannels = 4;
/// Ternary values that one table look-up sums, and the tables that there can be of them.
inline constexpr int kDigits = 4, kSlots = 3 * 3 * 3 * 3;
/// Look-ups come in groups of this many, and a byte can hold the sum of so many.
inline constexpr int kLookUpsTogether = 8, kLookUpsPerSum = 127 / kDigits / kLookUpsTogether * kLookUpsTogether;
/// A band of the patch's columns and a strip of shifts whose tables stay in the first-level cache.
inline constexpr int kBandPixels = 128, kStripPixels = 128, kTablePixels = kBandPixels + kStripPixels;
/// Rows of a band whose sum 16 bits hold.
inline constexpr int kRowsPerSum = 32767 / (kBandPixels * kChannels);

/// Up to kBandPixels columns of a patch as look-ups in tables.
struct Band {
  int first_column = 0, width = 0;
  const TableStep* steps = nullptr;  ///< of slots 1, 2, ...; slot 0 is zero
  int slots = 0;
  const uint16_t* look_ups = nullptr;   ///< slot * kTablePixels + column, row after row
  const uint32_t* row_begin = nullptr;  ///< patch_height + 1 positions in look_ups
};

/// Rows that by_bits may take at once: it reads that far beyond the last, where the patch is zero.
inline constexpr int kRowPadding = 8;
inline constexpr int kAlignment = 64;

struct Engine {
  int bytes = 0;  ///< of a register, for by_tables
  /// AND and popcount along the patch's rows, shift after shift. `shifted` has the patch's columns and room for the
  /// window's rows.
  void (*by_bits)(const Problem& problem, const SignedBits& shifted, int32_t* sums, int64_t row_stride) = nullptr;
  /// Adds a band's share to the sums of all shifts: per window row, tables of what a few neighbouring pixels of any
  /// value contribute, and one addition for `bytes` neighbouring shifts per look-up. `tables` has room for
  /// kTableScratch, `row_sums` for kStripPixels per row of shifts.
  void (*by_tables)(const Problem& problem, const Band& band, int8_t* tables, int16_t* row_sums, int32_t* sums,
                    int64_t row_stride) = nullptr;
  /// What a word of one shift costs by_bits, and a register's addition by_tables; only their ratio matters.
  double bits_cost = 0, tables_cost = 0;
};

/// Bytes of scratch of by_tables.
inline constexpr int kTableScratch = (kSlots + 2 * kChannels + 1) * kTablePixels;

/// Null where the processor, or what this was compiled for, does not have them.
const Engine* scalar_engine();
const Engine* avx2_engine();
const Engine* avx512_engine();
const Engine* neon_engine();
/// Of the four, null too where the processor cannot run it.
const Engine* engine_of(Kernel kernel);

}  // namespace landfix::kernels
