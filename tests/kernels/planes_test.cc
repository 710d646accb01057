#include "runtime/kernels/planes.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "tests/kernels/image.h"

namespace landfix::kernels {
namespace {

TEST(PackTernary, SetsABitPerPixel) {
  // 70 pixels: +1 in columns 0, 3, 6, ..., 69, -1 in 1, 4, ..., 67, the rest 0; a row of another value behind each.
  constexpr int kWidth = 70;
  std::vector<int8_t> pixels(2 * 80, 7);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < kWidth; ++x) pixels[size_t(y * 80 + x)] = int8_t(x % 3 == 0 ? 1 : x % 3 == 1 ? -1 : 0);
  std::vector<uint64_t> plus(6, 99), minus(6, 99);
  ASSERT_EQ(pack_ternary(pixels.data(), 80, 1, kWidth, 2, plus.data(), minus.data(), 3), Status::kOk);
  // Bits 0, 3, ..., 63 of the first word; columns 66 and 69 are bits 2 and 5 of the second; the spare word is zero.
  const std::vector<uint64_t> expected_plus = {0x9249249249249249, 0x24, 0, 0x9249249249249249, 0x24, 0};
  // Columns 1, 4, ..., 61, then 64 and 67.
  const std::vector<uint64_t> expected_minus = {0x2492492492492492, 0x09, 0, 0x2492492492492492, 0x09, 0};
  EXPECT_EQ(plus, expected_plus);
  EXPECT_EQ(minus, expected_minus);
}

TEST(PackTernary, TakesOneOfInterleavedChannels) {
  const std::vector<int8_t> pixels = {1, -1, 0, -1, -1, 1};  // channels (1, 0, -1) and (-1, -1, 1)
  uint64_t plus = 0, minus = 0;
  ASSERT_EQ(pack_ternary(pixels.data() + 1, 6, 2, 3, 1, &plus, &minus, 1), Status::kOk);
  EXPECT_EQ(plus, 0b100u);
  EXPECT_EQ(minus, 0b011u);
}

TEST(PackTernary, RefusesWhatIsNotTernary) {
  const std::vector<int8_t> pixels = {0, 1, 2};
  uint64_t plus = 0, minus = 0;
  EXPECT_EQ(pack_ternary(pixels.data(), 3, 1, 3, 1, &plus, &minus, 1), Status::kBadPixel);
  EXPECT_EQ(pack_ternary(pixels.data(), 3, 1, 2, 1, &plus, &minus, 1), Status::kOk);
}

TEST(PackTernary, RefusesBadArguments) {
  const int8_t pixel = 1;
  uint64_t plus[2] = {}, minus[2] = {};
  EXPECT_EQ(pack_ternary(nullptr, 1, 1, 1, 1, plus, minus, 1), Status::kBadArgument);
  EXPECT_EQ(pack_ternary(&pixel, 1, 1, 1, 1, nullptr, minus, 1), Status::kBadArgument);
  EXPECT_EQ(pack_ternary(&pixel, 1, 1, 1, 1, plus, nullptr, 1), Status::kBadArgument);
  EXPECT_EQ(pack_ternary(&pixel, 1, 0, 1, 1, plus, minus, 1), Status::kBadArgument);
  EXPECT_EQ(pack_ternary(&pixel, 1, 1, 2, 1, plus, minus, 1), Status::kBadArgument) << "rows overlap";
  EXPECT_EQ(pack_ternary(&pixel, 65, 1, 65, 1, plus, minus, 1), Status::kBadArgument) << "65 pixels need two words";
  EXPECT_EQ(pack_ternary(&pixel, 1, 1, -1, 1, plus, minus, 1), Status::kBadArgument);
  EXPECT_EQ(pack_ternary(nullptr, 1, 1, 0, 5, plus, minus, 1), Status::kOk) << "nothing to pack";
}

TEST(Extract, CopiesAnyRectangle) {
  std::mt19937 random(5);
  for (int i = 0; i < 500; ++i) {
    const int width = 1 + int(random() % 200), height = 1 + int(random() % 6);
    const tests::Image image = tests::random_image(1, width, height, 0.7, random, int(random() % 3));
    const int column = int(random() % unsigned(width)), row = int(random() % unsigned(height));
    const int columns = 1 + int(random() % unsigned(width - column)), rows = 1 + int(random() % unsigned(height - row));
    const int row_words = words_for(columns) + int(random() % 2);
    std::vector<uint64_t> out(size_t(rows * row_words), ~uint64_t{0});
    ASSERT_EQ(extract(image.planes()[0], column, row, columns, rows, out.data(), row_words), Status::kOk);
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < 64 * row_words; ++x)
        ASSERT_EQ(out[size_t(y * row_words + x / 64)] >> (x % 64) & 1,
                  uint64_t(x < columns && image.at(0, column + x, row + y) == 1))
            << "pixel " << x << ", " << y << " of " << columns << " x " << rows << " from " << column << ", " << row;
  }
}

TEST(Extract, RefusesWhatLeavesThePlane) {
  const uint64_t words[2] = {~uint64_t{0}, ~uint64_t{0}};
  const PlaneView plane = {words, 64, 2, 1};
  uint64_t out[4];
  EXPECT_EQ(extract(plane, 0, 0, 64, 2, out, 1), Status::kOk);
  EXPECT_EQ(extract(plane, 1, 0, 64, 2, out, 1), Status::kBadArgument);
  EXPECT_EQ(extract(plane, 0, 1, 64, 2, out, 1), Status::kBadArgument);
  EXPECT_EQ(extract(plane, -1, 0, 10, 1, out, 1), Status::kBadArgument);
  EXPECT_EQ(extract(plane, 0, -1, 10, 1, out, 1), Status::kBadArgument);
  EXPECT_EQ(extract(plane, 0, 0, 10, 1, nullptr, 1), Status::kBadArgument);
  EXPECT_EQ(extract(plane, 0, 0, 10, 1, out, 0), Status::kBadArgument);
  EXPECT_EQ(extract({nullptr, 64, 2, 1}, 0, 0, 10, 1, out, 1), Status::kBadArgument);
  EXPECT_EQ(extract(plane, 64, 2, 0, 0, out, 0), Status::kOk) << "nothing to copy";
}

}  // namespace
}  // namespace landfix::kernels
