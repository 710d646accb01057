#include "tiles/context_codec.h"

#include <algorithm>
#include <array>

#include "tiles/arithmetic_coder.h"
#include "tiles/codec.h"
#include "tiles/grid.h"

namespace landfix::tiles {
namespace {

// A byte of 0 or 1 for each pixel of a plane, and around them the zeros that neighbours outside of the tile are.
class Pixels {
 public:
  uint8_t* row(int y) { return &values_[size_t(y + 2) * kStride + 1]; }

  void unpack(std::span<const uint8_t> plane) {
    for (int y = 0; y < kTilePixels; ++y)
      for (int x = 0; x < kTilePixels; ++x) row(y)[x] = plane[byte_of(x, y)] >> (x % 8) & 1;
  }
  void pack(std::span<uint8_t> plane) {
    std::ranges::fill(plane, uint8_t(0));
    for (int y = 0; y < kTilePixels; ++y)
      for (int x = 0; x < kTilePixels; ++x) plane[byte_of(x, y)] |= uint8_t(row(y)[x] << (x % 8));
  }

 private:
  static constexpr size_t kStride = kTilePixels + 2;
  static size_t byte_of(int x, int y) { return size_t(y) * kPlaneRowBytes + size_t(x) / 8; }
  std::vector<uint8_t> values_ = std::vector<uint8_t>((kTilePixels + 3) * kStride);
};

// The bits of a plane in the context of five neighbours known already and three pixels of the plane before it. On
// ternary orientation 40 % smaller than Zstandard of the same pixels in any order tried.
template <typename Coder>
void code_plane(Pixels& plane, Pixels& before, Coder& coder) {
  std::array<BitModel, 256> models;
  for (int y = 0; y < kTilePixels; ++y) {
    uint8_t* here = plane.row(y);
    const uint8_t *north = plane.row(y - 1), *second_north = plane.row(y - 2);
    const uint8_t *other = before.row(y), *other_south = before.row(y + 1);
    for (int x = 0; x < kTilePixels; ++x) {
      const unsigned context = unsigned(here[x - 1] | north[x - 1] << 1 | north[x] << 2 | north[x + 1] << 3 |
                                        second_north[x] << 4 | other[x] << 5 | other[x + 1] << 6 | other_south[x] << 7);
      here[x] = coder.code(models[context], here[x] != 0);
    }
  }
}

}  // namespace

std::vector<uint8_t> encode_planes(std::span<const uint8_t> planes) {
  ArithmeticEncoder encoder;
  Pixels plane, before;
  for (size_t at = 0; at < planes.size(); at += kPlaneBytes) {
    plane.unpack(planes.subspan(at, kPlaneBytes));
    code_plane(plane, before, encoder);
    std::swap(plane, before);
  }
  return encoder.finish();
}

bool decode_planes(std::span<const uint8_t> data, std::span<uint8_t> planes) {
  ArithmeticDecoder decoder(data);
  Pixels plane, before;
  for (size_t at = 0; at < planes.size(); at += kPlaneBytes) {
    code_plane(plane, before, decoder);
    plane.pack(planes.subspan(at, kPlaneBytes));
    std::swap(plane, before);
  }
  return decoder.at_end();
}

}  // namespace landfix::tiles
