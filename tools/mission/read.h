// Reads the missions of ground stations (docs/missions.md).
#pragma once

#include <string>

#include "tools/mission/mission.h"

namespace landfix::mission {

/// Reads a mission; the format is told from the content. Throws Error: kIo where the file cannot be read; kBadInput
/// where it is larger than 16 MiB, of no known format or version, damaged, holds nothing to fly, or holds an item
/// whose position is missing, not on Earth or in a frame of no fixed origin.
Mission read_mission(const std::string& path);

/// The same of a text; `name` stands for the file in messages.
Mission parse_mission(std::string text, const std::string& name);

}  // namespace landfix::mission
