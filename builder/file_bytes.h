// Small files as a whole.
#pragma once

#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "builder/error.h"

namespace landfix {

/// All bytes of a file. Throws Error (kIo) that names it and what was expected: "a model of roads".
inline std::vector<uint8_t> bytes_of_file(const std::string& path, const std::string& expected) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(ExitCode::kIo, path + ": cannot be read; expected " + expected);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace landfix
