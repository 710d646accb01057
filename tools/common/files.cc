#include "tools/common/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "builder/error.h"

namespace landfix::tools {
namespace {

[[noreturn]] void fail(const std::string& path) {
  throw Error(ExitCode::kIo, path + ": cannot be written: " + std::strerror(errno));
}

/// A device, a pipe or a folder cannot be replaced by a file of its name: renaming would destroy what is there.
void require_replaceable(const std::string& path) {
  struct stat there {};
  if (stat(path.c_str(), &there) != 0 || S_ISREG(there.st_mode)) return;
  throw Error(ExitCode::kIo, path + ": expected the name of a file to write, found something else there" +
                                 (S_ISDIR(there.st_mode) ? " (a folder)" : "") + "; choose another name");
}

void flush_to_disk(const std::string& path, unsigned mode) {
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) fail(path);
  const bool done = fchmod(fd, mode) == 0 && fsync(fd) == 0;
  close(fd);
  if (!done) fail(path);
}

}  // namespace

void write_atomically(const std::string& path, const std::function<void(const std::string&)>& write, unsigned mode) {
  require_replaceable(path);
  const std::filesystem::path target(path);
  std::filesystem::path temporary = target;
  temporary.replace_filename("." + target.stem().string() + ".part" + target.extension().string());
  try {
    write(temporary.string());
    flush_to_disk(temporary.string(), mode);
    if (std::rename(temporary.c_str(), path.c_str()) != 0) fail(path);
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove(temporary, ignored);
    throw;
  }
}

void write_text(const std::string& path, const std::string& text, unsigned mode) {
  write_atomically(
      path,
      [&](const std::string& temporary) {
        // Created with the final permissions: a secret must not be readable even for a moment.
        const int fd = open(temporary.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, mode);
        if (fd < 0) fail(path);
        close(fd);
        std::ofstream file(temporary, std::ios::binary);
        file << text;
        file.close();
        if (!file) fail(path);
      },
      mode);
}

void write_bytes(const std::string& path, std::span<const uint8_t> bytes) {
  write_text(path, {bytes.begin(), bytes.end()});
}

}  // namespace landfix::tools
