// Correlation by tables, after the "four Russians": a window row's contribution to a shift depends on the patch only
// through the values of a few neighbouring pixels at a time (kDigits ternary values, 81 cases). Per window row those
// that occur in the patch are tabulated for every column; a shift's sum is then one byte addition per such group, done
// for a whole register of neighbouring shifts at once. Groups that are zero cost nothing.
#pragma once

#include "runtime/kernels/engine.h"

namespace landfix::kernels {

/// Registers of bytes by the compilers' vector types, which every instruction set gets its best code from.
template <class Isa>
struct Lanes {
  static constexpr int kBytes = Isa::kBytes;
  typedef int8_t Int8 __attribute__((vector_size(kBytes)));
  typedef int16_t Int16 __attribute__((vector_size(kBytes)));

  template <class Vector>
  static Vector load(const void* from) {
    Vector v;
    __builtin_memcpy(&v, from, sizeof v);
    return v;
  }
  template <class Vector>
  static void store(void* to, Vector v) {
    __builtin_memcpy(to, &v, sizeof v);
  }
};

/// Pixels of one channel of a row as bytes, from `x` (a multiple of 8) on.
template <class Isa>
void unpack_row(const Problem& p, int channel, int row, int x, int count, int8_t* values, int8_t* negated) {
  const auto spread = [](uint64_t bits) {  // bit i to byte i
    const uint64_t single = bits * 0x0101010101010101 & 0x8040201008040201;
    return (single + 0x7f7f7f7f7f7f7f7f) >> 7 & 0x0101010101010101;
  };
  for (int i = 0; i < count; i += 8, x += 8) {
    const int64_t word = int64_t(channel * p.window.columns + x / 64) * p.window.column_size + row;
    const uint64_t nonzero = spread(p.window.nonzero[word] >> (x % 64) & 255);
    const uint64_t negative = spread(p.window.negative[word] >> (x % 64) & 255);
    const uint64_t value = nonzero ^ negative * 0xfe, opposite = nonzero ^ (nonzero ^ negative) * 0xfe;
    __builtin_memcpy(values + i, &value, 8);
    __builtin_memcpy(negated + i, &opposite, 8);
  }
}

/// One slot from its parent, `count` bytes of it.
template <class Isa>
void add_pixels(const int8_t* parent, const int8_t* pixels, int count, int8_t* out) {
  using L = Lanes<Isa>;
  for (int x = 0; x < count; x += L::kBytes) {
    const typename L::Int8 sum =
        L::template load<typename L::Int8>(parent + x) + L::template load<typename L::Int8>(pixels + x);
    L::store(out + x, sum);
  }
}

/// A band's look-ups of one patch row, for kBlocks registers of shifts: even ones, then odd ones of each register.
template <class Isa, int kBlocks>
void add_look_ups(const int8_t* tables, const uint16_t* begin, const uint16_t* end, int16_t* row_sums) {
  using L = Lanes<Isa>;
  typename L::Int16 sums[2 * kBlocks];
  for (int b = 0; b < 2 * kBlocks; ++b) sums[b] = L::template load<typename L::Int16>(row_sums + b * L::kBytes / 2);
  while (begin != end) {
    const uint16_t* stop = end - begin > kLookUpsPerSum ? begin + kLookUpsPerSum : end;
    typename L::Int8 bytes[kBlocks] = {};
    for (; begin != stop; begin += kLookUpsTogether)
      for (int i = 0; i < kLookUpsTogether; ++i)
        for (int b = 0; b < kBlocks; ++b)
          bytes[b] += L::template load<typename L::Int8>(tables + begin[i] + b * L::kBytes);
    for (int b = 0; b < kBlocks; ++b) {
      sums[2 * b] += typename L::Int16(bytes[b]) << 8 >> 8;
      sums[2 * b + 1] += typename L::Int16(bytes[b]) >> 8;
    }
  }
  for (int b = 0; b < 2 * kBlocks; ++b) L::store(row_sums + b * L::kBytes / 2, sums[b]);
}

/// Moves the 16-bit sums of a strip of `width` shifts to where they go.
template <class Isa>
void flush(const Problem& p, int width, int16_t* row_sums, int32_t* sums, int64_t row_stride) {
  constexpr int kHalf = Isa::kBytes / 2;
  for (int y = 0; y < p.shifts_y; ++y, row_sums += kStripPixels, sums += row_stride) {
    for (int x = 0; x < width; ++x)
      sums[x] += row_sums[x / Isa::kBytes * Isa::kBytes + x % 2 * kHalf + x % Isa::kBytes / 2];
    for (int x = 0; x < kStripPixels; ++x) row_sums[x] = 0;
  }
}

/// The tables of one window row, for `wanted` pixels from column `x` on.
template <class Isa>
void make_tables(const Problem& p, const Band& band, int row, int x, int wanted, int8_t* tables) {
  int8_t* pixels = tables + kSlots * kTablePixels;
  const int there = 64 * p.window.columns - x;  // what lies beyond is for shifts that nobody asked for
  const int count = there < wanted ? there : wanted;
  for (int c = 0; c < p.channels; ++c)
    unpack_row<Isa>(p, c, row, x, count, pixels + 2 * c * kTablePixels, pixels + (2 * c + 1) * kTablePixels);
  for (int slot = 1; slot < band.slots; ++slot) {
    const TableStep step = band.steps[slot - 1];
    add_pixels<Isa>(tables + step.parent * kTablePixels,
                    pixels + (2 * step.channel + step.negative) * kTablePixels + step.column, wanted,
                    tables + slot * kTablePixels);
  }
}

/// One strip of kBlocks registers of shifts, from shift `x` on. `row_sums` are zero before and after.
template <class Isa, int kBlocks>
void add_strip(const Problem& p, const Band& band, int x, int8_t* tables, int16_t* row_sums, int32_t* sums,
               int64_t row_stride) {
  const int columns = (band.width + Isa::kBytes - 1) / Isa::kBytes * Isa::kBytes + kBlocks * Isa::kBytes;
  const int width = p.shifts_x - x < kBlocks * Isa::kBytes ? p.shifts_x - x : kBlocks * Isa::kBytes;
  const int rows = p.shifts_y - 1 + p.patch_height;
  for (int row = 0; row < rows; ++row) {
    make_tables<Isa>(p, band, row, x + band.first_column, columns, tables);
    const int first = row < p.patch_height ? 0 : row - p.patch_height + 1;
    const int last = row < p.shifts_y ? row : p.shifts_y - 1;
    for (int y = first; y <= last; ++y) {
      const uint32_t* look_ups = band.row_begin + (row - y);
      add_look_ups<Isa, kBlocks>(tables, band.look_ups + look_ups[0], band.look_ups + look_ups[1],
                                 row_sums + y * kStripPixels);
    }
    if ((row + 1) % kRowsPerSum == 0 || row + 1 == rows) flush<Isa>(p, width, row_sums, sums + x, row_stride);
  }
}

template <class Isa>
void correlate_by_tables(const Problem& p, const Band& band, int8_t* tables, int16_t* row_sums, int32_t* sums,
                         int64_t row_stride) {
  for (int i = 0; i < kTableScratch; ++i) tables[i] = 0;
  for (int64_t i = 0; i < int64_t{p.shifts_y} * kStripPixels; ++i) row_sums[i] = 0;
  constexpr decltype(&add_strip<Isa, 1>) kStrips[] = {add_strip<Isa, 1>, add_strip<Isa, 2>, add_strip<Isa, 3>,
                                                      add_strip<Isa, 4>};
  const int blocks = (p.shifts_x + Isa::kBytes - 1) / Isa::kBytes;
  for (int done = 0; done < blocks;) {
    const int together = blocks - done < 4 ? blocks - done : 4;
    kStrips[together - 1](p, band, done * Isa::kBytes, tables, row_sums, sums, row_stride);
    done += together;
  }
}

}  // namespace landfix::kernels
