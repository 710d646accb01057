#include "builder/catalog/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "builder/error.h"

namespace landfix::catalog {
namespace {

[[noreturn]] void fail(const char* what, const std::filesystem::path& path, int error) {
  const char* advice =
      error == ENOSPC || error == EFBIG || error == EDQUOT ? "; free space there or write elsewhere" : "";
  throw Error(ExitCode::kIo, fmt::format("{}: {}: {}{}", path.string(), what, std::strerror(error), advice));
}

int flags_of(File::Open mode) {
  switch (mode) {
    case File::Open::kRead:
      return O_RDONLY;
    case File::Open::kReadWrite:
      return O_RDWR | O_CREAT;
    case File::Open::kTruncate:
      return O_RDWR | O_CREAT | O_TRUNC;
  }
  return O_RDONLY;
}

}  // namespace

File::File(const std::filesystem::path& path, Open mode) : path_(path) {
  descriptor_ = ::open(path.c_str(), flags_of(mode) | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail("cannot open", path, errno);
}

File::~File() { ::close(descriptor_); }

void File::read_at(uint64_t offset, std::span<uint8_t> out) const {
  while (!out.empty()) {
    const ssize_t n = ::pread(descriptor_, out.data(), out.size(), off_t(offset));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail("cannot read", path_, errno);
    if (n == 0) throw Error(ExitCode::kIo, fmt::format("{}: ends before byte {}", path_.string(), offset + out.size()));
    out = out.subspan(size_t(n));
    offset += uint64_t(n);
  }
}

void File::write_at(uint64_t offset, std::span<const uint8_t> data) {
  while (!data.empty()) {
    const ssize_t n = ::pwrite(descriptor_, data.data(), data.size(), off_t(offset));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail("cannot write", path_, errno);
    data = data.subspan(size_t(n));
    offset += uint64_t(n);
  }
}

uint64_t File::size() const {
  struct stat status;
  if (::fstat(descriptor_, &status) != 0) fail("cannot ask for its size", path_, errno);
  return uint64_t(status.st_size);
}

void File::sync() {
  if (::fsync(descriptor_) != 0) fail("cannot flush to the disk", path_, errno);
}

void sync_folder(const std::filesystem::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) fail("cannot open", folder, errno);
  const int error = ::fsync(descriptor) == 0 ? 0 : errno;
  ::close(descriptor);
  if (error && error != EINVAL) fail("cannot flush to the disk", folder, error);  // EINVAL: a file system without it
}

std::filesystem::path folder_of(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

}  // namespace landfix::catalog
