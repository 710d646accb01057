// What the writers of .plan and WPL share, called by write.cc.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/mission/route.h"
#include "tools/mission/write.h"

namespace landfix::mission {

/// The frame that has altitudes of this reference; throws Error (kUsage) where none does.
Frame frame_for(const Altitude& altitude);

/// Replacements by their first item, after checking them against a file of so many items. `fixed(item)` says why an
/// item cannot be taken away, or nothing.
std::vector<Replacement> checked(std::vector<Replacement> replacements, size_t items, const std::string& file,
                                 const std::function<std::string(size_t)>& fixed);

std::string new_plan(const std::vector<Place>& path, const NewFile& about);
std::string new_waypoints(const std::vector<Place>& path, const NewFile& about);
std::string changed_plan(const Mission& source, const std::vector<Replacement>& replacements);
std::string changed_waypoints(const Mission& source, const std::vector<Replacement>& replacements);

}  // namespace landfix::mission
