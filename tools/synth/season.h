// The seasons in which the world can be drawn.
#pragma once

#include <string>

namespace landfix::synth {

enum class Season { kSpring, kSummer, kAutumn, kWinter };

std::string name_of(Season season);
/// The middle of the season, as "2020-07-15".
std::string date_of(int year, Season season);

}  // namespace landfix::synth
