// How far off the position may be: the distribution of the estimate's error along a flight, over all that may happen.
//
// The filter's error is linear in its causes (odometry's constant drift, constant errors of the fixes, white noise)
// once it is known which images gave a fix. Which did is random, so the error is a mixture of Gaussians, one for every
// history of fixes. Histories that led to nearly the same are merged (moments are kept), to a fixed number.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "tools/route/error_model.h"

namespace landfix::route {

/// One merged history. The error is Gaussian with mean 0 and covariance drift·driftᵀ + bias·biasᵀ + noise. Errors of
/// matches of the same ground are alike: they follow a process of unit variance, whose correlation between two images
/// is that of their outcomes.
struct Hypothesis {
  double weight = 1;
  bool fixed = false;            ///< the last image gave a true fix
  double last_probability = -1;  ///< that the last image had for a true fix; negative before the first
  double since_fix_m = 0;        ///< flown since the last fix; infinite before the first
  Eigen::Matrix2d filter_m2;     ///< what the filter believes its covariance to be
  Eigen::Matrix2d drift;         ///< response to the flight's constant drift, of unit variance
  Eigen::Matrix2d bias;          ///< response to the fixes' constant error, of unit variance
  Eigen::Matrix2d noise_m2;      ///< all else
  Eigen::Matrix2d match;         ///< covariance of that with the process of the matches' errors

  Eigen::Matrix2d error_m2() const { return drift * drift.transpose() + bias * bias.transpose() + noise_m2; }
};

/// What the image offers to a filter of this standard deviation (its wider axis).
using ViewFunction = std::function<const View&(double filter_sigma_m)>;

/// What the filter makes of one fix; shared with the simulation (simulate.h), so that both speak of one model.
struct FixUpdate {
  Eigen::Matrix2d gain, filter_m2;
};
FixUpdate fix_update(const View& view, const Eigen::Matrix2d& filter_m2, double since_fix_m, double independent_m);

/// The symmetric root of a covariance: times a process of unit variance the error of a match.
Eigen::Matrix2d root(const Eigen::Matrix2d& covariance_m2);

/// Probability of a true fix given what happened to the image before, `correlation` being that of both outcomes.
double fix_probability_given(bool fixed, double last_probability, double probability, double correlation);

/// A false fix lies anywhere in the region that was searched: its standard deviation per axis for this half-width.
inline double false_sigma_m(double search_half_m) { return search_half_m / std::sqrt(3.0); }

class Belief {
 public:
  /// Where GNSS ends. `hypotheses`: so many are kept, at least 4.
  Belief(const ErrorModel& errors, int hypotheses = 16);

  /// Odometry over a distance at a height above ground.
  void fly(double distance_m, double agl_m, const ErrorModel& errors);

  /// An image. `correlation`: of its outcome and of its match's error with those of the image before.
  void look(const ViewFunction& view, double correlation, double independent_m);

  Eigen::Matrix2d covariance_m2() const;
  double rms_m() const { return std::sqrt(covariance_m2().trace()); }
  double within(double radius_m) const;      ///< probability that the error is smaller
  double radius_m(double confidence) const;  ///< that the error does not exceed with this probability, to a millimetre
  double filter_rms_m() const;               ///< what the filter believes, root mean square over the hypotheses
  const std::vector<Hypothesis>& hypotheses() const { return hypotheses_; }

 private:
  int limit_;
  std::vector<Hypothesis> hypotheses_;
};

/// Probability that a Gaussian with mean 0 stays within a circle.
double within_circle(const Eigen::Matrix2d& covariance_m2, double radius_m);

}  // namespace landfix::route
