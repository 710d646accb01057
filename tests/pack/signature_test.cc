// Signatures: a runtime that was given trusted keys refuses what they did not sign.
#include <gtest/gtest.h>

#include <cstring>

#include "tests/pack/patch.h"
#include "tests/pack/small_map.h"

namespace landfix::tests {
namespace {

struct Key {
  PublicKey open;
  std::array<uint8_t, 64> secret;
  Key() { EXPECT_EQ(lf_keygen(open.data(), secret.data()), LF_OK); }
};

std::vector<uint8_t> signed_by(const Key& key, std::vector<uint8_t> bytes) {
  EXPECT_EQ(lf_sign_header(bytes.data(), key.secret.data()), LF_OK);
  return bytes;
}

Status open_with(std::vector<uint8_t> bytes, std::vector<PublicKey> keys) {
  return open_status(std::move(bytes), {.copy = false, .trusted_keys = std::move(keys)});
}

// Changes a signed header and makes its header hash right again, as a forger would.
template <typename Change>
std::vector<uint8_t> forged(std::vector<uint8_t> bytes, Change change) {
  Patch patch(std::move(bytes));
  change(patch.header());
  patch.rehash_header();
  return std::move(patch.bytes());
}

TEST(Signature, OpensForTheSignersKeyOnly) {
  const Key alice, bob;
  const std::vector<uint8_t> bytes = signed_by(alice, small_pack());
  EXPECT_EQ(open_with(bytes, {alice.open}), LF_OK);
  EXPECT_EQ(open_with(bytes, {bob.open, alice.open}), LF_OK);
  EXPECT_EQ(open_with(bytes, {bob.open}), LF_UNTRUSTED);
  EXPECT_EQ(open_with(bytes, {}), LF_OK);
}

TEST(Signature, MissingWhereKeysAreGiven) {
  const Key alice;
  EXPECT_EQ(open_with(small_pack(), {alice.open}), LF_UNSIGNED);
  EXPECT_EQ(open_with(small_pack(), {}), LF_OK);
}

TEST(Signature, WrongInEveryWay) {
  const Key alice, bob;
  const std::vector<uint8_t> good = signed_by(alice, small_pack());
  for (const size_t byte : {0, 31, 32, 63}) {
    const auto bytes = forged(good, [&](schema::Header& h) { h.signature[byte] ^= 1; });
    EXPECT_EQ(open_with(bytes, {alice.open}), LF_UNTRUSTED) << byte;
    EXPECT_EQ(open_with(bytes, {}), LF_OK) << "without keys the signature is ignored";
  }
  // Signed by Bob, says that Alice did.
  const auto claimed = forged(signed_by(bob, small_pack()),
                              [&](schema::Header& h) { std::memcpy(h.public_key, alice.open.data(), 32); });
  EXPECT_EQ(open_with(claimed, {alice.open}), LF_UNTRUSTED);
  EXPECT_EQ(open_with(forged(good, [](schema::Header& h) { h.signature_kind = 2; }), {alice.open}), LF_UNTRUSTED);
  EXPECT_EQ(open_with(forged(good, [](schema::Header& h) { h.signature_kind = 0; }), {alice.open}), LF_UNSIGNED);
  EXPECT_EQ(open_with(forged(good, [](schema::Header& h) { std::memset(h.signature, 0, 64); }), {alice.open}),
            LF_UNTRUSTED);
}

TEST(Signature, CoversTheWholeMap) {
  const Key alice;
  const std::vector<uint8_t> good = signed_by(alice, small_pack());
  // One pixel changed and every hash above it made right again: the root is another one.
  Patch pixel(good);
  pixel.data(pixel.tiles(pixel.blocks()[0])[0])[0] ^= 1;
  pixel.rehash();
  EXPECT_EQ(open_with(pixel.bytes(), {}), LF_OK);
  EXPECT_EQ(open_with(pixel.bytes(), {alice.open}), LF_UNTRUSTED);
  // The version and the manifest are covered as well.
  EXPECT_EQ(open_with(forged(good, [](schema::Header& h) { h.version_minor = 1; }), {alice.open}), LF_UNTRUSTED);
  Patch manifest(good);
  const std::vector<uint8_t> same(manifest.manifest().begin(), manifest.manifest().end());
  manifest.replace_manifest(same);
  manifest.rehash_header();
  EXPECT_EQ(open_with(manifest.bytes(), {alice.open}), LF_UNTRUSTED);
}

TEST(Signature, ChangesNothingElse) {
  const Key alice;
  const std::vector<uint8_t> before = small_pack(), after = signed_by(alice, before);
  ASSERT_EQ(before.size(), after.size());
  for (size_t i = 0; i < before.size(); ++i) {
    const bool slot = (i >= 160 && i < 164) || (i >= 168 && i < 264) || (i >= 4064 && i < 4096);
    if (!slot) {
      ASSERT_EQ(before[i], after[i]) << i;
    }
  }
  const OpenPack pack(after);
  EXPECT_EQ(pack->info().is_signed, 1);
  EXPECT_EQ(std::memcmp(pack->info().public_key, alice.open.data(), 32), 0);
  EXPECT_TRUE(pack->verify(true));
}

TEST(Signature, RefusesToSignWhatIsNoHeader) {
  const Key alice;
  std::vector<uint8_t> bytes = small_pack();
  EXPECT_EQ(lf_sign_header(nullptr, alice.secret.data()), LF_INVALID_ARGUMENT);
  EXPECT_EQ(lf_sign_header(bytes.data(), nullptr), LF_INVALID_ARGUMENT);
  EXPECT_EQ(lf_keygen(nullptr, nullptr), LF_INVALID_ARGUMENT);
  bytes[100] ^= 1;
  EXPECT_EQ(lf_sign_header(bytes.data(), alice.secret.data()), LF_DAMAGED);
  bytes[0] ^= 1;
  EXPECT_EQ(lf_sign_header(bytes.data(), alice.secret.data()), LF_NOT_A_PACK);
  std::vector<uint8_t> newer = forged(small_pack(), [](schema::Header& h) { h.version_major = 2; });
  EXPECT_EQ(lf_sign_header(newer.data(), alice.secret.data()), LF_UNKNOWN_VERSION);
}

}  // namespace
}  // namespace landfix::tests
