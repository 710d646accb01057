// Bytes as people read them.
#pragma once

#include <sodium.h>

#include <cstdint>
#include <span>
#include <string>

namespace landfix {

/// Lower-case hexadecimal digits, two for each byte.
inline std::string hex(std::span<const uint8_t> bytes) {
  std::string text(bytes.size() * 2 + 1, '\0');  // with room for the terminator that libsodium writes
  sodium_bin2hex(text.data(), text.size(), bytes.data(), bytes.size());
  text.pop_back();
  return text;
}

}  // namespace landfix
