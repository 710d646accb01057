// A patch as look-ups in the tables of by_tables.h.
#pragma once

#include "runtime/kernels/engine.h"

namespace landfix::kernels {

/// Columns that one look-up covers.
constexpr int look_up_width(int channels) { return channels > 2 ? 1 : kDigits / channels; }

/// The most look-ups that a band has per row, padding to kLookUpsTogether included.
constexpr int look_ups_per_row(int channels) { return kBandPixels / look_up_width(channels); }

/// The look-ups of a band of the patch from `first_column` (a multiple of kBandPixels) on.
/// `steps` has room for kSlots, `row_begin` for patch_height + 1, `look_ups` for patch_height *
/// look_ups_per_row(channels).
Band make_band(const Problem& problem, int first_column, TableStep* steps, uint16_t* look_ups, uint32_t* row_begin);

}  // namespace landfix::kernels
