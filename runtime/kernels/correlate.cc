#include "runtime/kernels/correlate.h"

#include <algorithm>

#include "runtime/kernels/engine.h"
#include "runtime/kernels/method.h"
#include "runtime/kernels/tables.h"

namespace landfix::kernels {
namespace {

static_assert(kMaxChannels == kChannels);

constexpr int round_up(int value, int to) { return (value + to - 1) / to * to; }

/// Hands out a workspace in aligned pieces; with no base it only adds up what is needed.
class Pieces {
 public:
  explicit Pieces(std::byte* base) : base_(base) {}
  template <typename T>
  T* take(size_t count) {
    T* piece = base_ == nullptr ? nullptr : reinterpret_cast<T*>(base_ + used_);
    used_ += (count * sizeof(T) + kAlignment - 1) / kAlignment * kAlignment;
    return piece;
  }
  size_t used() const { return used_; }

 private:
  std::byte* base_;
  size_t used_ = 0;
};

/// All buffers of a correlation.
struct Buffers {
  SignedBits shifted;          // by bits
  TableStep* steps = nullptr;  // by tables, and the rest
  uint16_t* look_ups = nullptr;
  uint32_t* row_begin = nullptr;
  int8_t* tables = nullptr;
  int16_t* row_sums = nullptr;
};

SignedBits take_bits(Pieces& pieces, int channels, int columns, int column_size) {
  const size_t words = size_t(channels) * size_t(columns) * size_t(column_size);
  return {pieces.take<uint64_t>(words), pieces.take<uint64_t>(words), columns, column_size};
}

/// Lays out the buffers of `problem`, whose sizes are known, and of its method.
Buffers lay_out(Problem& p, Method method, Pieces& pieces) {
  const int rows = p.shifts_y - 1 + p.patch_height;
  // A column of words more than there are pixels: what is shifted in at the right.
  p.window = take_bits(pieces, p.channels, words_for(p.shifts_x - 1 + p.patch_width) + 1, rows);
  p.patch = take_bits(pieces, p.channels, words_for(p.patch_width), round_up(p.patch_height, kRowPadding));
  Buffers b;
  if (method == Method::kBits) {
    b.shifted = take_bits(pieces, p.channels, p.patch.columns, round_up(rows, kRowPadding) + kRowPadding);
    return b;
  }
  b.steps = pieces.take<TableStep>(kSlots);
  b.look_ups = pieces.take<uint16_t>(size_t(p.patch_height) * size_t(look_ups_per_row(p.channels)));
  b.row_begin = pieces.take<uint32_t>(size_t(p.patch_height) + 1);
  b.tables = pieces.take<int8_t>(kTableScratch);
  b.row_sums = pieces.take<int16_t>(size_t(p.shifts_y) * size_t(kStripPixels));
  return b;
}

/// Up to 64 pixels of a row from column x on; zero beyond its width.
uint64_t bits_at(const PlaneView& plane, int row, int x) {
  if (x >= plane.width) return 0;
  const uint64_t* word = plane.words + size_t(row) * size_t(plane.row_words) + x / 64;
  const uint64_t next = x / 64 + 1 < words_for(plane.width) ? word[1] : 0;
  const uint64_t bits = word[0] >> (x % 64) | next << 1 << (63 - x % 64);
  const int left = plane.width - x;
  return left < 64 ? bits & ((uint64_t{1} << left) - 1) : bits;
}

/// Reads `rows` rows of one channel from (x, y) on; `minus` is null for a channel that is never negative.
void load(const PlaneView& plus, const PlaneView* minus, int x, int y, int rows, int channel, const SignedBits& out) {
  for (int k = 0; k < out.columns; ++k) {
    const size_t first = size_t(channel * out.columns + k) * size_t(out.column_size);
    for (int row = 0; row < rows; ++row) {
      const uint64_t p = bits_at(plus, y + row, x + 64 * k);
      const uint64_t m = minus == nullptr ? 0 : bits_at(*minus, y + row, x + 64 * k);
      out.nonzero[first + size_t(row)] = p ^ m;
      out.negative[first + size_t(row)] = m & ~p;
    }
    std::fill(out.nonzero + first + rows, out.nonzero + first + out.column_size, 0);
    std::fill(out.negative + first + rows, out.negative + first + out.column_size, 0);
  }
}

void by_tables(const Problem& p, const Engine& engine, const Buffers& b, int32_t* sums, int64_t row_stride) {
  for (int y = 0; y < p.shifts_y; ++y) std::fill_n(sums + y * row_stride, p.shifts_x, 0);
  for (int column = 0; column < p.patch_width; column += kBandPixels) {
    const Band band = make_band(p, column, b.steps, b.look_ups, b.row_begin);
    engine.by_tables(p, band, b.tables, b.row_sums, sums, row_stride);
  }
}

/// Of finding the look-up of a few pixels, in the unit of the engines' costs.
constexpr double kLookUpCost = 4;

/// The cheaper way, by counts of registers.
Method choose(const Problem& p, const Engine& engine) {
  const double patch_words = double(p.channels) * words_for(p.patch_width) * p.patch_height;
  const double bits = patch_words * p.shifts_x * p.shifts_y * engine.bits_cost;
  const double look_ups = double(p.patch_height) * p.patch_width / look_up_width(p.channels);
  const double rows = double(p.shifts_y) - 1 + p.patch_height;
  const double registers = double(round_up(p.shifts_x, engine.bytes)) / engine.bytes;
  const double tables =
      (look_ups * p.shifts_y * registers + rows * kSlots * (registers + double(p.patch_width) / engine.bytes)) *
          engine.tables_cost +
      look_ups * kLookUpCost;
  return tables < bits ? Method::kTables : Method::kBits;
}

bool same_size(std::span<const PlaneView> planes) {
  return std::ranges::all_of(planes, [&](const PlaneView& p) {
    return is_valid(p) && p.width == planes[0].width && p.height == planes[0].height;
  });
}

bool fits(const PlaneView& window, const PlaneView& patch, const Shifts& s) {
  const Shifts all = all_shifts(window, patch);
  return patch.width >= 1 && patch.height >= 1 && patch.width <= kMaxPatchSide && patch.height <= kMaxPatchSide &&
         s.begin_x >= 0 && s.begin_y >= 0 && s.begin_x <= s.end_x && s.begin_y <= s.end_y && s.end_x <= all.end_x &&
         s.end_y <= all.end_y;
}

bool has_room(std::span<const int32_t> sums, size_t row_stride, const Shifts& s) {
  const size_t width = size_t(s.width()), height = size_t(s.height());
  return row_stride >= width && sums.size() >= width && (sums.size() - width) / row_stride >= height - 1;
}

}  // namespace

Shifts all_shifts(const PlaneView& window, const PlaneView& patch) noexcept {
  return {0, std::max(0, window.width - patch.width + 1), 0, std::max(0, window.height - patch.height + 1)};
}

Status correlate(std::span<const PlaneView> window, std::span<const PlaneView> patch, bool signs, const Shifts& shifts,
                 std::span<int32_t> sums, size_t row_stride, Workspace& workspace, Kernel kernel,
                 std::optional<Method> forced) noexcept {
  const size_t planes = signs ? 2 : 1;
  if (window.empty() || window.size() != patch.size() || window.size() % planes != 0 ||
      window.size() / planes > size_t(kMaxChannels) || !same_size(window) || !same_size(patch) ||
      !fits(window[0], patch[0], shifts))
    return Status::kBadArgument;
  const Engine* engine = engine_of(kernel);
  if (engine == nullptr) return Status::kUnavailable;
  if (shifts.width() == 0 || shifts.height() == 0) return Status::kOk;
  if (!has_room(sums, row_stride, shifts)) return Status::kBadArgument;

  Problem problem;
  problem.channels = int(window.size() / planes);
  problem.patch_width = patch[0].width;
  problem.patch_height = patch[0].height;
  problem.shifts_x = shifts.width();
  problem.shifts_y = shifts.height();
  const Method method = forced.value_or(choose(problem, *engine));
  Pieces sizes(nullptr);
  lay_out(problem, method, sizes);
  std::byte* memory = workspace.reserve(sizes.used());
  if (memory == nullptr) return Status::kOutOfMemory;
  Pieces pieces(memory);
  const Buffers buffers = lay_out(problem, method, pieces);

  const int rows = problem.shifts_y - 1 + problem.patch_height;
  for (size_t c = 0; c < window.size(); c += planes) {
    load(window[c], signs ? &window[c + 1] : nullptr, shifts.begin_x, shifts.begin_y, rows, int(c / planes),
         problem.window);
    load(patch[c], signs ? &patch[c + 1] : nullptr, 0, 0, problem.patch_height, int(c / planes), problem.patch);
  }
  if (method == Method::kBits)
    engine->by_bits(problem, buffers.shifted, sums.data(), int64_t(row_stride));
  else
    by_tables(problem, *engine, buffers, sums.data(), int64_t(row_stride));
  return Status::kOk;
}

Status correlate_ternary(std::span<const PlaneView> window, std::span<const PlaneView> patch, const Shifts& shifts,
                         std::span<int32_t> sums, size_t row_stride, Workspace& workspace, Kernel kernel) noexcept {
  return correlate(window, patch, true, shifts, sums, row_stride, workspace, kernel, std::nullopt);
}

Status count_common(std::span<const PlaneView> window, std::span<const PlaneView> patch, const Shifts& shifts,
                    std::span<int32_t> counts, size_t row_stride, Workspace& workspace, Kernel kernel) noexcept {
  return correlate(window, patch, false, shifts, counts, row_stride, workspace, kernel, std::nullopt);
}

}  // namespace landfix::kernels
