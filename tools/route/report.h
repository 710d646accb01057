// A report for people: one HTML file that needs nothing else, with a map of the navigability under the routes, profiles
// of the uncertainty and a table of the legs.
#pragma once

#include <string>
#include <vector>

#include "landfix/landfix.hpp"
#include "tools/route/suggest.h"

namespace landfix::route {

/// What the map of a report shows beside navigability and routes.
struct ReportScene {
  const Pack* pack = nullptr;  ///< whose overview (or gray layer) lies below; none: plain colours
  std::string pack_path;       ///< for messages
  Fences fences{};
  std::vector<Eigen::Vector2d> rally_points;
};

/// The fences, and the mission's rally points as far as the zone reaches.
ReportScene scene_of(const Pack& pack, const std::string& pack_path, const Fences& fences,
                     const mission::Mission* mission, const tiles::Zone& zone);

struct ReportInput {
  std::string title;
  std::string explanation;                ///< a sentence for the head; may be empty
  std::vector<const RouteScore*> routes;  ///< one to four
  ReportScene scene;
};

/// The same input gives the same bytes. Throws Error (kBadInput) for no routes.
std::string html_report(const ReportInput& input, const NavigabilityMap& map, const Vehicle& vehicle);

/// Of a score, and of a suggestion with its alternatives (those that could be scored).
std::string html_report(const RouteScore& score, const NavigabilityMap& map, const Vehicle& vehicle,
                        const ReportScene& scene = {});
std::string html_report(const Suggestion& suggestion, const NavigabilityMap& map, const Vehicle& vehicle,
                        const ReportScene& scene = {});

}  // namespace landfix::route
