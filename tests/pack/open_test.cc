// Opening: mapped, copied, from memory; what is refused before any byte is believed.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "tests/pack/small_map.h"

namespace landfix::tests {
namespace {

Read read_whole(const Pack& pack) { return read(pack, *pack.box(0, kWestM, kSouthM, kEastM, kNorthM, 1)); }

TEST(Open, MappedCopiedAndFromMemoryAreTheSame) {
  const TemporaryFolder folder;
  const std::string path = folder.file("small.lfpack");
  const std::vector<uint8_t> bytes = small_pack();
  write_file(path, bytes);
  const auto mapped = Pack::open(path.c_str());
  const auto copied = Pack::open(path.c_str(), {.copy = true});
  const OpenPack borrowed(bytes);
  ASSERT_TRUE(mapped);
  ASSERT_TRUE(copied);
  ASSERT_EQ(borrowed.status(), LF_OK);
  const Read expected = read_whole(*mapped);
  ASSERT_EQ(expected.status, LF_OK);
  EXPECT_EQ(read_whole(*copied).pixels, expected.pixels);
  EXPECT_EQ(read_whole(*borrowed).pixels, expected.pixels);
}

TEST(Open, ACopyOutlivesItsFile) {
  const TemporaryFolder folder;
  const std::string path = folder.file("small.lfpack");
  write_file(path, small_pack());
  const auto copied = Pack::open(path.c_str(), {.copy = true});
  ASSERT_TRUE(copied);
  ASSERT_EQ(truncate(path.c_str(), 0), 0);  // a mapping would now end in SIGBUS
  EXPECT_EQ(read_whole(*copied).pixels[0], pattern({'a', 0, 0, 0, 0}));
}

TEST(Open, RefusesWhatIsNoFileOfOurs) {
  const TemporaryFolder folder;
  EXPECT_EQ(Pack::open(folder.file("missing").c_str()).status(), LF_IO);
  EXPECT_EQ(Pack::open(std::filesystem::path(folder.file("x")).parent_path().c_str()).status(),
            LF_NOT_A_PACK);  // a folder
  const std::string pipe = folder.file("pipe");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(Pack::open(pipe.c_str()).status(), LF_NOT_A_PACK);  // must not wait for a writer
  const std::string path = folder.file("other");
  for (const bool copy : {false, true}) {
    write_file(path, {});
    EXPECT_EQ(Pack::open(path.c_str(), {.copy = copy}).status(), LF_NOT_A_PACK);
    const std::string text = "GIF89a, or anything else that is not a pack";
    write_file(path, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
    EXPECT_EQ(Pack::open(path.c_str(), {.copy = copy}).status(), LF_NOT_A_PACK);
    write_file(path, std::vector<uint8_t>{0x89, 'L', 'F', 'P'});
    EXPECT_EQ(Pack::open(path.c_str(), {.copy = copy}).status(), LF_NOT_A_PACK);
  }
  // The magic is what a text-mode transfer breaks.
  std::vector<uint8_t> text_mode = small_pack();
  text_mode.erase(text_mode.begin() + 4);  // "\r\n" became "\n"
  EXPECT_EQ(open_status(text_mode), LF_NOT_A_PACK);
  EXPECT_EQ(open_status({}), LF_INVALID_ARGUMENT);  // an empty vector has no address
}

TEST(Open, MemoryMustBeAligned) {
  std::vector<uint8_t> bytes = small_pack();
  bytes.insert(bytes.begin(), 0);
  lf_pack* pack = nullptr;
  EXPECT_EQ(lf_open_memory(bytes.data() + 1, bytes.size() - 1, nullptr, &pack), LF_INVALID_ARGUMENT);
  EXPECT_EQ(pack, nullptr);
}

TEST(Open, OptionsAreChecked) {
  const std::vector<uint8_t> bytes = small_pack();
  lf_pack* pack = nullptr;
  lf_open_options options{sizeof options - 1, 0, nullptr, 0};
  EXPECT_EQ(lf_open_memory(bytes.data(), bytes.size(), &options, &pack), LF_INVALID_ARGUMENT);
  options = {sizeof options, 0, nullptr, 1};  // keys promised, none given
  EXPECT_EQ(lf_open_memory(bytes.data(), bytes.size(), &options, &pack), LF_INVALID_ARGUMENT);
  options = {sizeof options + 64, 0, nullptr, 0};  // a caller built against a later header
  EXPECT_EQ(lf_open_memory(bytes.data(), bytes.size(), &options, &pack), LF_OK);
  lf_close(pack);
}

TEST(Open, EveryStatusHasItsSentence) {
  for (int s = LF_OK; s <= LF_END; ++s) {
    EXPECT_STRNE(lf_status_text(lf_status(s)), "unknown status") << s;
    for (int other = LF_OK; other < s; ++other)
      EXPECT_STRNE(lf_status_text(lf_status(s)), lf_status_text(lf_status(other)));
  }
  EXPECT_STREQ(lf_status_text(lf_status(99)), "unknown status");
  EXPECT_EQ(lf_abi_version(), uint32_t(LF_ABI_VERSION));
}

}  // namespace
}  // namespace landfix::tests
