#include "runtime/kernels/tables.h"

#include <algorithm>
#include <bit>
#include <iterator>

namespace landfix::kernels {
namespace {

/// Numbers the groups of pixels that occur. A key has a bit per digit for "not zero" (below) and one for "-1" (above);
/// digit = channel * columns per look-up + column.
class Slots {
 public:
  Slots(int width, TableStep* steps) : width_(width), steps_(steps) {
    std::fill(std::begin(slot_), std::end(slot_), kNone);
    slot_[0] = 0;
  }

  int count() const { return count_; }
  int of(unsigned key) {
    if (slot_[key] == kNone) slot_[key] = add(key);
    return slot_[key];
  }

 private:
  uint8_t add(unsigned key) {
    const int digit = std::bit_width(key & kNonzero) - 1;
    const int parent = of(key & ~(kBothBits << digit));
    steps_[count_ - 1] = {uint8_t(parent), uint8_t(digit / width_), uint8_t(digit % width_),
                          (key >> kDigits >> digit & 1) != 0};
    return uint8_t(count_++);
  }

  static constexpr uint8_t kNone = 255;
  static constexpr unsigned kNonzero = (1u << kDigits) - 1, kBothBits = 1u << kDigits | 1u;
  int width_;
  TableStep* steps_;
  int count_ = 1;
  uint8_t slot_[1 << 2 * kDigits];
};

/// The keys of the look-ups in `columns` columns of one row, up to 64 of them from word column `word` on.
template <typename Visit>
void for_each_key(const Problem& p, int row, int word, int columns, int width, Visit visit) {
  uint64_t nonzero[kChannels] = {}, negative[kChannels] = {};
  for (int c = 0; c < p.channels; ++c) {
    const size_t at = size_t(c * p.patch.columns + word) * size_t(p.patch.column_size) + size_t(row);
    nonzero[c] = p.patch.nonzero[at];
    negative[c] = p.patch.negative[at];
  }
  const uint64_t mask = (uint64_t{1} << width) - 1;
  for (int x = 0; x < columns; x += width) {
    uint64_t key = 0;
    for (int c = 0; c < p.channels; ++c)
      key |= (nonzero[c] >> x & mask) << (c * width) | (negative[c] >> x & mask) << (c * width + kDigits);
    visit(x, unsigned(key));
  }
}

}  // namespace

Band make_band(const Problem& p, int first_column, TableStep* steps, uint16_t* look_ups, uint32_t* row_begin) {
  const int band_width = std::min(kBandPixels, p.patch_width - first_column), width = look_up_width(p.channels);
  Slots slots(width, steps);
  uint32_t count = 0;
  for (int row = 0; row < p.patch_height; ++row) {
    row_begin[row] = count;
    for (int x = 0; x < band_width; x += 64) {
      for_each_key(p, row, (first_column + x) / 64, std::min(64, band_width - x), width, [&](int column, unsigned key) {
        const int slot = slots.of(key);
        look_ups[count] = uint16_t(slot * kTablePixels + x + column);
        count += slot != 0;  // no branch: it would be mispredicted
      });
    }
    while (count % kLookUpsTogether != 0) look_ups[count++] = 0;  // slot 0 adds nothing
  }
  row_begin[p.patch_height] = count;
  return {first_column, band_width, steps, slots.count(), look_ups, row_begin};
}

}  // namespace landfix::kernels
