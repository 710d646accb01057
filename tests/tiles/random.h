// Random numbers for tests: the same on every machine, unlike the standard's distributions.
#pragma once

#include <cstdint>
#include <random>

namespace landfix::tests {

class Random {
 public:
  explicit Random(uint64_t seed) : engine_(seed) {}
  /// In [0, 1).
  double uniform() { return double(engine_() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// In [low, high], both ends included.
  int64_t integer(int64_t low, int64_t high) { return low + int64_t(engine_() % uint64_t(high - low + 1)); }
  uint8_t byte() { return uint8_t(engine_() >> 32); }

 private:
  std::mt19937_64 engine_;
};

}  // namespace landfix::tests
