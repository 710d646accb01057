// Reproducible randomness: a number is a pure function of a seed and of what it is for, so any part of the world can be
// drawn alone, in any order, with the same bytes.
#pragma once

#include <cstdint>

namespace landfix::synth {

/// Finaliser of SplitMix64 (Steele, Lea, Flood 2014): spreads every input bit over the whole word.
constexpr uint64_t mix(uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

/// Key of the object with indices `a`, `b` among those of its kind (`salt`).
constexpr uint64_t key(uint64_t seed, uint64_t salt, int64_t a = 0, int64_t b = 0) {
  return mix(mix(mix(mix(seed) ^ salt) ^ static_cast<uint64_t>(a)) ^ static_cast<uint64_t>(b));
}

/// A word as a number in [0, 1).
constexpr double unit(uint64_t word) { return static_cast<double>(word >> 11) * 0x1p-53; }

/// A stream of numbers that belongs to one key.
class Random {
 public:
  explicit Random(uint64_t stream_key) : state_(stream_key) {}
  uint64_t word() { return mix(state_++); }
  double between(double low, double high) { return low + (high - low) * unit(word()); }
  bool chance(double probability) { return unit(word()) < probability; }

 private:
  uint64_t state_;
};

}  // namespace landfix::synth
