// Pixel codecs of tiles: raw, JPEG, Zstandard. schemas/FORMAT.md says what the bytes are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace landfix::tiles {

/// Values as in the file.
enum class Codec : uint8_t { kRaw = 0, kJpeg = 1, kZstd = 2 };
enum class PixelType : uint8_t { kU8 = 0, kI16 = 1 };

inline constexpr size_t bytes_of(PixelType type) { return type == PixelType::kU8 ? 1 : 2; }

/// The shape of a tile's decoded pixels: rows from north to south, pixels from west to east, channels interleaved,
/// little-endian.
struct TileFormat {
  PixelType type = PixelType::kU8;
  uint8_t channels = 1;
  int16_t nodata = 0;
  size_t bytes() const { return size_t(256) * 256 * channels * bytes_of(type); }
};

struct EncodeOptions {
  int jpeg_quality = 90;
  int zstd_level = 9;
};

/// Encodes one tile of `format.bytes()` bytes. JPEG wants kU8 with 1 or 3 channels; a pixel is without data where all
/// channels equal nodata, which the coded mask keeps exactly. Returns an empty vector where the codec does not serve
/// the format.
std::vector<uint8_t> encode(Codec codec, const TileFormat& format, std::span<const uint8_t> pixels,
                            const EncodeOptions& options = {});

/// Decodes into `out` of `format.bytes()` bytes. Never reads outside `data`, whatever it holds; false where `data` is
/// not a tile of this codec and format, or memory ran out (`out` is then unspecified).
bool decode(Codec codec, const TileFormat& format, std::span<const uint8_t> data, std::span<uint8_t> out) noexcept;

}  // namespace landfix::tiles
