// The map that most tests of the runtime draw: two levels, a hole, a tile whose eastern half is without data.
#pragma once

#include "landfix/landfix.hpp"
#include "tests/pack/draw.h"

namespace landfix::tests {

/// South-western tile of the small map at level 0, around easting 500 km and northing 5000 km.
inline constexpr int32_t kWestX = 1953, kSouthY = 19531;
inline constexpr double kWestM = kWestX * 256.0, kSouthM = kSouthY * 256.0, kEastM = kWestM + 768,
                        kNorthM = kSouthM + 512;

/// A value from 1 to 255 that tells letters, channels and neighbouring pixels apart; 0 in the eastern half of tiles
/// with a capital letter.
int pattern(const PixelOf& pixel);

/// At level 0 and 1:
///   abc      pq
///   d.E      rs
DrawnLayer small_gray(tiles::Codec codec = tiles::Codec::kRaw);

/// The same map as ternary orientation: planes a+, a-, b+, b-, nodata 1. Bits tell letters, planes and neighbouring
/// pixels apart; capital letters are without data in their eastern half.
int bit_pattern(const PixelOf& pixel);
DrawnLayer small_bits(tiles::Codec codec = tiles::Codec::kRaw);

/// The pack of small_gray() alone; its bounds are those of level 0.
std::vector<uint8_t> small_pack(tiles::Codec codec = tiles::Codec::kRaw);

/// The letter of a tile of level 0 of the small map, '.' outside and in the hole.
char small_letter(int64_t column, int64_t row);

/// A pack in memory, with the bytes it refers to.
class OpenPack {
 public:
  explicit OpenPack(std::vector<uint8_t> bytes, const OpenOptions& options = {})
      : bytes_(std::move(bytes)), pack_(Pack::open_memory(std::as_bytes(std::span(bytes_)), options)) {}
  Status status() const { return pack_.status(); }
  const Pack& operator*() const { return *pack_; }
  const Pack* operator->() const { return &*pack_; }
  const lf_pack* c_pack() const { return pack_->c_pack(); }
  const std::vector<uint8_t>& bytes() const { return bytes_; }
  /// Index of a layer that must be there.
  uint32_t layer(const char* name) const { return *pack_->find_layer(name); }

 private:
  std::vector<uint8_t> bytes_;
  Result<Pack> pack_;
};

inline Status open_status(std::vector<uint8_t> bytes, const OpenOptions& options = {}) {
  return OpenPack(std::move(bytes), options).status();
}

/// The pixels of a region of a u8 layer, or the status instead.
struct Read {
  Status status;
  std::vector<uint8_t> pixels;
};
Read read(const Pack& pack, const Region& region, size_t channels = 1);

}  // namespace landfix::tests
