// Packs as the tools open them: errors become landfix::Error with the file's name and an exit code.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "builder/error.h"
#include "landfix/landfix.hpp"
#include "runtime/features/grid_image.h"

namespace landfix::tools {

/// Exit code that stands for a status of the runtime.
ExitCode exit_code_of(Status status);

/// Throws Error("<what>: <text of the status>") unless `status` is LF_OK.
void check(Status status, const std::string& what);

/// Opens a pack; `key_files` (made by `landfix keygen`) name the trusted public keys, none: signatures are not asked
/// for.
Pack open_pack(const std::string& path, const std::vector<std::string>& key_files = {});

/// What matchers and rectification ask of a map.
inline constexpr std::array kFlightLayers = {"gray", "edge", "contour", "orientation", "height"};

/// Decodes what is compressed of those of the layers that the pack has, so that any thread may read them. Errors name
/// the pack by its path.
void prepare_layers(const Pack& pack, const std::string& path, std::span<const char* const> layers = kFlightLayers);

/// Reads a region: CV_8UC(channels) for pixels, CV_32FC1 in metres above the ellipsoid for heights. Compressed tiles
/// are prepared first. Errors name the pack by its path.
features::GridImage read_region(const Pack& pack, const Region& region, const std::string& path);

}  // namespace landfix::tools
