// Pixel codecs: round trips, the bytes that FORMAT.md section 3.4 promises, and hostile input.
#include "tiles/codec.h"

#include <gtest/gtest.h>
#include <turbojpeg.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>

#include "tests/tiles/random.h"

namespace landfix::tiles {
namespace {

using tests::Random;
using Bytes = std::vector<uint8_t>;

constexpr size_t kPixels = 65536;
constexpr TileFormat kGray{PixelType::kU8, 1, 0}, kRgb{PixelType::kU8, 3, 0}, kHeight{PixelType::kI16, 1, -32768},
    kOrientation{PixelType::kBit, 4, 1};

// Smooth hills: what lossy coding serves well. Never 0.
Bytes smooth(const TileFormat& f) {
  Bytes pixels(f.bytes());
  for (size_t i = 0; i < kPixels; ++i)
    for (int c = 0; c < f.channels; ++c) {
      const double x = double(i % 256), y = double(i / 256);
      pixels[i * f.channels + c] = uint8_t(128 + 60 * std::sin(x / 23 + c) + 60 * std::cos(y / 31));
    }
  return pixels;
}

Bytes noise(const TileFormat& f, uint64_t seed) {
  Random random(seed);
  Bytes pixels(f.bytes());
  std::generate(pixels.begin(), pixels.end(), [&] { return random.byte(); });
  return pixels;
}

// Ternary planes a+, a-, b+, b- of smoothed noise, with a corner without data: blobs as orientation has them.
Bytes ternary() {
  Random random(11);
  Bytes planes(kOrientation.bytes());
  for (int channel = 0; channel < 2; ++channel) {
    std::vector<int> field(258 * 258);
    for (int& v : field) v = int(random.integer(-100, 100));
    for (int pass = 0; pass < 6; ++pass)  // sums of 2 x 2
      for (size_t i = 0; i + 259 < field.size(); ++i) field[i] += field[i + 1] + field[i + 258] + field[i + 259];
    for (size_t y = 0; y < 256; ++y)
      for (size_t x = 0; x < 256; ++x) {
        const bool nodata = x > 200 && y < 50;
        const int value = field[258 * y + x];
        for (const int sign : {0, 1}) {
          const bool bit = nodata || (sign ? value < -27000 : value > 27000);
          planes[size_t(2 * channel + sign) * 8192 + 32 * y + x / 8] |= uint8_t(bit << x % 8);
        }
      }
  }
  return planes;
}

Bytes decoded(Codec codec, const TileFormat& f, const Bytes& data) {
  Bytes out(f.bytes());
  return decode(codec, f, data, out) ? out : Bytes{};
}

bool decodes(Codec codec, const TileFormat& f, std::span<const uint8_t> data) {
  // An allocation of exactly this size lets AddressSanitizer see a read beyond the end.
  const Bytes copy(data.begin(), data.end());
  Bytes out(f.bytes());
  return decode(codec, f, copy, out);
}

TEST(Codec, LosslessRoundTrips) {
  for (const Codec codec : {Codec::kRaw, Codec::kZstd}) {
    for (const uint8_t channels : {1, 2, 3, 8}) {
      const TileFormat f{PixelType::kU8, channels, 0};
      for (const Bytes& pixels : {noise(f, 1), smooth(f), Bytes(f.bytes(), 0)})
        EXPECT_EQ(decoded(codec, f, encode(codec, f, pixels)), pixels) << int(codec) << " " << int(channels);
    }
    for (const Bytes& pixels : {noise(kHeight, 2), Bytes(kHeight.bytes(), 0x80)})
      EXPECT_EQ(decoded(codec, kHeight, encode(codec, kHeight, pixels)), pixels) << int(codec);
  }
}

TEST(Codec, BitPlanesRoundTrip) {
  for (const Codec codec : {Codec::kRaw, Codec::kZstd, Codec::kContext}) {
    EXPECT_EQ(decoded(codec, kOrientation, encode(codec, kOrientation, ternary())), ternary()) << int(codec);
    for (const uint8_t channels : {1, 2, 5, 16}) {
      const TileFormat f{PixelType::kBit, channels, 0};
      EXPECT_EQ(f.bytes(), 8192u * channels);
      EXPECT_EQ(f.row_bytes(), 32u);
      for (const Bytes& planes : {noise(f, channels), Bytes(f.bytes(), 0), Bytes(f.bytes(), 0xFF)})
        EXPECT_EQ(decoded(codec, f, encode(codec, f, planes)), planes) << int(codec) << " " << int(channels);
    }
  }
}

TEST(Codec, ContextsServeTernaryPlanesBest) {
  const size_t context = encode(Codec::kContext, kOrientation, ternary()).size(),
               zstd = encode(Codec::kZstd, kOrientation, ternary(), {.jpeg_quality = 90, .zstd_level = 19}).size();
  EXPECT_LT(context, 32768u / 2);
  EXPECT_LT(double(context), 0.7 * double(zstd)) << context << " and " << zstd;
  // Noise cannot be packed, and hardly grows, by what is learned in vain.
  EXPECT_LT(encode(Codec::kContext, kOrientation, noise(kOrientation, 3)).size(), 32768u * 102 / 100);
}

TEST(Codec, ContextBytesAreThoseOfTheFormat) {
  // One plane of zeros: ever less is cut off the interval from below, so that its bytes are those of the upper end, but
  // for the lower end that closes them.
  const TileFormat one{PixelType::kBit, 1, 0};
  Bytes expected(15, 0xFF);
  std::ranges::copy(Bytes{0xFA, 0x48, 0x63, 0x0E}, expected.end() - 4);
  EXPECT_EQ(encode(Codec::kContext, one, Bytes(8192, 0)), expected);
  // A 1 in the first pixel keeps the lower half, where the upper end is 2^31 - 1.
  Bytes first(8192, 0);
  first[0] = 1;
  expected = Bytes(28, 0xFF);
  expected.front() = 0x7F;
  std::ranges::copy(Bytes{0xC5, 0x06, 0xA3, 0xBB}, expected.end() - 4);
  EXPECT_EQ(encode(Codec::kContext, one, first), expected);
}

TEST(Codec, JpegKeepsTheImageToItsQuality) {
  for (const TileFormat& f : {kGray, kRgb}) {
    const Bytes pixels = smooth(f), out = decoded(Codec::kJpeg, f, encode(Codec::kJpeg, f, pixels));
    ASSERT_EQ(out.size(), pixels.size());
    int worst = 0;
    for (size_t i = 0; i < out.size(); ++i) worst = std::max(worst, std::abs(int(out[i]) - pixels[i]));
    EXPECT_LE(worst, f.channels == 1 ? 4 : 10);  // quality 90; chroma is halved
  }
}

TEST(Codec, JpegKeepsTheMaskExactly) {
  // Dark noise next to holes: coding turns some data into nodata and holes into data; the mask must undo both.
  for (const int16_t nodata : {0, 7, 255})
    for (const uint8_t channels : {1, 3}) {
      const TileFormat f{PixelType::kU8, channels, nodata};
      Random random(uint64_t(nodata) + channels);
      Bytes pixels(f.bytes());
      std::vector<bool> valid(kPixels);
      for (size_t i = 0; i < kPixels; ++i) {
        for (int c = 0; c < channels; ++c)
          pixels[i * channels + c] = uint8_t(std::clamp<int>(nodata + int(random.integer(-2, 2)), 0, 255));
        if (random.integer(0, 2) == 0) std::fill_n(&pixels[i * channels], channels, uint8_t(nodata));
        valid[i] = std::any_of(&pixels[i * channels], &pixels[i * channels] + channels,
                               [&](uint8_t v) { return v != nodata; });
      }
      const Bytes out = decoded(Codec::kJpeg, f, encode(Codec::kJpeg, f, pixels));
      ASSERT_EQ(out.size(), pixels.size());
      size_t wrong = 0;
      for (size_t i = 0; i < kPixels; ++i) {
        const bool has =
            std::any_of(&out[i * channels], &out[i * channels] + channels, [&](uint8_t v) { return v != nodata; });
        wrong += has != valid[i];
      }
      EXPECT_EQ(wrong, 0u) << "nodata " << nodata << ", " << int(channels) << " channels";
    }
}

TEST(Codec, JpegTileIsMaskLengthMaskAndJpeg) {
  Bytes pixels = smooth(kGray);
  const Bytes whole = encode(Codec::kJpeg, kGray, pixels);
  ASSERT_GT(whole.size(), 6u);
  EXPECT_EQ(Bytes(whole.begin(), whole.begin() + 6), (Bytes{0, 0, 0, 0, 0xFF, 0xD8}));  // no mask, then start of image
  pixels[9] = pixels[256] = 0;
  const Bytes holed = encode(Codec::kJpeg, kGray, pixels);
  uint32_t length;
  std::memcpy(&length, holed.data(), 4);
  Bytes mask(9000);
  mask.resize(ZSTD_decompress(mask.data(), mask.size(), holed.data() + 4, length));
  Bytes expected(8192, 0xFF);
  expected[1] = 0xFD;   // pixel 9 is bit 1 of byte 1
  expected[32] = 0xFE;  // pixel 256 is bit 0 of byte 32
  EXPECT_EQ(mask, expected);
  EXPECT_EQ(holed[4 + length], 0xFF);
  EXPECT_EQ(holed[5 + length], 0xD8);
}

TEST(Codec, HeightsAreSplitDifferences) {
  Bytes pixels(kHeight.bytes());
  const auto set = [&](size_t i, int16_t v) { std::memcpy(&pixels[2 * i], &v, 2); };
  set(0, 300), set(1, 299), set(2, -32768);
  for (size_t i = 3; i < 256; ++i) set(i, -32768);
  set(256, -1);  // a row begins anew from 0
  const Bytes frame = encode(Codec::kZstd, kHeight, pixels);
  Bytes split(kHeight.bytes());
  ASSERT_EQ(ZSTD_decompress(split.data(), split.size(), frame.data(), frame.size()), split.size());
  const auto difference = [&](size_t i) { return split[i] | split[65536 + i] << 8; };
  EXPECT_EQ(difference(0), 300);
  EXPECT_EQ(difference(1), 0xFFFF);  // 299 - 300
  EXPECT_EQ(difference(2), (-32768 - 299) & 0xFFFF);
  EXPECT_EQ(difference(3), 0);
  EXPECT_EQ(difference(256), 0xFFFF);
  EXPECT_EQ(difference(257), 1);
}

TEST(Codec, EncodeRefusesWhatItDoesNotServe) {
  EXPECT_TRUE(encode(Codec::kJpeg, kHeight, Bytes(kHeight.bytes())).empty());
  const TileFormat two{PixelType::kU8, 2, 0};
  EXPECT_TRUE(encode(Codec::kJpeg, two, Bytes(two.bytes())).empty());
  EXPECT_TRUE(encode(Codec::kRaw, kGray, Bytes(100)).empty());
  EXPECT_TRUE(encode(Codec(9), kGray, Bytes(kGray.bytes())).empty());
  EXPECT_TRUE(encode(Codec::kContext, kGray, Bytes(kGray.bytes())).empty());
  EXPECT_TRUE(encode(Codec::kJpeg, kOrientation, ternary()).empty());
  for (const uint8_t channels : {0, 17}) {
    const TileFormat planes{PixelType::kBit, channels, 0};
    EXPECT_TRUE(encode(Codec::kContext, planes, Bytes(planes.bytes())).empty()) << int(channels);
    EXPECT_FALSE(decodes(Codec::kContext, planes, Bytes(1000))) << int(channels);
  }
  const TileFormat wide{PixelType::kI16, 2, 0};
  EXPECT_TRUE(encode(Codec::kZstd, wide, Bytes(wide.bytes())).empty());
}

TEST(Decode, RefusesEveryTruncation) {
  Bytes holed = smooth(kGray);
  std::fill(holed.begin(), holed.begin() + 5000, uint8_t(0));
  const struct {
    Codec codec;
    TileFormat format;
    Bytes data;
  } cases[] = {{Codec::kJpeg, kGray, encode(Codec::kJpeg, kGray, holed)},
               {Codec::kJpeg, kRgb, encode(Codec::kJpeg, kRgb, smooth(kRgb))},
               {Codec::kZstd, kGray, encode(Codec::kZstd, kGray, holed)},
               {Codec::kZstd, kHeight, encode(Codec::kZstd, kHeight, Bytes(kHeight.bytes(), 3))},
               {Codec::kZstd, kOrientation, encode(Codec::kZstd, kOrientation, ternary())},
               {Codec::kContext, kOrientation, encode(Codec::kContext, kOrientation, ternary())},
               {Codec::kRaw, kGray, holed},
               {Codec::kRaw, kOrientation, ternary()}};
  for (const auto& c : cases) {
    ASSERT_TRUE(decodes(c.codec, c.format, c.data));
    // Without the last two bytes a JPEG lacks its end marker only.
    const size_t step = std::max<size_t>(1, c.data.size() / 400);
    for (size_t n = 0; n < c.data.size(); n += step)
      ASSERT_FALSE(decodes(c.codec, c.format, {c.data.data(), n}))
          << "codec " << int(c.codec) << ", " << n << " of " << c.data.size();
    for (size_t n = c.data.size() - std::min<size_t>(20, c.data.size()); n < c.data.size(); ++n)
      ASSERT_FALSE(decodes(c.codec, c.format, {c.data.data(), n}))
          << "codec " << int(c.codec) << ", " << n << " of " << c.data.size();
  }
}

TEST(Decode, TakesNoOtherContextBytesThanTheEncoders) {
  // The last four bytes could be any of many: only the interval's lower end is taken.
  const Bytes good = encode(Codec::kContext, kOrientation, ternary());
  for (size_t back = 1; back <= 4; ++back)
    for (const int change : {1, 0x80}) {
      Bytes data = good;
      data[data.size() - back] ^= uint8_t(change);
      EXPECT_FALSE(decodes(Codec::kContext, kOrientation, data)) << back << " " << change;
    }
  EXPECT_FALSE(decodes(Codec::kContext, kOrientation, Bytes()));
  EXPECT_FALSE(decodes(Codec::kContext, kOrientation, Bytes(4)));
}

TEST(Decode, RefusesWhatFollowsTheData) {
  for (const Codec codec : {Codec::kRaw, Codec::kZstd}) {
    Bytes data = encode(codec, kGray, smooth(kGray));
    data.push_back(0);
    EXPECT_FALSE(decodes(codec, kGray, data)) << int(codec);
  }
  Bytes planes = encode(Codec::kContext, kOrientation, ternary());
  planes.push_back(0);
  EXPECT_FALSE(decodes(Codec::kContext, kOrientation, planes));
  // "One frame": neither an empty one behind nor a skippable one before.
  const Bytes frame = encode(Codec::kZstd, kGray, smooth(kGray));
  Bytes empty(64);
  empty.resize(ZSTD_compress(empty.data(), empty.size(), nullptr, 0, 1));
  Bytes two = frame;
  two.insert(two.end(), empty.begin(), empty.end());
  EXPECT_FALSE(decodes(Codec::kZstd, kGray, two));
  Bytes skipped = {0x50, 0x2A, 0x4D, 0x18, 0, 0, 0, 0};
  skipped.insert(skipped.end(), frame.begin(), frame.end());
  EXPECT_FALSE(decodes(Codec::kZstd, kGray, skipped));
}

TEST(Decode, SurvivesRandomBytes) {
  // Random bytes, and good tiles with a few bytes changed: any answer but a crash; sanitizers watch.
  Random random(7);
  const struct {
    Codec codec;
    TileFormat format;
  } formats[] = {{Codec::kJpeg, kGray},
                 {Codec::kJpeg, kRgb},
                 {Codec::kZstd, kGray},
                 {Codec::kZstd, kHeight},
                 {Codec::kContext, kOrientation}};
  for (const auto& f : formats) {
    const Bytes good =
        encode(f.codec, f.format, f.format.type == PixelType::kU8 ? smooth(f.format) : Bytes(f.format.bytes(), 5));
    int refused = 0;
    for (int i = 0; i < 300; ++i) {
      Bytes data(size_t(random.integer(0, 3000)));
      std::generate(data.begin(), data.end(), [&] { return random.byte(); });
      refused += !decodes(f.codec, f.format, data);
      Bytes changed = good;
      for (int k = 0; k < 4; ++k) changed[size_t(random.integer(0, int64_t(changed.size()) - 1))] = random.byte();
      decodes(f.codec, f.format, changed);
    }
    EXPECT_EQ(refused, 300);
  }
}

Bytes jpeg_tile(int width, int height, int channels) {
  const Bytes pixels(size_t(width) * size_t(height) * size_t(channels), 100);
  tjhandle handle = tjInitCompress();
  uint8_t* jpeg = nullptr;
  unsigned long size = 0;
  tjCompress2(handle, pixels.data(), width, 0, height, channels == 1 ? TJPF_GRAY : TJPF_RGB, &jpeg, &size,
              channels == 1 ? TJSAMP_GRAY : TJSAMP_420, 90, 0);
  Bytes tile(4 + size, 0);
  std::copy_n(jpeg, size, tile.begin() + 4);
  tjFree(jpeg);
  tjDestroy(handle);
  return tile;
}

TEST(Decode, RefusesAJpegOfAnotherShape) {
  EXPECT_TRUE(decodes(Codec::kJpeg, kGray, jpeg_tile(256, 256, 1)));
  EXPECT_TRUE(decodes(Codec::kJpeg, kRgb, jpeg_tile(256, 256, 3)));
  EXPECT_FALSE(decodes(Codec::kJpeg, kGray, jpeg_tile(255, 256, 1)));
  EXPECT_FALSE(decodes(Codec::kJpeg, kGray, jpeg_tile(256, 512, 1)));
  EXPECT_FALSE(decodes(Codec::kJpeg, kRgb, jpeg_tile(4096, 4096, 3)));
  EXPECT_FALSE(decodes(Codec::kJpeg, kGray, jpeg_tile(256, 256, 3)));
  EXPECT_FALSE(decodes(Codec::kJpeg, kRgb, jpeg_tile(256, 256, 1)));
}

TEST(Decode, RefusesZstandardBombs) {
  const Bytes zeros(64 << 20);  // 64 MiB in a frame of a few kilobytes
  Bytes bomb(ZSTD_compressBound(zeros.size()));
  bomb.resize(ZSTD_compress(bomb.data(), bomb.size(), zeros.data(), zeros.size(), 3));
  EXPECT_LT(bomb.size(), 20000u);
  EXPECT_FALSE(decodes(Codec::kZstd, kGray, bomb));
  EXPECT_FALSE(decodes(Codec::kZstd, kHeight, bomb));
  Bytes mask_bomb(4);
  const auto length = uint32_t(bomb.size());
  std::memcpy(mask_bomb.data(), &length, 4);
  mask_bomb.insert(mask_bomb.end(), bomb.begin(), bomb.end());
  const Bytes image = jpeg_tile(256, 256, 1);
  mask_bomb.insert(mask_bomb.end(), image.begin() + 4, image.end());
  EXPECT_FALSE(decodes(Codec::kJpeg, kGray, mask_bomb));
}

TEST(Decode, RefusesAMaskLongerThanTheTile) {
  Bytes tile = jpeg_tile(256, 256, 1);
  for (const uint32_t length : {uint32_t(tile.size() - 3), 0x7FFFFFFFu, 0xFFFFFFFFu}) {
    std::memcpy(tile.data(), &length, 4);
    EXPECT_FALSE(decodes(Codec::kJpeg, kGray, tile)) << length;
  }
}

TEST(Decode, RefusesUnknownCodecsAndWrongBuffers) {
  const Bytes raw(kGray.bytes());
  EXPECT_FALSE(decodes(Codec(4), kGray, raw));
  Bytes small(100);
  EXPECT_FALSE(decode(Codec::kRaw, kGray, raw, small));
  EXPECT_FALSE(decodes(Codec::kJpeg, kHeight, jpeg_tile(256, 256, 1)));
}

}  // namespace
}  // namespace landfix::tiles
