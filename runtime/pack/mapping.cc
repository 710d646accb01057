#include "runtime/pack/mapping.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>

namespace landfix::pack {
namespace {

struct Descriptor {
  int fd;
  ~Descriptor() {
    if (fd < 0) return;
    const int kept = errno;
    close(fd);
    errno = kept;
  }
};

bool read_all(int fd, uint8_t* out, size_t size) {
  for (size_t done = 0; done < size;) {
    const ssize_t n = read(fd, out + done, size - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    done += size_t(n);
  }
  return true;
}

}  // namespace

Mapping::~Mapping() {
  if (kind_ == Kind::kMapped) munmap(const_cast<uint8_t*>(data_), size_);
  if (kind_ == Kind::kOwned) std::free(const_cast<uint8_t*>(data_));
}

lf_status Mapping::open(const char* path, bool copy) {
  // O_NONBLOCK: a pipe by this name is refused below instead of waited for. It means nothing for files.
  const Descriptor file{::open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
  struct stat info {};
  if (file.fd < 0 || fstat(file.fd, &info) != 0) return LF_IO;
  if (!S_ISREG(info.st_mode)) return LF_NOT_A_PACK;
  const auto size = size_t(info.st_size);
  if (size == 0) return LF_NOT_A_PACK;
  if (copy) {
    auto* memory = static_cast<uint8_t*>(std::malloc(size));
    if (memory == nullptr) return LF_OUT_OF_MEMORY;
    kind_ = Kind::kOwned, data_ = memory, size_ = size;
    return read_all(file.fd, memory, size) ? LF_OK : LF_IO;
  }
  void* mapped = mmap(nullptr, size, PROT_READ, MAP_SHARED, file.fd, 0);
  if (mapped == MAP_FAILED) return LF_IO;
  kind_ = Kind::kMapped, data_ = static_cast<const uint8_t*>(mapped), size_ = size;
  // Queries jump: reading ahead would fill the memory of a small computer with tiles that nobody asked for.
  madvise(mapped, size, MADV_RANDOM);
  return LF_OK;
}

lf_status Mapping::borrow(const void* data, size_t size) {
  if (data == nullptr || reinterpret_cast<uintptr_t>(data) % 8 != 0) return LF_INVALID_ARGUMENT;
  kind_ = Kind::kBorrowed, data_ = static_cast<const uint8_t*>(data), size_ = size;
  return LF_OK;
}

void Mapping::will_need(size_t offset, size_t length) const {
  if (kind_ != Kind::kMapped) return;
  const auto page = size_t(sysconf(_SC_PAGESIZE));
  const size_t begin = offset / page * page;
  madvise(const_cast<uint8_t*>(data_) + begin, offset + length - begin, MADV_WILLNEED);
}

}  // namespace landfix::pack
