// What the kernels answer: nothing in this room throws at its caller.
#pragma once

namespace landfix::kernels {

enum class Status {
  kOk = 0,
  kBadArgument,  ///< sizes that do not fit, a null pointer, shifts that take the patch out of the window
  kBadPixel,     ///< a value that is none of -1, 0 and 1
  kUnavailable,  ///< this processor cannot run the kernel that was asked for
  kOutOfMemory,
};

}  // namespace landfix::kernels
