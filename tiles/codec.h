// Pixel codecs of tiles: raw, JPEG, Zstandard, and one of bit planes. schemas/FORMAT.md says what the bytes are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace landfix::tiles {

/// Values as in the file.
enum class Codec : uint8_t {
  kRaw = 0,
  kJpeg = 1,
  kZstd = 2,
  kContext = 3,  ///< of kBit alone: see tiles/context_codec.h
  kVector = 4    ///< of vector layers alone, which have no pixels: see tiles/landmark.h and tiles/road.h
};
enum class PixelType : uint8_t { kU8 = 0, kI16 = 1, kBit = 2 };

/// A bit plane of a tile: 256 rows of 32 bytes; column c is bit c % 8 of byte c / 8 of its row, so that little-endian
/// words of 64 bits hold columns 64k to 64k + 63, the first in the lowest bit.
inline constexpr size_t kPlaneRowBytes = 32, kPlaneBytes = 256 * kPlaneRowBytes;
inline constexpr int kMaxBitChannels = 16;

/// The shape of a tile's decoded pixels: rows from north to south, pixels from west to east, channels interleaved,
/// little-endian. kBit: plane after plane, one for each of 1 to kMaxBitChannels channels.
struct TileFormat {
  PixelType type = PixelType::kU8;
  uint8_t channels = 1;
  int16_t nodata = 0;
  /// Of a decoded tile.
  size_t bytes() const {
    if (type == PixelType::kBit) return channels * kPlaneBytes;
    return size_t(256) * 256 * channels * (type == PixelType::kI16 ? 2 : 1);
  }
  /// From one row to the next: of all channels, or of one bit plane.
  size_t row_bytes() const { return type == PixelType::kBit ? kPlaneRowBytes : bytes() / 256; }
};

struct EncodeOptions {
  int jpeg_quality = 90;
  int zstd_level = 9;
};

/// Encodes one tile of `format.bytes()` bytes. JPEG wants kU8 with 1 or 3 channels; a pixel is without data where all
/// channels equal nodata, which the coded mask keeps exactly. kContext wants kBit; orientation takes half of what
/// it takes with kZstd, at 2 ms for a tile of four planes (to decode: 2.5 ms). Returns an empty vector where the codec
/// does not serve the format.
std::vector<uint8_t> encode(Codec codec, const TileFormat& format, std::span<const uint8_t> pixels,
                            const EncodeOptions& options = {});

/// Decodes into `out` of `format.bytes()` bytes. Never reads outside `data`, whatever it holds; false where `data` is
/// not a tile of this codec and format, or memory ran out (`out` is then unspecified).
bool decode(Codec codec, const TileFormat& format, std::span<const uint8_t> data, std::span<uint8_t> out) noexcept;

}  // namespace landfix::tiles
