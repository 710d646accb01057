// Correlation of ternary images and counts of common pixels over a rectangle of shifts, by integer arithmetic: the same
// sums on every processor.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "runtime/kernels/kernel.h"
#include "runtime/kernels/planes.h"
#include "runtime/kernels/status.h"
#include "runtime/kernels/workspace.h"

namespace landfix::kernels {

inline constexpr int kMaxPatchSide = 2048;
/// Channels of a ternary correlation, planes of a count.
inline constexpr int kMaxChannels = 4;

/// Places of the patch in the window: its left upper pixel is at begin_x <= column < end_x, begin_y <= row < end_y of
/// the window.
struct Shifts {
  int begin_x = 0, end_x = 0, begin_y = 0, end_y = 0;
  int width() const { return end_x - begin_x; }
  int height() const { return end_y - begin_y; }
};

/// All shifts with the patch wholly inside of the window; none where it is larger.
Shifts all_shifts(const PlaneView& window, const PlaneView& patch) noexcept;

/// For every shift the sum, over pixels and channels, of window * patch, both of -1, 0 and 1: planes +1 and -1 of each
/// channel in turn, 2 * channels of them (a pixel set in both counts as 0). The sum of a shift goes to
/// sums[(y - begin_y) * row_stride + (x - begin_x)].
///
/// kBadArgument: other than 1 to kMaxChannels channels, window and patch of different channels, planes that are not
/// valid or not all of one size, a patch without pixels or beyond kMaxPatchSide, shifts that take it out of the window,
/// sums too short. No shifts at all are no error. Nothing is written unless kOk.
Status correlate_ternary(std::span<const PlaneView> window, std::span<const PlaneView> patch, const Shifts& shifts,
                         std::span<int32_t> sums, size_t row_stride, Workspace& workspace,
                         Kernel kernel = best_kernel()) noexcept;

/// For every shift the number of pixels that are set in window and patch, summed over the planes, plane by plane: what
/// of a map is under a mask, or (mask against every plane) the energy of a ternary image there. Up to kMaxChannels
/// planes; otherwise as correlate_ternary.
Status count_common(std::span<const PlaneView> window, std::span<const PlaneView> patch, const Shifts& shifts,
                    std::span<int32_t> counts, size_t row_stride, Workspace& workspace,
                    Kernel kernel = best_kernel()) noexcept;

inline Status count_common(const PlaneView& window, const PlaneView& patch, const Shifts& shifts,
                           std::span<int32_t> counts, size_t row_stride, Workspace& workspace,
                           Kernel kernel = best_kernel()) noexcept {
  return count_common(std::span(&window, 1), std::span(&patch, 1), shifts, counts, row_stride, workspace, kernel);
}

}  // namespace landfix::kernels
