// A file of the builder's own: positioned reads and writes that are complete or throw.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

namespace landfix::catalog {

/// Owns a file descriptor. Reading and writing at positions is safe from many threads. All errors are Error (kIo) and
/// name the file.
class File {
 public:
  enum class Open { kRead, kReadWrite, kTruncate };  ///< kReadWrite and kTruncate create a file that is not there
  File(const std::filesystem::path& path, Open mode);
  ~File();
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  const std::filesystem::path& path() const { return path_; }
  void read_at(uint64_t offset, std::span<uint8_t> out) const;
  void write_at(uint64_t offset, std::span<const uint8_t> data);
  uint64_t size() const;
  void sync();  ///< to the disk, so that a rename after it never shows a half-written file

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

/// Makes names that were created, renamed or removed in a folder durable.
void sync_folder(const std::filesystem::path& folder);

/// The folder in which `path` lies, "." for a bare name.
std::filesystem::path folder_of(const std::filesystem::path& path);

}  // namespace landfix::catalog
