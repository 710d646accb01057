// Flights drawn from the model that belief.h follows in closed form: what that is tested against, and what answers
// questions about a whole flight (did it ever leave the corridor?) that no distribution at one place can.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/route/path.h"

namespace landfix::route {

struct Flights {
  std::vector<double> rms_m;   ///< of the error, at each image
  std::vector<double> within;  ///< share of the flights whose error is below the radius, at each image
  double in_corridor = 0;      ///< share of the flights that never leave it
};

struct FlightsWanted {
  int runs = 2000;
  uint64_t seed = 1;
  double radius_m = 10;    ///< for `within`
  double corridor_m = 50;  ///< to either side of the route
};

/// The aircraft steers its estimate along the route, so what it is off the route is the error across it.
Flights simulate(const std::vector<Image>& images, const Vehicle& vehicle, const FlightsWanted& wanted);

}  // namespace landfix::route
