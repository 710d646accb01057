// Memory that correlations use again and again.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>

namespace landfix::kernels {

/// One per thread. Grows to the largest call and stays there: repeated calls of like size do not allocate.
class Workspace {
 public:
  /// `bytes` of memory, aligned for any register and of unspecified content, valid until the next call; null where
  /// there is none.
  std::byte* reserve(size_t bytes) noexcept {
    if (bytes > size_) {
      const size_t rounded = (bytes + bytes / 8) / kAlignment * kAlignment + kAlignment;
      size_ = 0;
      memory_.reset();
      memory_.reset(static_cast<std::byte*>(std::aligned_alloc(kAlignment, rounded)));
      if (memory_) size_ = rounded;
    }
    return memory_.get();
  }
  size_t size() const { return size_; }

 private:
  static constexpr size_t kAlignment = 64;
  struct Free {
    void operator()(std::byte* memory) const { std::free(memory); }
  };
  std::unique_ptr<std::byte[], Free> memory_;
  size_t size_ = 0;
};

}  // namespace landfix::kernels
