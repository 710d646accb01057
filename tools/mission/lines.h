// Lines and points of GPX, KML and GeoJSON files, and which of them is the route.
#pragma once

#include <string>
#include <vector>

#include "tools/mission/mission.h"

namespace landfix::mission {

struct Line {
  std::string name;
  std::vector<Place> places;
  size_t item = 0;
  std::optional<Speed> speed;
};

struct LooseEnds {
  std::vector<Line> lines;
  std::vector<Line> points;  ///< of one place each
};

/// Takes the one line, or, where there is none, the points in their order; `kind` names lines in messages. Throws
/// Error (kBadInput) where there are several lines: which one is flown is not for this program to guess.
void take_route(const LooseEnds& found, const std::string& kind, Mission& mission);

/// A number of a text file, without regard to the locale; throws Error (kBadInput) otherwise.
double number_of(const std::string& text, const std::string& file, const std::string& where);

}  // namespace landfix::mission
