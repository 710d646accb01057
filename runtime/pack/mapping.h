// The bytes of a pack: mapped, copied, or somebody else's.
#pragma once

#include <cstddef>
#include <cstdint>

#include "landfix/landfix.h"

namespace landfix::pack {

class Mapping {
 public:
  Mapping() = default;
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;
  ~Mapping();

  /// Maps the file read-only or, with `copy`, reads it into memory of this object.
  lf_status open(const char* path, bool copy);
  /// Refers to bytes of the caller's, 8-byte aligned.
  lf_status borrow(const void* data, size_t size);

  const uint8_t* data() const { return data_; }
  size_t size() const { return size_; }
  /// Asks the kernel to read pages ahead; nothing where the bytes are in memory anyway.
  void will_need(size_t offset, size_t length) const;

 private:
  enum class Kind { kNone, kMapped, kOwned, kBorrowed };
  Kind kind_ = Kind::kNone;
  const uint8_t* data_ = nullptr;
  size_t size_ = 0;
};

}  // namespace landfix::pack
