// A report for people: one HTML file that needs nothing else, with a map of the navigability under the routes, profiles
// of the uncertainty and a table of the legs.
#pragma once

#include <string>
#include <vector>

#include "tools/route/suggest.h"

namespace landfix::route {

struct ReportInput {
  std::string title;
  std::string explanation;                ///< a sentence for the head; may be empty
  std::vector<const RouteScore*> routes;  ///< one to four
};

/// The same input gives the same bytes. Throws Error (kBadInput) for no routes.
std::string html_report(const ReportInput& input, const NavigabilityMap& map, const Vehicle& vehicle);

/// Of a score, and of a suggestion with its alternatives (those that could be scored).
std::string html_report(const RouteScore& score, const NavigabilityMap& map, const Vehicle& vehicle);
std::string html_report(const Suggestion& suggestion, const NavigabilityMap& map, const Vehicle& vehicle);

}  // namespace landfix::route
