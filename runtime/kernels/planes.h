// Images as bit planes: one bit per pixel, 64 pixels to a word. A ternary image is two planes per channel, the first
// set where the pixel is +1, the second where it is -1.
#pragma once

#include <cstddef>
#include <cstdint>

#include "runtime/kernels/status.h"

namespace landfix::kernels {

/// One plane of width x height pixels. Column x is bit x % 64 of word x / 64 of its row; bits at and beyond `width` are
/// zero. Rows lie `row_words` apart, which may be more than they need. The words belong to whoever made the view.
struct PlaneView {
  const uint64_t* words = nullptr;
  int width = 0, height = 0;
  int row_words = 0;
};

/// Longest side of a plane.
inline constexpr int kMaxSide = 1 << 20;

/// Words that a row of `width` pixels needs.
constexpr int words_for(int width) { return (width + 63) / 64; }

/// Sizes within kMaxSide, rows that hold their width, and words where there are pixels.
bool is_valid(const PlaneView& plane);

/// Packs one channel of an image of -1, 0 and 1 (rows `stride` pixels apart, pixels `step` apart: 2 for two interleaved
/// channels) into planes of row_words words per row, which are overwritten as a whole. kBadArgument: a null pointer, a
/// size beyond kMaxSide or a row too short; kBadPixel: another value (the planes are then unspecified).
Status pack_ternary(const int8_t* pixels, size_t stride, size_t step, int width, int height, uint64_t* plus,
                    uint64_t* minus, int row_words) noexcept;

/// Copies width x height pixels of a plane, from (column, row) on, to the bits of `out` from its bit 0 on, row_words
/// words per row; bits beyond `width` become zero. kBadArgument where the rectangle leaves the plane or the row is too
/// short.
Status extract(const PlaneView& from, int column, int row, int width, int height, uint64_t* out,
               int row_words) noexcept;

}  // namespace landfix::kernels
