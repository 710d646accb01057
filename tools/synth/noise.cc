#include "tools/synth/noise.h"

#include <algorithm>
#include <cmath>

#include "tools/synth/random.h"

namespace landfix::synth {
namespace {

struct Gradient {
  float east, north;
};

constexpr int kDirections = 64;

/// Unit vectors of all directions, so that the hot loop needs no trigonometry.
const Gradient* directions() {
  static const auto table = [] {
    std::vector<Gradient> t(kDirections);
    for (int i = 0; i < kDirections; ++i) {
      const double angle = 2 * M_PI * i / kDirections;
      t[i] = {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
    }
    return t;
  }();
  return table.data();
}

/// A cheap 32-bit hash: noise asks for it at every lattice point.
uint32_t lattice_hash(uint32_t seed, int64_t column, int64_t row) {
  uint32_t h = seed ^ (static_cast<uint32_t>(column) * 0x9e3779b1u) ^ (static_cast<uint32_t>(row) * 0x85ebca77u);
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return h ^ (h >> 15);
}

float fade(float t) { return t * t * t * (t * (t * 6 - 15) + 10); }

/// East slope and value of the column of two lattice points at `column`, blended for this row: value = slope * t +
/// offset.
struct Column {
  float slope, offset;
};

struct RowBlend {
  uint32_t seed;
  int64_t row;
  float up, blend, amplitude;

  Column at(int64_t column) const {
    const Gradient low = directions()[lattice_hash(seed, column, row) % kDirections];
    const Gradient high = directions()[lattice_hash(seed, column, row + 1) % kDirections];
    const float low_value = low.north * up, high_value = high.north * (up - 1);
    return {amplitude * (low.east + blend * (high.east - low.east)),
            amplitude * (low_value + blend * (high_value - low_value))};
  }
};

template <typename EastOf>
void accumulate(const Octave& octave, float amplitude, double north_m, EastOf east_of, std::span<float> out) {
  const double per_m = 1 / octave.wavelength_m;
  const double v = north_m * per_m;
  const double row = std::floor(v);
  const float up = static_cast<float>(v - row);
  const RowBlend blend{octave.seed, static_cast<int64_t>(row), up, fade(up), amplitude};
  const int count = static_cast<int>(out.size());
  auto cell = static_cast<int64_t>(std::floor(east_of(0) * per_m));
  Column left = blend.at(cell), right = blend.at(cell + 1);
  for (int k = 0; k < count;) {
    for (; k < count; ++k) {
      const float t = static_cast<float>(east_of(k) * per_m - static_cast<double>(cell));
      if (t >= 1) break;
      const float a = left.slope * t + left.offset, b = right.slope * (t - 1) + right.offset;
      out[k] += a + fade(t) * (b - a);
    }
    if (k == count) break;
    // A t that rounds up to 1 in single precision belongs to the next cell, where it is 0.
    const int64_t next = std::max(static_cast<int64_t>(std::floor(east_of(k) * per_m)), cell + 1);
    left = next == cell + 1 ? right : blend.at(next);
    cell = next;
    right = blend.at(cell + 1);
  }
}

}  // namespace

Noise::Noise(uint64_t seed, double longest_m, double shortest_m, float amplitude, float gain) {
  for (double wavelength = longest_m; wavelength > shortest_m * 0.999; wavelength /= 2, amplitude *= gain) {
    octaves_.push_back({static_cast<uint32_t>(key(seed, octaves_.size())), wavelength, amplitude});
  }
}

void Noise::add_to(const SampleRow& row, std::span<float> out) const {
  for (const Octave& octave : octaves_) {
    const float carried = static_cast<float>(std::clamp(octave.wavelength_m / row.step_m - 1, 0.0, 1.0));
    if (carried == 0 || out.empty()) continue;
    accumulate(
        octave, octave.amplitude * carried, row.north_m, [&](int k) { return row.east_m(k); }, out);
  }
}

float Noise::at(double east_m, double north_m) const {
  float value = 0;
  for (const Octave& octave : octaves_) {
    accumulate(octave, octave.amplitude, north_m, [&](int) { return east_m; }, {&value, 1});
  }
  return value;
}

}  // namespace landfix::synth
