// Replays a fuzzer's corpus in the normal build: every input once, and cut in the middle.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace landfix::tests {
namespace {

TEST(FuzzCorpus, IsAnsweredWithoutACrash) {
  int inputs = 0;
  for (const auto& entry : std::filesystem::directory_iterator(LANDFIX_FUZZ_CORPUS)) {
    SCOPED_TRACE(entry.path().filename().string());
    std::ifstream file(entry.path(), std::ios::binary);
    const std::vector<uint8_t> input(std::istreambuf_iterator<char>(file), {});
    EXPECT_EQ(LLVMFuzzerTestOneInput(input.data(), input.size()), 0);
    EXPECT_EQ(LLVMFuzzerTestOneInput(input.data(), input.size() / 2), 0);
    ++inputs;
  }
  EXPECT_GE(inputs, 5);
}

}  // namespace
}  // namespace landfix::tests
