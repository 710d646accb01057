// Numbers by chance that are the same on every machine.
#pragma once

#include <algorithm>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

namespace landfix {

/// The engine's numbers are the standard's; its distributions are not.
class Random {
 public:
  explicit Random(uint64_t seed) : engine_(seed) {}
  double between(double low, double high) { return low + (high - low) * double(engine_() >> 11) * 0x1p-53; }
  int below(int limit) { return int(engine_() % uint64_t(limit)); }
  bool chance(double probability) { return between(0, 1) < probability; }
  /// Of mean 0 and variance 1, nearly normal (the sum of three even ones).
  double normal() { return 2 * (between(-0.5, 0.5) + between(-0.5, 0.5) + between(-0.5, 0.5)); }

 private:
  std::mt19937_64 engine_;
};

/// Leaves `count` of them, drawn by chance; all where there are no more.
template <typename T>
void keep_some(std::vector<T>& all, size_t count, Random& random) {
  for (size_t i = 0; i < std::min(count, all.size()); ++i)
    std::swap(all[i], all[i + size_t(random.below(int(all.size() - i)))]);
  if (all.size() > count) all.resize(count);
}

}  // namespace landfix
