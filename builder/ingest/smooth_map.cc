#include "builder/ingest/smooth_map.h"

#include <array>
#include <cmath>
#include <numbers>

namespace landfix::ingest {
namespace {

constexpr int kNodes = 5;
constexpr int kChecks = kNodes + 1;
constexpr int kPoints = kNodes * kNodes + kChecks * kChecks;

using Row = std::array<double, kNodes>;

double horner(const Row& c, double t) { return c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * c[4]))); }

/// Coefficients of powers of t of the polynomial through values at the Chebyshev points cos(pi (k + 1/2) / 5).
Row power_coefficients(const Row& values) {
  Row c{};
  for (int j = 0; j < kNodes; ++j) {
    for (int k = 0; k < kNodes; ++k) c[j] += values[k] * std::cos(std::numbers::pi * j * (k + 0.5) / kNodes);
    c[j] *= (j == 0 ? 1.0 : 2.0) / kNodes;
  }
  return {c[0] - c[2] + c[4], c[1] - 3 * c[3], 2 * c[2] - 8 * c[4], 4 * c[3], 8 * c[4]};
}

/// A polynomial of degree 4 in each of two variables in [-1, 1]; along a row it becomes one in the first.
struct Polynomial {
  std::array<Row, kNodes> of_power;  ///< [power of the first variable][power of the second]

  Row along_row(double second) const {
    Row r;
    for (int i = 0; i < kNodes; ++i) r[i] = horner(of_power[i], second);
    return r;
  }
};

/// `values`: row by row, at the Chebyshev points of both variables.
Polynomial through(const double* values) {
  std::array<Row, kNodes> by_row;  // coefficients in the first variable, per node of the second
  for (int r = 0; r < kNodes; ++r) {
    Row v;
    for (int c = 0; c < kNodes; ++c) v[c] = values[r * kNodes + c];
    by_row[r] = power_coefficients(v);
  }
  Polynomial p;
  for (int i = 0; i < kNodes; ++i) {
    Row v;
    for (int r = 0; r < kNodes; ++r) v[r] = by_row[r][i];
    p.of_power[i] = power_coefficients(v);
  }
  return p;
}

struct Fit {
  Polynomial x, y;
  bool good = false;
};

Fit fit(const PointFunction& exact, double tolerance, const Cell& cell) {
  std::array<double, kPoints> s, t, x, y;
  int n = 0;
  const auto add_grid = [&](int count, double shift, int divisor) {
    for (int r = 0; r < count; ++r) {
      for (int c = 0; c < count; ++c, ++n) {
        s[n] = std::cos(std::numbers::pi * (c + shift) / divisor);
        t[n] = std::cos(std::numbers::pi * (r + shift) / divisor);
      }
    }
  };
  add_grid(kNodes, 0.5, kNodes);
  add_grid(kChecks, 0, kChecks - 1);
  const double half = 0.5 * double(cell.side);
  for (int i = 0; i < kPoints; ++i) {
    x[i] = double(cell.column) + half * (1 + s[i]);
    y[i] = double(cell.row) + half * (1 + t[i]);
  }
  exact(kPoints, x.data(), y.data());
  Fit f{through(x.data()), through(y.data()), true};
  for (int i = kNodes * kNodes; i < kPoints; ++i) {
    const double error_x = horner(f.x.along_row(t[i]), s[i]) - x[i], error_y = horner(f.y.along_row(t[i]), s[i]) - y[i];
    // NaN and infinity fail, too.
    if (!(std::abs(error_x) <= tolerance && std::abs(error_y) <= tolerance)) return {f.x, f.y, false};
  }
  return f;
}

void evaluate_fit(const Fit& f, const PixelWindow& window, const Cell& cell, const cv::Rect& part, cv::Mat& x,
                  cv::Mat& y) {
  // Sides are powers of two, so that these steps are exact wherever the window begins.
  const double step = 2.0 / double(cell.side);
  const int64_t first_column = window.column + part.x - cell.column;
  for (int r = part.y; r < part.y + part.height; ++r) {
    const double t = (double(window.row + r - cell.row) + 0.5) * step - 1;
    const Row row_x = f.x.along_row(t), row_y = f.y.along_row(t);
    double* out_x = x.ptr<double>(r) + part.x;
    double* out_y = y.ptr<double>(r) + part.x;
    for (int c = 0; c < part.width; ++c) {
      const double s = (double(first_column + c) + 0.5) * step - 1;
      out_x[c] = horner(row_x, s);
      out_y[c] = horner(row_y, s);
    }
  }
}

void evaluate_exactly(const PointFunction& exact, const PixelWindow& window, const cv::Rect& part, cv::Mat& x,
                      cv::Mat& y) {
  for (int r = part.y; r < part.y + part.height; ++r) {
    double* out_x = x.ptr<double>(r) + part.x;
    double* out_y = y.ptr<double>(r) + part.x;
    for (int c = 0; c < part.width; ++c) {
      out_x[c] = double(window.column + part.x + c) + 0.5;
      out_y[c] = double(window.row + r) + 0.5;
    }
    exact(part.width, out_x, out_y);
  }
}

}  // namespace

void for_each_cell(const PixelWindow& w, const std::function<void(const Cell&, const cv::Rect&)>& visit) {
  // The mask rounds towards minus infinity: cells of negative columns are aligned like all others.
  const cv::Rect all(0, 0, int(w.width), int(w.height));
  for (int64_t row = w.row & -kLargestCell; row < w.row + w.height; row += kLargestCell) {
    for (int64_t column = w.column & -kLargestCell; column < w.column + w.width; column += kLargestCell) {
      visit({column, row, kLargestCell},
            cv::Rect(int(column - w.column), int(row - w.row), int(kLargestCell), int(kLargestCell)) & all);
    }
  }
}

int64_t evaluate_in_cell(const PointFunction& exact, double tolerance, const PixelWindow& window, const Cell& cell,
                         const cv::Rect& part, cv::Mat& x, cv::Mat& y) {
  const Fit f = fit(exact, tolerance, cell);
  if (f.good) {
    evaluate_fit(f, window, cell, part, x, y);
    return 0;
  }
  if (cell.side == kSmallestCell) {
    evaluate_exactly(exact, window, part, x, y);
    return int64_t(part.area());
  }
  int64_t exact_pixels = 0;
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const int64_t side = cell.side / 2;
    const Cell child{cell.column + (quadrant & 1) * side, cell.row + (quadrant >> 1) * side, side};
    const cv::Rect child_part =
        part & cv::Rect(int(child.column - window.column), int(child.row - window.row), int(side), int(side));
    if (!child_part.empty()) exact_pixels += evaluate_in_cell(exact, tolerance, window, child, child_part, x, y);
  }
  return exact_pixels;
}

}  // namespace landfix::ingest
