// The true motion of the simulated aircraft: pose as a function of time.
#pragma once

#include <vector>

#include "tools/fly/flight.h"

namespace landfix::fly {

/// Immutable once made.
class Trajectory {
 public:
  /// Reads the terrain along the route. Throws Error (kNoData) where the scene has no ground below the route.
  Trajectory(const terrain::Scene& scene, const Route& route, const FlightOptions& options, uint64_t seed);

  double duration_s() const { return duration_s_; }
  double distance_m(double time_s) const { return options_.speed_mps * time_s; }
  terrain::Pose at(double time_s) const;

 private:
  double height_at(double distance_m) const;
  double curvature_at(double distance_m) const;

  const Route& route_;
  FlightOptions options_;
  double duration_s_;
  double profile_step_m_ = 0;
  std::vector<double>
      profile_m_;  ///< flight heights at multiples of the step along the route; empty at constant altitude
  std::array<double, 6> phases_;
};

}  // namespace landfix::fly
