// Exact coordinate transformations at the price of a polynomial.
//
// A projection costs a fraction of a microsecond per pixel, several times the resampling itself, and is extremely
// smooth. So it is interpolated in square cells of the pixel grid by polynomials of degree 4 in each direction through
// its exact values at 5x5 Chebyshev points. In every cell the polynomial is compared with the exact function at the 6x6
// extrema of the first neglected term, corners included; where it errs by more than the tolerance the cell is cut in
// four, and the smallest cells are computed exactly, pixel by pixel. Cells lie at fixed places of the grid: a pixel's
// value does not depend on the window.
#pragma once

#include <functional>
#include <opencv2/core.hpp>

#include "builder/ingest/pixel_window.h"

namespace landfix::ingest {

inline constexpr int64_t kLargestCell = 1024;  ///< pixels; a power of two
inline constexpr int64_t kSmallestCell = 32;   ///< smaller ones would cost more than computing every pixel

/// Replaces pixel coordinates (column, row; x.5 is a centre) by function values, in place; NaN or infinity where there
/// are none.
using PointFunction = std::function<void(int count, double* x, double* y)>;

/// A cell of the pixel grid: columns [column, column + side), likewise rows; both are multiples of `side`.
struct Cell {
  int64_t column = 0, row = 0, side = kLargestCell;
};

/// Calls `visit` with every largest cell that `window` touches and the part of the window in it, relative to the
/// window.
void for_each_cell(const PixelWindow& window, const std::function<void(const Cell&, const cv::Rect&)>& visit);

/// Evaluates `exact` at the centres of the pixels of `part` (relative to `window`), which lies in `cell`, to within
/// `tolerance` at the check points. `x`, `y`: CV_64FC1 of the window's size; only `part` is written. Returns how many
/// pixels were computed exactly.
int64_t evaluate_in_cell(const PointFunction& exact, double tolerance, const PixelWindow& window, const Cell& cell,
                         const cv::Rect& part, cv::Mat& x, cv::Mat& y);

}  // namespace landfix::ingest
