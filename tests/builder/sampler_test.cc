// Coordinates by polynomials, and resampling at them.
#include "builder/ingest/sampler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "builder/ingest/smooth_map.h"

namespace landfix::ingest {
namespace {

// ------------------------------------------------------------------------------------------------------------

TEST(SmoothMap, AgreesWithTheExactFunctionAndIsCheap) {
  // Curvature as of a map projection at 0.5 m: 6e-9 px per px^2. One cell is enough, and errors stay below a millionth.
  int calls = 0;
  const auto function = [&](int count, double* x, double* y) {
    calls += count;
    for (int i = 0; i < count; ++i) {
      const double u = x[i], v = y[i];
      x[i] = 3 + 0.98 * u - 0.02 * v + 6e-9 * u * v;
      y[i] = 7 + 0.02 * u + 0.98 * v + 6e-9 * (u * u - v * v);
    }
  };
  const PixelWindow window{0.5, -30, 200, 300, 100};
  cv::Mat x(100, 300, CV_64FC1), y(100, 300, CV_64FC1);
  int64_t exact_pixels = 0;
  for_each_cell(window, [&](const Cell& cell, const cv::Rect& part) {
    exact_pixels += evaluate_in_cell(function, 1e-4, window, cell, part, x, y);
  });
  EXPECT_EQ(exact_pixels, 0);
  EXPECT_EQ(calls, 2 * 61);  // two cells, left and right of column 0, of 25 nodes and 36 checks
  for (int row = 0; row < 100; ++row) {
    for (int column = 0; column < 300; ++column) {
      double u = window.column + column + 0.5, v = window.row + row + 0.5;
      function(1, &u, &v);
      ASSERT_NEAR(x.at<double>(row, column), u, 1e-6);
      ASSERT_NEAR(y.at<double>(row, column), v, 1e-6);
    }
  }
}

TEST(SmoothMap, FallsBackToExactValuesWhereAPolynomialErrs) {
  // A kink at column 500.3 and a wave of 40 px: no polynomial of degree 4 over 32 px meets 1e-4, so that every pixel
  // near the kink must be exact; NaN (no value) must come through as NaN.
  const auto function = [](int count, double* x, double* y) {
    for (int i = 0; i < count; ++i) {
      const double u = x[i];
      x[i] = u + std::abs(u - 500.3) + 3 * std::sin(u / 6);
      y[i] = u < 450 ? std::numeric_limits<double>::quiet_NaN() : y[i];
    }
  };
  const PixelWindow window{1, 400, 0, 200, 40};
  cv::Mat x(40, 200, CV_64FC1), y(40, 200, CV_64FC1);
  int64_t exact_pixels = 0;
  for_each_cell(window, [&](const Cell& cell, const cv::Rect& part) {
    exact_pixels += evaluate_in_cell(function, 1e-4, window, cell, part, x, y);
  });
  EXPECT_GT(exact_pixels, 32 * 40);
  for (int row = 0; row < 40; ++row) {
    for (int column = 0; column < 200; ++column) {
      double u = 400.5 + column, v = row + 0.5;
      function(1, &u, &v);
      ASSERT_NEAR(x.at<double>(row, column), u, 2e-4) << column;
      ASSERT_EQ(std::isnan(y.at<double>(row, column)), std::isnan(v)) << column;
    }
  }
}

TEST(Sampler, BilinearAndItsLimits) {
  Patch patch{(cv::Mat_<uchar>(2, 2) << 0, 100, 200, 40), {}, 10, 20};
  const auto sample = [&](double x, double y, const Patch& p, uchar& valid) {
    cv::Mat out = cv::Mat::zeros(1, 1, CV_8UC1), mask = cv::Mat::zeros(1, 1, CV_8UC1);
    resample(p, cv::Mat(1, 1, CV_64FC1, x), cv::Mat(1, 1, CV_64FC1, y), {1, 1}, out, mask);
    valid = mask.at<uchar>(0);
    return int(out.at<uchar>(0));
  };
  uchar valid = 0;
  EXPECT_EQ(sample(10.5, 20.5, patch, valid), 0);  // centre of the first pixel
  EXPECT_EQ(sample(11.5, 20.5, patch, valid), 100);
  EXPECT_EQ(sample(11.0, 21.0, patch, valid), 85);   // mean of all four
  EXPECT_EQ(sample(10.75, 20.5, patch, valid), 25);  // a quarter of the way
  EXPECT_EQ(sample(10.0, 20.0, patch, valid), 0);    // the outer corner: a quarter of the weight is enough
  EXPECT_EQ(valid, 255);
  sample(9.8, 20.0, patch, valid);  // beyond it: 0.3 * 0.5 of the weight
  EXPECT_EQ(valid, 0);
  sample(std::numeric_limits<double>::quiet_NaN(), 20.5, patch, valid);
  EXPECT_EQ(valid, 0);
  patch.valid = (cv::Mat_<uchar>(2, 2) << 0, 255, 255, 255);
  // Without the first pixel: (100 * 3 + 200 * 3 + 40 * 1) / 7 at a quarter from it each way, weights 3/16, 3/16, 1/16.
  EXPECT_EQ(sample(10.75, 20.75, patch, valid), 134);
  EXPECT_EQ(valid, 255);
  sample(10.5, 20.5, patch, valid);
  EXPECT_EQ(valid, 0);
}

}  // namespace
}  // namespace landfix::ingest
