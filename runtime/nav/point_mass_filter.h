// Bayes' recursion for a position in the plane on a grid of point masses: any distribution, several modes included.
#pragma once

#include <array>
#include <opencv2/core.hpp>

#include "runtime/nav/likelihood.h"
#include "runtime/nav/status.h"

namespace landfix::nav {

struct PointMassFilterOptions {
  double min_cell_m = 0.25;  ///< finest spacing of the masses; coarser ones are this times a power of two
  int max_cells = 401;       ///< per side; at least 32
};

/// Point-mass filter (Conte 2009 eq. 5.24–5.31). The grid moves with the odometry, grows and coarsens with the
/// uncertainty and shrinks and refines with it; a change of the grid keeps mean and total and drops at most 1e-4 of the
/// probability, at its rim. Masses are doubles: after a few updates the rival modes that must be able to come back are
/// 1e-12 of the highest, and the moments are differences. Nothing throws; what is refused leaves the state unchanged.
class PointMassFilter {
 public:
  explicit PointMassFilter(const PointMassFilterOptions& options = {});

  /// A Gaussian with this standard deviation per axis. kNotFinite; kBadValue for a negative sigma or options out of
  /// range.
  Status start(double east_m, double north_m, double sigma_m);

  /// Eq. 5.31 and 5.26: moves the grid by a displacement, exactly, and convolves with a Gaussian of these standard
  /// deviations. kNotStarted, kNotFinite, kBadValue.
  Status predict(double displacement_east_m, double displacement_north_m, double sigma_east_m, double sigma_north_m);

  /// Eq. 5.27–5.28. `likelihood` is interpolated bilinearly and must not be narrower than about half a cell (`cell_m`).
  /// kNotStarted, kBadImage, kNotFinite, kBadValue (negative), kLost (the product is 0 everywhere).
  Status update(const Likelihood& likelihood);

  struct Moments {
    double east_m = 0, north_m = 0;
    std::array<double, 4> covariance_m2{};  ///< row-major over (east, north)
  };
  /// Minimum-variance estimate and its covariance (eq. 5.29, 5.30), to which 1/12 cell² per axis is added: the spread
  /// within a cell.
  Moments moments() const;

  struct Bounds {
    double west_m, south_m, east_m, north_m;
  };
  /// The rectangle beyond each side of which lies at most this probability.
  Bounds bounds(double tail_probability) const;

  bool started() const { return !mass_.empty(); }
  double cell_m() const { return cell_m_; }
  /// Probability per grid point, CV_64F, sums to 1; the point (row 0, column 0) is the north-western one.
  const cv::Mat& masses() const { return mass_; }
  double west_m() const { return west_m_; }    ///< easting of column 0
  double north_m() const { return north_m_; }  ///< northing of row 0

 private:
  cv::Rect box(double tail_probability) const;
  void fit(double margin_m);
  void crop(const cv::Rect& target);
  void coarsen();
  void refine();

  PointMassFilterOptions options_;
  cv::Mat mass_;
  double west_m_ = 0, north_m_ = 0, cell_m_ = 0;
};

}  // namespace landfix::nav
