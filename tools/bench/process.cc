#include "tools/bench/process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cstring>

#include "builder/error.h"
#include "tools/bench/timing.h"

extern char** environ;

namespace landfix::bench {
namespace {

/// What a child does with its outputs.
class OutputTo {
 public:
  explicit OutputTo(const std::filesystem::path& log) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_addopen(&actions_, 1, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    posix_spawn_file_actions_adddup2(&actions_, 1, 2);
  }
  ~OutputTo() { posix_spawn_file_actions_destroy(&actions_); }
  OutputTo(const OutputTo&) = delete;
  OutputTo& operator=(const OutputTo&) = delete;

  const posix_spawn_file_actions_t* actions() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_;
};

}  // namespace

double run(const std::vector<std::string>& command, const std::filesystem::path& log) {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const OutputTo output(log);
  const Clock::time_point start = Clock::now();
  pid_t child = 0;
  if (const int error = posix_spawnp(&child, arguments[0], output.actions(), nullptr, arguments.data(), environ)) {
    throw Error(ExitCode::kIo, fmt::format("{}: cannot be started: {}; install gdal-bin and python3-gdal", command[0],
                                           std::strerror(error)));
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  const double seconds = seconds_since(start);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw Error(ExitCode::kIo, fmt::format("failed: {}\nits output is in {}", fmt::join(command, " "), log.string()));
  }
  return seconds;
}

}  // namespace landfix::bench
