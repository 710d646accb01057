#include "tiles/codec.h"

#include <turbojpeg.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <new>

#include "tiles/context_codec.h"
#include "tiles/grid.h"

namespace landfix::tiles {
namespace {

constexpr size_t kPixels = size_t(kTilePixels) * kTilePixels;
constexpr size_t kMaskBytes = kPixels / 8;

std::vector<uint8_t> zstd_compress(std::span<const uint8_t> in, int level) {
  std::vector<uint8_t> out(ZSTD_compressBound(in.size()));
  const size_t n = ZSTD_compress(out.data(), out.size(), in.data(), in.size(), level);
  if (ZSTD_isError(n)) return {};
  out.resize(n);
  return out;
}

// One frame of exactly out.size() bytes, or false.
bool zstd_decompress(std::span<const uint8_t> in, std::span<uint8_t> out) {
  if (ZSTD_findFrameCompressedSize(in.data(), in.size()) != in.size()) return false;
  const size_t n = ZSTD_decompress(out.data(), out.size(), in.data(), in.size());
  return !ZSTD_isError(n) && n == out.size();
}

// i16 pixels as differences to their western neighbour (the first of a row to 0, modulo 2^16), low bytes first, then
// high bytes: smooth heights become long runs of small bytes.
std::vector<uint8_t> split_differences(std::span<const uint8_t> pixels) {
  std::vector<uint8_t> out(pixels.size());
  for (size_t i = 0; i < kPixels; ++i) {
    uint16_t value, west = 0;
    std::memcpy(&value, &pixels[2 * i], 2);
    if (i % kTilePixels) std::memcpy(&west, &pixels[2 * i - 2], 2);
    const auto difference = uint16_t(value - west);
    out[i] = uint8_t(difference);
    out[kPixels + i] = uint8_t(difference >> 8);
  }
  return out;
}

void join_differences(std::span<const uint8_t> split, std::span<uint8_t> out) {
  uint16_t value = 0;
  for (size_t i = 0; i < kPixels; ++i) {
    if (i % kTilePixels == 0) value = 0;
    value = uint16_t(value + (split[i] | split[kPixels + i] << 8));
    std::memcpy(&out[2 * i], &value, 2);
  }
}

bool has_data(const uint8_t* pixel, const TileFormat& f) {
  for (int c = 0; c < f.channels; ++c)
    if (pixel[c] != uint8_t(f.nodata)) return true;
  return false;
}

struct TjDestroy {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using TjHandle = std::unique_ptr<void, TjDestroy>;

bool planes_serve(const TileFormat& f) {
  return f.type == PixelType::kBit && f.channels >= 1 && f.channels <= kMaxBitChannels;
}

bool jpeg_serves(const TileFormat& f) { return f.type == PixelType::kU8 && (f.channels == 1 || f.channels == 3); }

// u32 length of the coded mask (0: every pixel has data), the mask, the JPEG.
std::vector<uint8_t> encode_jpeg(const TileFormat& f, std::span<const uint8_t> pixels, const EncodeOptions& options) {
  std::vector<uint8_t> mask(kMaskBytes, 0);
  size_t valid = 0;
  for (size_t i = 0; i < kPixels; ++i)
    if (has_data(&pixels[i * f.channels], f)) mask[i / 8] |= uint8_t(1u << (i % 8)), ++valid;
  const std::vector<uint8_t> coded_mask =
      valid == kPixels ? std::vector<uint8_t>{} : zstd_compress(mask, options.zstd_level);

  TjHandle handle(tjInitCompress());
  if (!handle) return {};
  uint8_t* jpeg = nullptr;
  unsigned long jpeg_bytes = 0;
  const bool gray = f.channels == 1;
  const int failed =
      tjCompress2(handle.get(), pixels.data(), kTilePixels, 0, kTilePixels, gray ? TJPF_GRAY : TJPF_RGB, &jpeg,
                  &jpeg_bytes, gray ? TJSAMP_GRAY : TJSAMP_420, options.jpeg_quality, TJFLAG_ACCURATEDCT);
  std::unique_ptr<uint8_t, decltype(&tjFree)> owner(jpeg, &tjFree);
  if (failed) return {};

  const auto mask_bytes = uint32_t(coded_mask.size());
  std::vector<uint8_t> out(4 + coded_mask.size() + jpeg_bytes);
  std::memcpy(out.data(), &mask_bytes, 4);
  std::copy(coded_mask.begin(), coded_mask.end(), out.begin() + 4);
  std::memcpy(out.data() + 4 + coded_mask.size(), jpeg, jpeg_bytes);
  return out;
}

void apply_mask(const TileFormat& f, std::span<const uint8_t> mask, std::span<uint8_t> out) {
  for (size_t i = 0; i < kPixels; ++i) {
    uint8_t* pixel = &out[i * f.channels];
    const bool valid = mask.empty() || (mask[i / 8] >> (i % 8) & 1);
    if (!valid) {
      std::fill_n(pixel, f.channels, uint8_t(f.nodata));
    } else if (!has_data(pixel, f)) {
      // Lossy coding turned data into the nodata value; the nearest other value tells them apart again.
      std::fill_n(pixel, f.channels, uint8_t(f.nodata == 0 ? 1 : f.nodata - 1));
    }
  }
}

// A warning means that pixels were made up; scans are limited because a hostile progressive file can hold thousands.
constexpr int kDecodeFlags = TJFLAG_ACCURATEDCT | TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS;

bool decode_jpeg(const TileFormat& f, std::span<const uint8_t> data, std::span<uint8_t> out) {
  if (data.size() < 4) return false;
  uint32_t mask_bytes;
  std::memcpy(&mask_bytes, data.data(), 4);
  data = data.subspan(4);
  if (mask_bytes > data.size()) return false;
  std::vector<uint8_t> mask(mask_bytes ? kMaskBytes : 0);
  if (mask_bytes && !zstd_decompress(data.first(mask_bytes), mask)) return false;
  data = data.subspan(mask_bytes);

  TjHandle handle(tjInitDecompress());
  if (!handle || data.empty()) return false;
  int width, height, subsampling, colorspace;
  if (tjDecompressHeader3(handle.get(), data.data(), data.size(), &width, &height, &subsampling, &colorspace))
    return false;
  if (width != kTilePixels || height != kTilePixels) return false;
  if ((colorspace == TJCS_GRAY) != (f.channels == 1)) return false;
  const int failed = tjDecompress2(handle.get(), data.data(), data.size(), out.data(), kTilePixels, 0, kTilePixels,
                                   f.channels == 1 ? TJPF_GRAY : TJPF_RGB, kDecodeFlags);
  if (failed) return false;
  apply_mask(f, mask, out);
  return true;
}

}  // namespace

std::vector<uint8_t> encode(Codec codec, const TileFormat& f, std::span<const uint8_t> pixels,
                            const EncodeOptions& options) {
  if (pixels.size() != f.bytes()) return {};
  switch (codec) {
    case Codec::kRaw:
      return {pixels.begin(), pixels.end()};
    case Codec::kJpeg:
      return jpeg_serves(f) ? encode_jpeg(f, pixels, options) : std::vector<uint8_t>{};
    case Codec::kZstd:
      if (f.type == PixelType::kI16 && f.channels == 1)
        return zstd_compress(split_differences(pixels), options.zstd_level);
      return f.type != PixelType::kI16 ? zstd_compress(pixels, options.zstd_level) : std::vector<uint8_t>{};
    case Codec::kContext:
      return planes_serve(f) ? encode_planes(pixels) : std::vector<uint8_t>{};
    case Codec::kVector:
      break;
  }
  return {};
}

bool decode(Codec codec, const TileFormat& f, std::span<const uint8_t> data, std::span<uint8_t> out) noexcept try {
  if (out.size() != f.bytes()) return false;
  switch (codec) {
    case Codec::kRaw:
      if (data.size() != out.size()) return false;
      std::copy(data.begin(), data.end(), out.begin());
      return true;
    case Codec::kJpeg:
      return jpeg_serves(f) && decode_jpeg(f, data, out);
    case Codec::kZstd: {
      if (f.type != PixelType::kI16) return zstd_decompress(data, out);
      if (f.channels != 1) return false;
      std::vector<uint8_t> split(out.size());
      if (!zstd_decompress(data, split)) return false;
      join_differences(split, out);
      return true;
    }
    case Codec::kContext:
      return planes_serve(f) && decode_planes(data, out);
    case Codec::kVector:
      break;
  }
  return false;
} catch (const std::bad_alloc&) {
  return false;
}

}  // namespace landfix::tiles
