// How the builder and the tools report what went wrong: one exception type, one list of exit codes.
#pragma once

#include <stdexcept>
#include <string>

namespace landfix {

/// Exit codes of `landfix`, documented in docs/command-line.md.
enum class ExitCode : int {
  kOk = 0,
  kInternal = 1,   ///< a defect of landfix or of a library it uses
  kUsage = 2,      ///< wrong command line
  kBadInput = 3,   ///< an input file or value cannot be used
  kBadPack = 4,    ///< a pack is damaged, not a pack, or of an unknown version
  kUntrusted = 5,  ///< a signature is missing or wrong where keys were given
  kNoData = 6,     ///< the question lies outside the map
  kIo = 7,         ///< reading or writing failed: disk full, no permission, no such file
};

/// What() names the file, what was expected, what was found and what to do about it.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

}  // namespace landfix
