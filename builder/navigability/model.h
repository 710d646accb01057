// From evidence to the chance of a true fix and how far off it will be. The numbers come from tools/navigability.
#pragma once

#include <array>
#include <optional>

#include "builder/navigability/predictors.h"

namespace landfix::navigability {

/// Chance that an image taken at the place is matched within `hit_m` of the truth by a method: a logistic function of
/// the evidence of that method, with numbers of its own for places that one date shows. `method` absent: the choice
/// `auto`, from the evidence of orientation, which it asks first. 0 without any date. Holds for images as old as those
/// of the samples (tiles::kTypicalAgeYears).
double fix_probability(const Predictors& predictors, std::optional<nav::Method> method = std::nullopt);

/// What the standard gate will make of matches by `auto` at a place.
struct GateChances {
  double accepted = 0;           ///< that a match passes
  double false_of_accepted = 0;  ///< that one which passes is false
};

/// `fix`: as fix_probability gives it for `auto`. The gate promises one false fix in a hundred over all places, not at
/// each.
GateChances gate_chances(double fix);

/// Covariance of a true fix's error, row-major over (east, north), in m²: that of the matches between the dates,
/// scaled to what their errors are, and a floor for what dates lie apart. `gsd_m`: of the level that was matched.
std::array<double, 4> fix_covariance_m2(const Predictors& predictors, double gsd_m);

}  // namespace landfix::navigability
