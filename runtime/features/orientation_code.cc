#include "runtime/features/orientation_code.h"

#include <array>
#include <cmath>
#include <cstring>
#include <vector>

namespace landfix::features {
namespace {

constexpr int kWord = 64;

int8_t level_of(float value) {
  const float magnitude = std::abs(value);
  const int level = int(magnitude > kWeakOrientation) + int(magnitude > kStrongOrientation);
  return int8_t(value < 0 ? -level : level);
}

/// The five bits of a pixel, plane 0 lowest.
unsigned code_of(int a, int b) {
  if (a != 0 && b != 0)
    return unsigned(std::abs(a) == 2) << 1 | unsigned(std::abs(b) == 2) << 2 | unsigned(a < 0) << 3 |
           unsigned(b < 0) << 4;
  if (a == 0 && b == 0) return 1u | 1u << 1;
  const int other = a != 0 ? a : b;
  return 1u | unsigned(std::abs(other) == 2) << 2 | unsigned(other < 0) << 3 | unsigned(b != 0) << 4;
}

constexpr uint8_t kNoData = 31;

/// Codes by 5·a + b + 12.
std::array<uint8_t, 25> codes() {
  std::array<uint8_t, 25> table{};
  for (int a = -2; a <= 2; ++a)
    for (int b = -2; b <= 2; ++b) table[size_t(5 * a + b + 12)] = uint8_t(code_of(a, b));
  return table;
}

/// Bit `plane` of eight codes as one byte, the first in the lowest bit.
uint8_t gather_bits(const uint8_t* eight_codes, int plane) {
  uint64_t eight;
  std::memcpy(&eight, eight_codes, sizeof eight);
  // The multiplication moves bit 0 of byte i to bit 56 + i.
  return uint8_t(((eight >> plane & 0x0101010101010101) * 0x0102040810204080) >> 56);
}

/// What a code means; codes that no writer makes count as no data.
struct Meaning {
  int8_t a, b;
  uint8_t valid;
};

std::array<Meaning, 32> meanings() {
  std::array<Meaning, 32> table{};
  for (int a = -2; a <= 2; ++a)
    for (int b = -2; b <= 2; ++b) table[code_of(a, b)] = {int8_t(a), int8_t(b), 255};
  return table;
}

/// Bits of a byte spread to the lowest bits of eight bytes.
std::array<uint64_t, 256> spread_table() {
  std::array<uint64_t, 256> table{};
  for (size_t byte = 0; byte < 256; ++byte)
    for (size_t bit = 0; bit < 8; ++bit) table[byte] |= uint64_t(byte >> bit & 1) << (8 * bit);
  return table;
}

}  // namespace

void orientation_levels(const cv::Mat& ab, cv::Mat& levels) {
  CV_Assert(ab.type() == CV_32FC2);
  levels.create(ab.size(), CV_8SC2);
  for (int y = 0; y < ab.rows; ++y) {
    const float* in = ab.ptr<float>(y);
    int8_t* out = levels.ptr<int8_t>(y);
    for (int x = 0; x < 2 * ab.cols; ++x) out[x] = level_of(in[x]);
  }
}

void pack_orientation(const cv::Mat& levels, const cv::Mat& valid, cv::Mat& planes) {
  CV_Assert(levels.type() == CV_8SC2);
  CV_Assert(valid.empty() || (valid.type() == CV_8UC1 && valid.size() == levels.size()));
  static const std::array<uint8_t, 25> kCodes = codes();
  const int row_bytes = (levels.cols + kWord - 1) / kWord * 8;
  planes.create(kOrientationPlanes * levels.rows, row_bytes, CV_8UC1);
  std::vector<uint8_t> row(size_t(row_bytes) * 8, kNoData);  // the bits that fill the last word stay set
  for (int y = 0; y < levels.rows; ++y) {
    const int8_t* in = levels.ptr<int8_t>(y);
    const uint8_t* known = valid.empty() ? nullptr : valid.ptr<uint8_t>(y);
    for (int x = 0; x < levels.cols; ++x)
      row[size_t(x)] = !known || known[x] ? kCodes[size_t(5 * in[2 * x] + in[2 * x + 1] + 12)] : kNoData;
    for (int p = 0; p < kOrientationPlanes; ++p) {
      uint8_t* to = planes.ptr<uint8_t>(p * levels.rows + y);
      for (int i = 0; i < row_bytes; ++i) to[i] = gather_bits(row.data() + 8 * i, p);
    }
  }
}

void unpack_orientation(const uint64_t* words, size_t row_words, size_t plane_words, cv::Size size, cv::Mat& levels,
                        cv::Mat& valid) {
  static const std::array<Meaning, 32> kMeanings = meanings();
  static const std::array<uint64_t, 256> kSpread = spread_table();
  levels.create(size, CV_8SC2);
  valid.create(size, CV_8UC1);
  for (int y = 0; y < size.height; ++y) {
    const uint64_t* row = words + size_t(y) * row_words;
    int8_t* out = levels.ptr<int8_t>(y);
    uint8_t* known = valid.ptr<uint8_t>(y);
    for (int x = 0; x < size.width; x += 8) {
      uint64_t codes = 0;  // of eight pixels, a byte each
      for (size_t p = 0; p < kOrientationPlanes; ++p)
        codes |= kSpread[row[p * plane_words + size_t(x / kWord)] >> (x % kWord) & 255] << p;
      for (int i = 0; i < 8 && x + i < size.width; ++i) {
        const Meaning& meaning = kMeanings[codes >> (8 * i) & 31];
        out[2 * (x + i)] = meaning.a;
        out[2 * (x + i) + 1] = meaning.b;
        known[x + i] = meaning.valid;
      }
    }
  }
}

}  // namespace landfix::features
