// From evidence to the chance of a true fix and how far off it will be. The numbers come from tools/navigability.
#pragma once

#include <array>

#include "builder/navigability/predictors.h"

namespace landfix::navigability {

/// Chance that an image taken at the place is matched within `hit_m` of the truth by a method: a logistic function of
/// the evidence of that method, with numbers of its own for places that one date shows. That of `auto` is the chance of
/// the method that it asks first. 0 without any date. Holds for images as old as those of the samples
/// (tiles::kTypicalAgeYears).
double fix_probability(const Predictors& predictors, nav::Method method = nav::Method::kOrientation);

/// Chance that a match by `auto` at a place passes the standard gate and is false: one miss in ten does, rounded up
/// from what was measured on real images. `fix`: chance of a true one. The gate promises one false fix in a hundred
/// over all places, not at each.
double false_fix_probability(double fix);

/// Covariance of a true fix's error, row-major over (east, north), in m²: that of the matches, scaled to what their
/// errors are, a floor for what dates lie apart, and in no direction below the Cramér-Rao bound. `gsd_m`: of the level
/// that was matched.
std::array<double, 4> fix_covariance_m2(const Predictors& predictors, double gsd_m);

}  // namespace landfix::navigability
