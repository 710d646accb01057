// How old a map is on a day.
#pragma once

#include <optional>
#include <string>

#include "landfix/landfix.hpp"

namespace landfix::tools {

/// Days since 1970-01-01 of "2018-07-16"; nullopt for a text that is no date.
std::optional<int> days_of(const std::string& date);

/// Years between a day and the nearest of the days on which the map's images of a place were taken, whichever comes
/// first. nullopt where the pack does not say, as for undated images.
std::optional<double> map_age_years(const Pack& pack, double east_m, double north_m, int day);

}  // namespace landfix::tools
