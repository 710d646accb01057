#include "runtime/kernels/planes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

namespace landfix::kernels {
namespace {

/// The bits of the last word of a row of `width` pixels.
uint64_t last_word_mask(int width) { return ~uint64_t{0} >> (63 - (width - 1) % 64); }

/// The lowest bits of eight bytes, the first byte's first (the multiplication brings each to a place of its own).
uint64_t lowest_bits(uint64_t bytes) { return (bytes & 0x0101010101010101) * 0x0102040810204080 >> 56; }

/// Packs up to 64 pixels; false for a value that is not ternary.
bool pack_word(const int8_t* pixels, size_t step, int count, uint64_t& plus, uint64_t& minus) {
  static_assert(std::endian::native == std::endian::little);
  std::array<int8_t, 64> values{};
  for (int i = 0; i < count; ++i) values[size_t(i)] = pixels[size_t(i) * step];
  bool ternary = true;
  for (const int8_t value : values) ternary &= value >= -1 && value <= 1;
  plus = minus = 0;
  for (unsigned i = 0; i < 64; i += 8) {
    uint64_t bytes;
    std::memcpy(&bytes, &values[i], sizeof bytes);
    const uint64_t negative = lowest_bits(bytes >> 7);
    minus |= negative << i;
    plus |= (lowest_bits(bytes) & ~negative) << i;
  }
  return ternary;
}

}  // namespace

bool is_valid(const PlaneView& p) {
  return p.width >= 0 && p.width <= kMaxSide && p.height >= 0 && p.height <= kMaxSide &&
         p.row_words >= words_for(p.width) && (p.words != nullptr || p.width == 0 || p.height == 0);
}

Status pack_ternary(const int8_t* pixels, size_t stride, size_t step, int width, int height, uint64_t* plus,
                    uint64_t* minus, int row_words) noexcept {
  if (!is_valid({plus, width, height, row_words}) || !is_valid({minus, width, height, row_words}))
    return Status::kBadArgument;
  if (width == 0 || height == 0) return Status::kOk;
  if (pixels == nullptr || step == 0 || stride < size_t(width - 1) * step + 1) return Status::kBadArgument;
  bool ternary = true;
  for (int y = 0; y < height; ++y) {
    const int8_t* row = pixels + size_t(y) * stride;
    for (int x = 0; x < width; x += 64)
      ternary &= pack_word(row + size_t(x) * step, step, std::min(64, width - x), plus[x / 64], minus[x / 64]);
    std::fill(plus + words_for(width), plus + row_words, 0);
    std::fill(minus + words_for(width), minus + row_words, 0);
    plus += row_words;
    minus += row_words;
  }
  return ternary ? Status::kOk : Status::kBadPixel;
}

Status extract(const PlaneView& from, int column, int row, int width, int height, uint64_t* out,
               int row_words) noexcept {
  if (!is_valid(from) || !is_valid({out, width, height, row_words}) || column < 0 || row < 0 ||
      column > from.width - width || row > from.height - height)
    return Status::kBadArgument;
  if (width == 0 || height == 0) return Status::kOk;
  const int words = words_for(width), available = words_for(from.width) - column / 64, shift = column % 64;
  for (int y = 0; y < height; ++y, out += row_words) {
    const uint64_t* in = from.words + size_t(row + y) * size_t(from.row_words) + column / 64;
    for (int k = 0; k < words; ++k) {
      const uint64_t next = k + 1 < available ? in[k + 1] : 0;
      out[k] = in[k] >> shift | next << 1 << (63 - shift);
    }
    out[words - 1] &= last_word_mask(width);
    std::fill(out + words, out + row_words, 0);
  }
  return Status::kOk;
}

}  // namespace landfix::kernels
