// Random numbers of the simulator: the same on every machine for the same seed, independent from stream to stream.
#pragma once

#include <bit>

#include "tools/synth/random.h"

namespace landfix::fly {

/// What a stream of numbers is for. Each sensor has its own, so that an option of one leaves the noise of all others as
/// it was.
enum class Stream : uint64_t { kConstant = 1, kAttitude, kHeading, kBarometer, kGnss, kOdometry, kPixels, kSway };

/// One stream of a seed.
class NoiseStream {
 public:
  NoiseStream(uint64_t seed, Stream stream) : random_(synth::key(seed, static_cast<uint64_t>(stream))) {}

  double uniform() { return synth::unit(random_.word()); }    ///< [0, 1)
  double sign() { return random_.chance(0.5) ? 1.0 : -1.0; }  ///< -1 or +1
  double gaussian();                                          ///< mean 0, standard deviation 1
  /// The same from 64 coin tosses: in steps of a quarter, up to 8; fast enough for every pixel.
  double coarse_gaussian() { return (std::popcount(random_.word()) - 32) / 4.0; }

 private:
  synth::Random random_;
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace landfix::fly
