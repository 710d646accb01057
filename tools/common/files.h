// Files that exist whole or not at all.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace landfix::tools {

/// Calls `write` with a temporary name beside `path` (same extension), flushes what it wrote to disk and renames it to
/// `path`. The temporary file is removed when anything throws. `mode`: permission bits of the result. Throws
/// Error(kIo), also where `path` names a folder, a device or a pipe.
void write_atomically(const std::string& path, const std::function<void(const std::string& temporary)>& write,
                      unsigned mode = 0644);

/// write_atomically of a text.
void write_text(const std::string& path, const std::string& text, unsigned mode = 0644);

/// The same of bytes.
void write_bytes(const std::string& path, std::span<const uint8_t> bytes);

}  // namespace landfix::tools
