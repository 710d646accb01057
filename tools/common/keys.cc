#include "tools/common/keys.h"

#include <sodium.h>

#include <fstream>
#include <sstream>

#include "builder/error.h"
#include "builder/hex.h"

namespace landfix::tools {
namespace {

constexpr char kPublicName[] = "landfix-public-key", kSecretName[] = "landfix-secret-key", kAlgorithm[] = "ed25519";

template <size_t kBytes>
std::array<uint8_t, kBytes> read_key(const std::string& path, const std::string& wanted) {
  std::ifstream file(path);
  if (!file) throw Error(ExitCode::kIo, path + ": the key file cannot be opened");
  std::string name, algorithm, digits;
  file >> name >> algorithm >> digits;
  std::array<uint8_t, kBytes> key;
  size_t length = 0;
  const bool parsed =
      sodium_hex2bin(key.data(), key.size(), digits.data(), digits.size(), nullptr, &length, nullptr) == 0;
  if (name != wanted || algorithm != kAlgorithm || !parsed || length != kBytes || digits.size() != 2 * kBytes)
    throw Error(ExitCode::kBadInput, path + ": expected one line '" + wanted + " " + kAlgorithm + " <" +
                                         std::to_string(2 * kBytes) + " hex digits>'" +
                                         (name.starts_with("landfix-") ? ", found a '" + name + "'" : "") +
                                         "; make a key pair with 'landfix keygen'");
  return key;
}

}  // namespace

PublicKey read_public_key(const std::string& path) { return read_key<32>(path, kPublicName); }
SecretKey read_secret_key(const std::string& path) { return read_key<64>(path, kSecretName); }

std::string public_key_line(const PublicKey& key) {
  return std::string(kPublicName) + " " + kAlgorithm + " " + hex(key) + "\n";
}
std::string secret_key_line(const SecretKey& key) {
  return std::string(kSecretName) + " " + kAlgorithm + " " + hex(key) + "\n";
}

}  // namespace landfix::tools
