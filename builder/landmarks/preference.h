// Which landmark stays where two sources tell of one.
#pragma once

#include <span>
#include <vector>

#include "tiles/landmark.h"

namespace landfix::landmarks {

/// Whether the centre of `other` lies in the rectangle of `m`.
bool covers(const tiles::Landmark& m, const tiles::Landmark& other);

/// Appends to `landmarks` those of `more` whose centre lies in the rectangle of none of the same class that was there
/// before the call, nor within `reach_m` of its centre: what is known of a place already is preferred. Those of `more`
/// do not exclude each other.
void add_new(std::vector<tiles::Landmark>& landmarks, std::span<const tiles::Landmark> more, double reach_m = 0);

}  // namespace landfix::landmarks
