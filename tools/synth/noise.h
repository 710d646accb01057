// Gradient noise on the grid (Perlin 1985, with the quintic fade of Perlin 2002), evaluated row by row: within a row
// the lattice gradients are blended once per noise cell, which leaves a few multiplications per pixel.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace landfix::synth {

/// Sample centres along one row of pixels: sample k lies at easting (first + k + 0.5) step_m. The integer makes a
/// sample's coordinate the same bits whatever window it is drawn in.
struct SampleRow {
  int64_t first = 0;
  double step_m = 1;
  double north_m = 0;

  double east_m(int k) const { return (static_cast<double>(first + k) + 0.5) * step_m; }
};

/// One octave: values within about ±0.7 amplitude, structures of about one wavelength.
struct Octave {
  uint32_t seed = 0;
  double wavelength_m = 1;
  float amplitude = 1;
};

/// A sum of octaves.
class Noise {
 public:
  Noise() = default;
  /// Wavelengths from `longest_m` down to `shortest_m`, each half the one before; each amplitude `gain` times the one
  /// before.
  Noise(uint64_t seed, double longest_m, double shortest_m, float amplitude, float gain);

  /// Adds the noise along a row to `out`. Octaves that the step cannot carry are faded out, so that coarse images are
  /// smooth, not aliased.
  void add_to(const SampleRow& row, std::span<float> out) const;
  float at(double east_m, double north_m) const;

 private:
  std::vector<Octave> octaves_;
};

}  // namespace landfix::synth
