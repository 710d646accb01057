// Programs that the benchmark runs and times.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace landfix::bench {

/// Runs a program found in PATH, its output going to `log`, and returns its wall time in seconds. Throws Error(kIo)
/// that names program and log where it cannot be started or fails.
double run(const std::vector<std::string>& command, const std::filesystem::path& log);

}  // namespace landfix::bench
